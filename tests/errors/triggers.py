"""For every code, the smallest thing a user, a disk or a cluster can do that brings it about.

Each function raises the error, or returns what a study has recorded, or returns a warning. `here` offers a folder,
sound files (`here.bench`) and `here.patch`, pytest's monkeypatch.
"""

from __future__ import annotations

import builtins
import contextlib
import dataclasses
import errno
import io
import json
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from billow import cli
from billow.case.build import build_model
from billow.case.plausibility import warnings
from billow.case.schema import Case
from billow.check import describe
from billow.results import run_file
from billow.results.dataset import Dataset
from billow.results.dataset_files import Parameter
from billow.results.histories import read_histories
from billow.results.result import Result
from billow.results.vtkhdf import FabricFile
from billow.rom import basis
from billow.rom.evaluate import evaluate
from billow.rom.snapshots import collect
from billow.rom.surrogate import Surrogate
from billow.simulate import resume, simulate
from billow.study import drive
from billow.study.study import Study
from trust import injections as inject
from trust.faults import SOUND, changed
from trust.fuzz_inputs import Bench
from trust.small_surrogate import small_surrogate


@dataclasses.dataclass
class Here:
    """Where a trigger works."""

    place: Path
    bench: Bench
    patch: object

    def study(self) -> Study:
        """A copy of the sound study."""
        return Study.open(shutil.copytree(self.bench.study.folder, self.place / "study"))

    def run(self) -> Path:
        """A copy of a sound run."""
        return shutil.copytree(self.bench.run, self.place / "run")

    def interrupted(self) -> Path:
        """A copy of an interrupted run, to be resumed as `place`/run."""
        return shutil.copytree(self.bench.interrupted, self.place / "run.partial")

    def write(self, name: str, text: str | bytes) -> Path:
        path = self.place / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    def study_file(self, old: str = "", new: str = "", **case) -> Path:
        """A study file with a text replaced, beside a case."""
        self.write("case.toml", Case.from_dict(changed(SOUND, _dotted(case))).to_toml())
        assert old in self.bench.study_text
        return self.write("definition.toml", self.bench.study_text.replace(old, new, 1))


@dataclasses.dataclass
class Told:
    """A message that reached the user in another way than as an exception."""

    code: str
    what: str
    where: str
    why: str
    remedy: str


# --- cases ----------------------------------------------------------------------------------------------------------


def case(**changes) -> Callable[[Here], object]:
    """Check a case with these keys (`__` for a dot) changed."""
    return lambda here: describe(Case.from_dict(changed(SOUND, _dotted(changes))))


def warns(code: str, **changes) -> Callable[[Here], object]:
    def trigger(here: Here):
        odd = Case.from_dict(changed(SOUND, _dotted(changes)))
        assert f"{code} warning: " in describe(odd)
        return next(warning for warning in warnings(odd, build_model(odd)) if warning.code == code)

    return trigger


def spoilt(spoil: Callable, **changes) -> Callable[[Here], object]:
    """Run a sound case in a spoilt solver."""

    def trigger(here: Here):
        with spoil():
            simulate(Case.from_dict(changed(SOUND, _dotted(changes))), here.place / "run", threads=1)

    return trigger


def _dotted(changes: dict) -> dict:
    return {key.replace("__", "."): value for key, value in changes.items()}


def collapsing():
    return inject.at_every_step(lambda state: setattr(state, "largest_stretch", 1e6))


def tearing():
    def damage(state):
        state.ledger.largest_energy = 1e12  # so that the energy of the tear is no news
        state.positions[100, 2] += 0.3

    return inject.at_step(50, damage)


# --- the command line -------------------------------------------------------------------------------------------------


def command(*arguments: str) -> Told:
    """What `billow ARGUMENTS` prints when it fails."""
    before, printed = sys.argv, io.StringIO()
    sys.argv = ["billow", *arguments]
    try:
        with contextlib.redirect_stderr(printed), contextlib.suppress(SystemExit):
            cli.main()
    finally:
        sys.argv = before
    said = re.fullmatch(r"(\S+) error: (.*)\n  where: (.*)\n  why:   (.*)\n  try:   (.*)\n", printed.getvalue())
    assert said, printed.getvalue()
    return Told(*said.groups())


