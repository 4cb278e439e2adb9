"""What goes wrong while a run goes on, and with what it leaves behind."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from here import Here, dotted

from billow.case.schema import Case
from billow.parts.layers.parting import Parting
from billow.results import ownership, run_file
from billow.results.dataset import Dataset
from billow.results.floor_file import read_floor
from billow.results.histories import read_histories
from billow.results.ownership import owned
from billow.results.result import Result
from billow.results.vtkhdf import FabricFile
from billow.run.simulate import resume, simulate
from trust import injections as inject
from trust.faults import SOUND, changed

THROWN_PAST_THE_BAG = {
    "shape": "super-ellipsoid", "radii": 0.05, "clearance": 0.0, "offset": [0.5, 0.0], "locked": False, "slope": 1.0,
    "velocity": [0.0, 0.0, -80.0],
}  # fmt: skip


def spoilt(spoil: Callable, **changes) -> Callable[[Here], object]:
    """Run a sound case in a spoilt solver."""

    def trigger(here: Here):
        with spoil():
            simulate(Case.from_dict(changed(SOUND, dotted(changes))), here.place / "run", threads=1)

    return trigger


def without_xarray(here: Here):
    here.patch.setitem(sys.modules, "xarray", None)
    Result.open(here.bench.run).to_xarray()


def collapsing():
    return inject.at_every_step(lambda state: setattr(state.fabric, "squared_rate", 1e40))


def tearing():
    def damage(state):
        state.ledger.largest_energy = 1e12  # so that the energy of the tear is no news
        state.positions[100, 2] += 0.3

    return inject.at_step(50, damage)


def losing_a_particle():
    def damage(state):
        state.gas.content.particles.velocity[0, 0] = float("nan")

    return inject.at_step(20, damage)


def node_far_away():
    def damage(state):
        state.positions[0] += 1e5

    return inject.at_step(20, damage)


def gas_without_energy():
    def damage(state):
        state.gas.content.sheets[0].held[:, -1] *= -1.0

    return inject.at_step(20, damage)


def bag_turned_inside_out():
    def damage(state):
        state.positions[:, 2] *= -1.0

    return inject.at_step(20, damage)


@contextlib.contextmanager
def layers_that_do_not_part():
    """A step in which every try asks for faster nodes, and for a wider list."""

    def run(self) -> bool:
        self.step.velocities[0] += 1e6
        return False

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Parting, "run", run)
        yield


def changed_file(name: str, load: Callable[[Path], object]) -> Callable[[Here], object]:
    def trigger(here: Here):
        run = here.run()
        (run / name).write_bytes((run / name).read_bytes()[:-9] + b"x")
        return load(run)

    return trigger


def other_format(here: Here):
    run = here.run()
    here.patch.setattr(run_file, "FORMAT", 3)
    run_file.write_run_file(run, {"status": "completed"})
    here.patch.setattr(run_file, "FORMAT", 2)
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


def two_at_once(here: Here):
    with owned(here.place / "run.partial"):
        simulate(here.bench.case, here.place / "run")


def without_locks(here: Here):
    def refuse(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    told = []
    here.patch.setattr(fcntl, "flock", refuse)
    here.patch.setattr(ownership, "print", lambda concern, file: told.append(concern), raising=False)
    with owned(here.place / "run.partial"):
        return told[0]


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GEO-001": spoilt(inject.hole),
    "E-GEO-002": spoilt(inject.flipped_triangle),
    "E-GEO-003": spoilt(inject.reversed_normals),
    "E-GEO-004": spoilt(inject.degenerate_reference),
    "E-NUM-001": spoilt(inject.nan_position),
    "E-NUM-002": spoilt(inject.hot_gas),
    "E-NUM-003": spoilt(inject.kicked_node),
    "E-NUM-004": spoilt(collapsing),
    "E-NUM-005": spoilt(tearing),
    "E-NUM-006": spoilt(contextlib.nullcontext, obstacles__1__slope=1.0),
    "E-NUM-008": spoilt(losing_a_particle, gas={"model": "corpuscular", "particles": 2000}),
    "E-NUM-010": spoilt(contextlib.nullcontext, obstacles__0__slope=1.0, obstacles__1=THROWN_PAST_THE_BAG),
    "E-NUM-011": spoilt(layers_that_do_not_part, fabric__self_contact="layers"),
    "E-NUM-020": spoilt(node_far_away, gas={"model": "mesh", "cell": 0.1}),
    "E-NUM-021": spoilt(gas_without_energy, gas={"model": "mesh", "cell": 0.1}),
    "E-NUM-009": spoilt(bag_turned_inside_out),
    "E-RES-170": lambda here: read_floor(here.write("floor.json", "{}").parent, np.ones(2)),
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
    "E-RES-023": two_at_once,
    "E-RES-024": lambda here: simulate(here.bench.case, here.write("run.partial", "mine").with_suffix("")),
    "E-RES-025": lambda here: simulate(here.bench.case, here.place / "none" / ".."),
    "E-RES-030": left_behind("journal.bin", lambda data: data[:1000]),
    "E-RES-031": left_behind("checkpoint_a.safetensors", lambda data: data[:-9]),
    "E-RES-032": left_behind("checkpoint_a.safetensors", None),
    "E-RES-034": without_xarray,
    "E-RES-033": left_behind("case.toml", lambda data: b"[" + data),
    "W-RES-001": without_locks,
}
