"""A study: many runs of one case that differ in the values of a few parameters."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from billow.base.errors import InputError, IntegrityError
from billow.results.atomic import write_atomically
from billow.results.dataset import Dataset
from billow.results.dataset_files import read_design, read_split, write_design, write_split
from billow.results.ownership import LOCK, discard, owned
from billow.run.case_folder import keep_case
from billow.study.attempt import Runner, cannot_write
from billow.study.corners import build_corners, check_values, meshed_once, vary
from billow.study.definition import StudyDefinition
from billow.study.design import Design, Values, draw
from billow.study.drive import Drive, ProgressEvent, StudySummary
from billow.study.grow import ANOTHER_STUDY, added_designs_text, grown, merged, read_added_designs
from billow.study.readable import require_readable
from billow.study.store import RunStore

NO_STUDY = InputError.declare(
    "E-STU-009",
    "the folder holds no study",
    where="{folder}",
    why="study.toml is missing",
    remedy="make it: billow study STUDY.toml --out FOLDER",
)
CONTRADICTION = IntegrityError.declare(
    "E-STU-020",
    "the files of the study contradict each other",
    where="{folder}",
    why="split.toml names runs that design.csv does not have: {runs}",
    cause="design.csv or split.toml was changed",
    remedy="restore design.csv and split.toml, or make the study again in a new folder",
)
UNUSABLE_WORKERS = InputError.declare(
    "E-STU-021",
    "cannot use workers = {workers}",
    where="Study.run",
    why="workers counts local processes, at least 1; a cluster brings its own",
    remedy="give workers or a scheduler address, or neither for one worker on each core",
)

STUDY_FILE, CASE_FILE, ADDED_FILE = "study.toml", "case.toml", "added_designs.csv"


class Study:
    """Runs around one case, drawn, made and kept in one folder.

        study = Study.create("study.toml", "my_study")
        study.run()
        dataset = study.dataset()

    A script that calls `run` with more than one worker needs `if __name__ == "__main__":` around it, because worker
    processes import the script.

    folder; definition; design, and its train, test: run -> value of each parameter in its unit; runs: both.
    """

    def __init__(self, folder: Path, definition: StudyDefinition, design: Design, case):
        self.folder, self.definition, self.design, self._case = folder, definition, design, case
        self.train, self.test, self.runs = design.train, design.test, design.runs
        self.store = RunStore(folder)

    @classmethod
    def create(cls, definition_file: str | Path, folder: str | Path) -> Study:
        """Draw the designs of a study and write them to `folder`; if it holds this study already, open it.

        A study that asks for more training runs than `folder` has, by `train` or `added_designs`, adds them to those
        there; its test runs never change. Before anything is written, every design is tried on the case, and models are
        built at the ends of each range and at some corners of the design space.
        InputError E-STU-001 to -006: the definition; -024: its added designs; -007: the case does not accept a value;
        -040: a parameter changes mesh or times; -042, E-DES-002, E-INJ-003: no run would hold a response; -008:
        `folder` holds something else; -025: `train` cannot grow to this number; E-RES-023: another process makes the
        study, or runs the one that is to grow. ResourceError E-STU-012, -023: it cannot be written.
        """
        definition_file, folder = Path(definition_file), Path(folder).absolute()  # "." has a name only in full
        definition = StudyDefinition.load(definition_file)
        case = meshed_once(_load_case(definition_file.parent / definition.case), definition)
        check_values(definition_file, definition, case)
        table, added = definition.added_designs, []
        if table:
            added = read_added_designs(definition_file.parent / table, definition.axes, definition.constraints)
        # Inside the study's folder its files have names of their own.
        definition = definition.model_copy(update={"case": CASE_FILE, "added_designs": table and ADDED_FILE})
        try:
            study = None if _may_become_a_study(folder) else _open_for(definition, case, folder)
            if study is None:
                build_corners(definition_file, definition, case, _outline)
            if study is not None and study.definition.added_designs:  # what was added meanwhile stays
                kept = read_added_designs(folder / ADDED_FILE, study.definition.axes)
                added = [*kept, *(row for row in added if row not in kept)]
                definition = definition.model_copy(update={"added_designs": ADDED_FILE})
            if study is not None:
                definition = merged(study.definition, definition, folder)
            existing = study.design if study else draw(definition)
            design = grown(existing, definition, added, folder)
            for run in design.runs.keys() - (study.runs.keys() if study else ()):
                vary(case, definition.variables, design.runs[run], f"{definition_file}: run {run} of its design")
            if definition.responses and (study is None or definition.responses != study.definition.responses):
                first = vary(
                    case, definition.variables, next(iter(design.runs.values())), f"{definition_file}: a design"
                )
                require_readable(definition_file, definition.responses, _recorded(first))
            if study is None:
                fresh = not folder.exists()
                with owned(folder):
                    raced = (folder / STUDY_FILE).exists()
                    try:
                        if not raced:
                            _write(folder, case, definition, added, design)
                    except BaseException:
                        if fresh:
                            discard(folder)
                        raise
                if raced:  # another process has just made it
                    return cls.create(definition_file, folder)
            elif design != existing or definition != study.definition:
                with study.store.driving():
                    _write(folder, case, definition, added, design)
        except OSError as problem:
            raise cannot_write(problem, folder) from problem
        return cls.open(folder)

    @classmethod
    def open(cls, folder: str | Path) -> Study:
        """Open a study that was created before. InputError E-STU-009 if `folder` holds none."""
        folder = Path(folder)
        if not (folder / STUDY_FILE).is_file():
            raise NO_STUDY(folder=folder)
        definition = StudyDefinition.load(folder / STUDY_FILE)
        runs, (train, test) = read_design(folder, definition.axes), read_split(folder)
        unknown = sorted({*train, *test} - set(runs))
        if unknown:
            raise CONTRADICTION(folder=folder, runs=", ".join(unknown[:3]))
        design = Design({run: runs[run] for run in train}, {run: runs[run] for run in test})
        return cls(folder, definition, design, _load_case(folder / CASE_FILE))

    def __repr__(self) -> str:
        return f"Study({str(self.folder)!r}, train={len(self.train)}, test={len(self.test)})"

    def case(self, run: str):
        """The `billow.Case` of one run."""
        return vary(self._case, self.definition.variables, self.runs[run], f"{self.folder}: run {run}")

    def with_run(self, values: Values) -> tuple[Study, str]:
        """The study with one more training design, kept in its folder, and the name of that run; a design that it has
        already adds none. InputError E-STU-007: the case does not accept it; E-RES-023: another process runs it."""
        for run, known in self.runs.items():
            if known == values:
                return self, run
        vary(self._case, self.definition.variables, values, f"{self.folder}: an added design")
        table = self.folder / ADDED_FILE
        added = read_added_designs(table, self.definition.axes) if self.definition.added_designs else []
        added.append(tuple(values))
        definition = self.definition.model_copy(update={"added_designs": ADDED_FILE})
        design = grown(self.design, definition, added, self.folder)
        with self.store.driving():
            _write(self.folder, self._case, definition, added, design)
        return Study.open(self.folder), list(design.train)[-1]

    def dataset(self) -> Dataset:
        """The runs made so far, as what a surrogate learns from; errors as `Dataset.open`."""
        return Dataset.open(self.folder)

    def run(
        self,
        workers: int | None = None,
        scheduler: str | None = None,
        progress: Callable[[ProgressEvent], None] | None = None,
        *,
        retry_failed: bool = False,
        runner: Runner | None = None,
    ) -> StudySummary:
        """Make the runs that are missing. May be interrupted in any way at any moment, and called again.

        workers: local processes, each making one run at a time on one core; all cores by default, 1 is this process
        itself. Runs that are fewer than these cores share them. scheduler: address of a Dask cluster to use instead.
        progress: called with each `ProgressEvent`. retry_failed: make runs again that failed before. runner: what makes
        a run, `billow.run.simulate` by default.

        A run that fails is recorded in failed/ and the others go on. InputError E-RES-023: another process runs this
        study; E-STU-015: no scheduler answers; -021: workers. IntegrityError E-STU-010: a run on disk belongs to
        another case; -011: runs differ in mesh or times. ResourceError E-STU-012: disk full; -023: no permission;
        -017, -018: the cluster.
        """
        if (workers is not None and workers < 1) or (workers is not None and scheduler is not None):
            raise UNUSABLE_WORKERS(workers=f"{workers} together with a scheduler" if scheduler else workers)
        try:
            with self.store.driving():
                return Drive(self, progress or (lambda event: None), retry_failed).go(workers, scheduler, runner)
        except OSError as problem:  # of this process; those of workers come as outcomes
            raise cannot_write(problem, self.folder) from problem


def _load_case(path: Path):
    from billow.case.schema import Case

    return Case.load(path)


def _outline(case):
    from billow.run.check import outline

    return outline(case)


def _recorded(case):
    from billow.run.check import recorded

    return recorded(case)


def _may_become_a_study(folder: Path) -> bool:
    """Whether a folder is missing or empty, or one whose study was not written to the end."""
    if not folder.is_dir():
        return not os.path.lexists(folder)
    names = os.listdir(folder)  # once: another process may be making it
    return STUDY_FILE not in names and (LOCK in names or not names)


def _open_for(definition: StudyDefinition, case, folder: Path) -> Study:
    """The study in a folder that is not empty. InputError E-STU-008 if it holds none, or one around another case."""
    try:
        study = Study.open(folder)
    except (OSError, ValueError, InputError) as error:
        why = getattr(error, "what", error)
        raise ANOTHER_STUDY(folder=folder, why=f"no study can be read there: {why}") from error
    if study._case.digest() != case.digest():
        raise ANOTHER_STUDY(folder=folder, why=f"its {CASE_FILE} differs from the study asked for")
    return study


def _write(folder: Path, case, definition: StudyDefinition, added: list[Values], design: Design) -> None:
    """Write the files of a study, new or grown.

    Designs first, then the split that names them, then study.toml: a crash in between leaves the study as it was, or
    one whose runs are all there already when the same command comes again.
    """
    write_design(folder, definition.axes, design.runs)
    write_split(folder, list(design.train), list(design.test))
    if added:
        write_atomically(folder / ADDED_FILE, added_designs_text(definition.axes, added))
    keep_case(case, folder)
    write_atomically(folder / STUDY_FILE, definition.to_toml())