def demo_over_another(here: Here) -> Told:
    here.write("case.toml", "title = 'mine'\n")
    return command("demo", "--out", str(here.place))


def prediction_over_a_file(here: Here) -> Told:
    taken = here.write("taken.vtkhdf", "mine")
    settings = ["--set", "permeability=0.03", "--set", "temperature=600"]
    return command("predict", str(here.bench.surrogate), *settings, "--out", str(taken))


def bug_in_a_command(here: Here) -> Told:
    here.patch.setattr("billow.check.describe", lambda case: 1 / 0)
    here.patch.setattr("tempfile.tempdir", str(here.place))
    told = command("check", str(here.bench.place / "case.toml"))
    assert "ZeroDivisionError" in next(here.place.glob("billow-report-*")).read_text()
    return told


# --- runs -------------------------------------------------------------------------------------------------------------


def changed_file(name: str, load: Callable[[Path], object]) -> Callable[[Here], object]:
    def trigger(here: Here):
        run = here.run()
        (run / name).write_bytes((run / name).read_bytes()[:-9] + b"x")
        return load(run)

    return trigger


def other_format(here: Here):
    run = here.run()
    here.patch.setattr(run_file, "FORMAT", 2)
    run_file.write_run_file(run, {"status": "completed"})
    here.patch.setattr(run_file, "FORMAT", 1)
    Result.open(run)


def missing_file(here: Here):
    run = here.run()
    (run / "histories.csv").unlink()
    Result.open(run)


def forged_case(here: Here):
    run = here.run()
    (run / "case.toml").write_text("title =")
    run_file.write_run_file(run, {"status": "completed", "case_digest": "", "wall_seconds": 1.0, "ledger": {}})
    return Result.open(run).case_toml


def other_mesh(here: Here):
    study = here.study()
    path = study.folder / "dataset.toml"
    path.write_text(re.sub('mesh_sha256 = ".', 'mesh_sha256 = "x', path.read_text()))
    study.dataset().snapshots("displacement", ["0000"])


def damaged_design(here: Here):
    folder = here.study().folder
    (folder / "design.csv").write_text("run\n")
    Dataset.open(folder)


def left_behind(name: str, damage: Callable[[bytes], bytes] | None) -> Callable[[Here], object]:
    """Resume an interrupted run one of whose files is damaged, or gone."""

    def trigger(here: Here):
        path = here.interrupted() / name
        path.unlink() if damage is None else path.write_bytes(damage(path.read_bytes()))
        resume(here.place / "run", threads=1)

    return trigger


# --- studies ----------------------------------------------------------------------------------------------------------


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


def varied_mesh(here: Here):
    definition = here.study_file('low = 0.02\nhigh = 0.035\nkeys = ["fabric.permeability"]',
                                 'low = 0.6\nhigh = 0.8\nkeys = ["bag.diameter"]', run__end_time=1e-4)  # fmt: skip
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


def driven_twice(here: Here):
    study = here.study()
    with study.store.driving():
        study.run(workers=1)


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


# --- surrogates -------------------------------------------------------------------------------------------------------

ANSWERABLE = {"permeability": 0.03, "temperature": 600.0}


def ask(design=ANSWERABLE, **options) -> Callable[[Here], object]:
    return lambda here: Surrogate.load(here.bench.surrogate).predict(design, **options)


ONE = (Parameter("a", "A", "-", 0.0, 1.0),)


def dataset(parameters=ONE, shape: float = 0.0, train=("0000",)) -> SimpleNamespace:
    """What a surrogate learns from, in memory."""
    return SimpleNamespace(
        title="Made up", parameters=parameters, times=np.array([0.1, 0.2]), reference=np.zeros((4, 3), np.float32),
        triangles=np.array([[0, 1, 2]]), train=train, test=(), trusted=train,
        design=lambda runs: np.zeros((len(runs), len(parameters))),
        snapshots=lambda field, runs: np.full((len(runs), 2, 4, 3), shape, np.float32),
    )  # fmt: skip


