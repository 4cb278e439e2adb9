"""What is wrong with a study, its folder, its solver or its cluster."""

from __future__ import annotations

import contextlib
import errno
import json
import os
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from here import Here, Told

from billow.results import run_file
from billow.run.check import Outline
from billow.study import drive, study
from billow.study.floor import measure_floor
from billow.study.import_runs import import_runs
from billow.study.study import Study


def define(old: str = "", new: str = "", out: str = "out") -> Callable[[Here], object]:
    return lambda here: Study.create(here.study_file(old, new), here.place / out)


def other_study(here: Here):
    definition = here.study_file()
    Study.create(definition, here.place / "out")
    definition.write_text(here.bench.study_text.replace("seed = 1", "seed = 2"))
    Study.create(definition, here.place / "out")


def other_design(here: Here):
    folder = here.study().folder
    path = folder / "design.csv"
    head, first, *others = path.read_text().splitlines()
    number, _, *values = first.split(",")
    path.write_text("\n".join([head, ",".join([number, "0.0301", *values]), *others]) + "\n")
    Study.open(folder).run(workers=1)


def varied_mesh(here: Here, unseen: bool = False):
    """unseen: the corners of the design space are not built before, as by a case whose mesh file changes meanwhile."""
    if unseen:
        here.patch.setattr(study, "_outline", lambda case: Outline(1, 1, "", ()))
    definition = here.study_file('low = 0.02\nhigh = 0.035\nkeys = ["fabric.permeability"]',
                                 'low = 0.05\nhigh = 0.08\nkeys = ["bag.element_size"]',
                                 run__end_time=1e-4)  # fmt: skip
    definition = here.write("definition.toml", definition.read_text())
    Study.create(definition, here.place / "out").run(workers=1)


def fresh_study(here: Here) -> Study:
    """A study whose runs are all to be made."""
    return Study.create(here.study_file(), here.place / "out")


def failing_runs(fail: Callable) -> Callable[[Here], object]:
    """Run a study with a solver that fails; what was recorded of its first run."""

    def trigger(here: Here):
        study = fresh_study(here)
        study.run(workers=1, runner=fail)
        return recorded(study)

    return trigger


def recorded(study: Study) -> Told:
    record = json.loads((study.folder / "failed" / "0000.json").read_text())
    return Told(**{name: record[name] for name in ("code", "what", "where", "why", "remedy")})


def full(case, folder, *, threads):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def buggy(case, folder, *, threads):
    return {}["a bug"]


def stopping_quietly(case, folder, *, threads):
    """A solver of somebody else's, which publishes a stopped run and raises nothing."""
    folder.mkdir()
    for name in run_file.FILES:
        (folder / name).write_text("")
    run_file.write_run_file(
        folder, {"status": "stopped", "reason": "too fast", "case_digest": "", "wall_seconds": 1.0, "ledger": {}}
    )


def cluster_that(ends: Callable[[], tuple[str, BaseException | None]]) -> Callable[[Here], object]:
    """Run a study on a cluster all of whose futures end in this way."""

    def trigger(here: Here):
        import distributed

        def submit(*arguments, **options):
            status, problem = ends()
            return SimpleNamespace(status=status, exception=lambda: problem)

        class Ended(list):
            add = list.append

        class Future(SimpleNamespace):
            __hash__ = object.__hash__

        client = SimpleNamespace(submit=lambda *a, **k: Future(**vars(submit(*a, **k))), cancel=lambda futures: None)
        here.patch.setattr(distributed, "as_completed", Ended)
        here.patch.setattr(drive, "dask_client", lambda *arguments: contextlib.nullcontext(client))
        study = fresh_study(here)
        study.run(workers=2)
        return recorded(study)

    return trigger


def dead_worker():
    import distributed

    return "error", distributed.KilledWorker("run", SimpleNamespace(address="tcp://host:1"), 0)