def without_torch(here: Here):
    def missing(name, *arguments, **options):
        if name == "torch":
            raise ModuleNotFoundError("No module named 'torch'")
        return imported(name, *arguments, **options)

    imported = builtins.__import__
    here.patch.setattr(builtins, "__import__", missing)
    here.patch.delitem(sys.modules, "billow.rom.network", raising=False)
    here.patch.delattr("billow.rom.network", raising=False)
    Surrogate.train(dataset())


def one_network_each(here: Here):
    made = small_surrogate()
    single = dataclasses.replace(made.regression, recipe="paper")
    dataclasses.replace(made, regression=single).spread(ANSWERABLE)


def bad_factors(here: Here):
    here.patch.setattr(basis, "_orthonormal", lambda matrix: np.linalg.qr(matrix.astype(float))[0] * 1.1)
    basis.pod(np.random.default_rng(1).normal(size=(6, 5)).astype(np.float32), 2)


def diverging(here: Here):
    from billow.rom import network

    network.train_shared(np.ones((8, 3), np.float32), np.full((8, 2), np.nan, np.float32), epochs=1)


def no_test_runs(here: Here):
    made = small_surrogate()
    own = dataset(made.parameters, train=("0000", "0001"))
    own.times, own.reference, own.triangles = made.times, made.reference, made.triangles
    evaluate(own, made)


# --- the table --------------------------------------------------------------------------------------------------------

TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-CASE-001": lambda here: Case.load(here.place / "none.toml"),
    "E-CASE-002": lambda here: Case.load(here.write("case.toml", "title =")),
    "E-CASE-003": case(bag__diametre=0.7),
    "E-CASE-004": case(inflator__mass_flow={"time": [0.0, 0.05]}),
    "E-CASE-005": case(fabric__thickness=0.3),
    "E-CASE-006": lambda here: Case.from_dict(SOUND).vary({"obstacles.sphere.degree": 3.0}),
    "E-CLI-001": lambda here: command("check", str(here.bench.place / "case.toml"), "--set", "permeability"),
    "E-CLI-002": demo_over_another,
    "E-CLI-003": lambda here: command("check"),
    "E-CLI-004": prediction_over_a_file,
    "E-CLI-005": lambda here: command("demo", "--out", str(here.write("file", "") / "below")),
    "E-CLI-030": lambda here: command("verify", "X9"),
    "E-CLI-070": bug_in_a_command,
    "E-GAS-001": case(inflator__gas={"xenon": 1.0}),
    "E-GEO-001": spoilt(inject.hole),
    "E-GEO-002": spoilt(inject.flipped_triangle),
    "E-GEO-003": spoilt(inject.reversed_normals),
    "E-GEO-004": spoilt(inject.degenerate_reference),
    "E-GEO-010": case(bag__straps__stitch_radius=0.5),
    "E-GEO-011": case(bag__element_size=5e-4),
    "E-GEO-020": case(obstacles__0__height=0.01),
    "E-GEO-021": case(bag__initial_gap=0.2, obstacles__1=inject.PEBBLE),
    "E-NUM-001": spoilt(inject.nan_position),
    "E-NUM-002": spoilt(inject.hot_gas),
    "E-NUM-003": spoilt(inject.kicked_node),
    "E-NUM-004": spoilt(collapsing),
    "E-NUM-005": spoilt(tearing),
    "E-NUM-006": spoilt(contextlib.nullcontext, obstacles__1__slope=1.0),
    "E-RES-001": lambda here: Result.open(here.place / "none"),
    "E-RES-002": lambda here: Result.open(here.place),
    "E-RES-003": changed_file("run.json", Result.open),
    "E-RES-004": changed_file("fabric.vtkhdf", Result.open),
    "E-RES-005": missing_file,
    "E-RES-006": other_format,
    "E-RES-007": lambda here: FabricFile(here.write("fabric.vtkhdf", "no HDF5")),
    "E-RES-008": lambda here: read_histories(here.write("histories.csv", "time [s],p [Pa]\n0.0\n")),
    "E-RES-009": lambda here: simulate(here.bench.case, here.run()),
    "E-RES-010": lambda here: Dataset.open(here.place),
    "E-RES-011": damaged_design,
    "E-RES-012": other_mesh,
    "E-RES-013": lambda here: here.bench.study.dataset().snapshots("velocity", ["0000"]),
    "E-RES-014": lambda here: here.bench.study.dataset().design(["9999"]),
    "E-RES-015": forged_case,
    "E-RES-020": spoilt(inject.full_disk),
    "E-RES-021": lambda here: resume(here.place / "none"),
    "E-RES-022": lambda here: simulate(here.bench.case, here.interrupted().with_suffix("")),
    "E-RES-030": left_behind("journal.bin", lambda data: data[:1000]),
    "E-RES-031": left_behind("checkpoint_a.safetensors", lambda data: data[:-9]),
    "E-RES-032": left_behind("checkpoint_a.safetensors", None),
    "E-RES-033": left_behind("case.toml", lambda data: data[:100]),
    "E-ROM-001": ask({"permeability": 0.03}),
    "E-ROM-002": ask({"permeability": 0.3, "temperature": 600.0}),
    "E-ROM-003": ask(times=[1.0]),
    "E-ROM-004": lambda here: Surrogate.load(here.write("s.safetensors", here.bench.surrogate.read_bytes()[:-9])),
    "E-ROM-005": lambda here: Surrogate.load(here.place / "none"),
    "E-ROM-006": without_torch,
    "E-ROM-007": lambda here: collect(dataset(), ()),
    "E-ROM-008": lambda here: Surrogate.train(dataset(), recipe="secret"),
    "E-ROM-009": lambda here: collect(dataset(shape=np.nan), ("0000",)),
    "E-ROM-010": lambda here: Surrogate.train(dataset((Parameter("a", "A", "-", 1.0, 1.0),))),
    "E-ROM-011": one_network_each,
    "E-ROM-012": lambda here: evaluate(dataset(), small_surrogate()),
    "E-ROM-013": bad_factors,
    "E-ROM-014": diverging,
    "E-ROM-015": no_test_runs,
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
    "E-STU-011": varied_mesh,
    "E-STU-012": failing_runs(full),
    "E-STU-013": driven_twice,
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
    "W-FAB-001": warns("W-FAB-001", fabric__young_warp=4e5, fabric__young_weft=4e5),
    "W-FAB-002": warns("W-FAB-002", fabric__thickness=3e-5),
    "W-FAB-003": warns("W-FAB-003", fabric__shear=1e10),
    "W-GAS-001": warns("W-GAS-001", run__end_time=0.002),
    "W-GAS-002": warns("W-GAS-002", inflator__mass_flow__time=[0, 2e-5, 8e-5]),
    "W-GAS-003": warns("W-GAS-003", inflator__mass_flow__value=[0, 0.0125, 0]),
    "W-GAS-004": warns("W-GAS-004", fabric__permeability=10.0),
    "W-GAS-005": warns("W-GAS-005", bag__vents__opening_pressure=0.3),
    "W-GAS-006": warns("W-GAS-006", inflator__jets__ring_radius=0.1),
    "W-MESH-001": warns("W-MESH-001", bag__element_size=0.12, bag__vents__count=0),
    "W-MESH-002": warns("W-MESH-002", bag__initial_gap=0.12),
    "W-MESH-003": warns("W-MESH-003", bag__straps__length=0.02),
    "W-OBS-001": warns("W-OBS-001", obstacles__1__clearance=0.9),
    "W-OBS-002": warns("W-OBS-002", obstacles__1__mass=0.0045),
    "W-OBS-003": warns("W-OBS-003", obstacles__1__slope=100.0),
}