def no_cluster(here: Here):
    import distributed

    def refuse(**options):
        raise RuntimeError("an attempt has been made to start a new process before bootstrapping has finished")

    here.patch.setattr(distributed, "LocalCluster", refuse)
    fresh_study(here).run(workers=2)


def unknown_run(here: Here):
    folder = here.study().folder
    (folder / "split.toml").write_text('train = ["0000", "9999"]\ntest = ["0003"]\n')
    Study.open(folder)


def grown(old: str, new: str) -> Callable[[Here], object]:
    """A study whose definition changes after it was made."""

    def trigger(here: Here):
        definition = here.study_file()
        Study.create(definition, here.place / "out")
        definition.write_text(definition.read_text().replace(old, new))
        return Study.create(definition, here.place / "out")

    return trigger


def foreign(here: Here, runs: str = "run,a [-]\nr0,0\nr1,1\nr2,2\n", **files):
    """Import three runs of NumPy arrays after some files were changed."""
    folder = here.place / "foreign"
    folder.mkdir()
    (folder / "runs.csv").write_text(runs)
    (folder / "times.csv").write_text("time [s]\n0\n0.1\n0.2\n")
    (folder / "triangles.csv").write_text("a,b,c\n0,1,2\n")
    arrays = {f"r{n}": np.zeros((3, 4, 3)) + np.eye(4, 3) for n in range(3)} | files
    for name, array in arrays.items():
        np.save(folder / f"{name}.npy", array)
    import_runs(folder, here.place / "imported")


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-STU-001": lambda here: Study.create(here.place / "none.toml", here.place / "out"),
    "E-STU-002": define("seed = 1", "seed ="),
    "E-STU-003": define("seed = 1", "seed = 1\nsede = 2"),
    "E-STU-004": define("train = 3", "train = 1"),
    "E-STU-005": define("seed = 1\n", ""),
    "E-STU-006": define("case.toml", "none.toml"),
    "E-STU-007": define("fabric.permeability", "fabric.permeabilty"),
    "E-STU-008": other_study,
    "E-STU-009": lambda here: Study.open(here.place),
    "E-STU-010": other_design,
    "E-STU-011": lambda here: varied_mesh(here, unseen=True),
    "E-STU-040": varied_mesh,
    "E-STU-041": define(
        "[[parameters]]", "[[constraints]]\nterms = {permeability = 1.0}\nat_least = 1.0\n[[parameters]]"
    ),
    "E-STU-042": define(
        "[[parameters]]", '[[responses]]\nname = "x"\nmeasure = "penetration"\nof = "y"\n[[parameters]]'
    ),
    "E-STU-012": failing_runs(full),
    "E-STU-014": failing_runs(stopping_quietly),
    "E-STU-015": lambda here: fresh_study(here).run(scheduler="nonsense://host"),
    "E-STU-016": failing_runs(buggy),
    "E-STU-017": cluster_that(lambda: ("cancelled", None)),
    "E-STU-018": cluster_that(lambda: ("error", ImportError("No module named 'billow'"))),
    "E-STU-019": cluster_that(dead_worker),
    "E-STU-020": unknown_run,
    "E-STU-021": lambda here: here.bench.study.run(workers=0),
    "E-STU-022": no_cluster,
    "E-STU-023": lambda here: Study.create(here.study_file(), here.write("file", "") / "below"),
    "E-STU-024": define("seed = 1", 'seed = 1\nadded_designs = "none.csv"'),
    "E-STU-025": grown("train = 3", "train = 4"),
    "E-STU-026": lambda here: foreign(here, "run,a\nr0,0\nr1,1\nr2,2\n"),
    "E-STU-027": lambda here: foreign(here, r1=np.full((3, 4, 3), np.nan)),
    "E-STU-028": lambda here: foreign(here, r1=np.ones((3, 5, 3)) * np.arange(5.0)[:, None]),
    "E-STU-170": lambda here: measure_floor(here.study().folder, 0),
    "E-STU-029": lambda here: foreign(here, triangles=np.array([[0, 1, 9]])),
}
