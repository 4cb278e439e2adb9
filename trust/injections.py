"""How faults get in where no case file can bring them: into the mesh, the solver, and files on disk."""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

import numpy as np

from billow.case import build
from billow.case.schema import Case
from billow.geometry.bag_shapes import BagShape
from billow.geometry.surface import Surface
from billow.results.journal import Journal
from billow.results.result import Result
from billow.run import recorder, simulate
from billow.solver import run as time_loop
from billow.solver.model import Model, State

PEBBLE = {"shape": "super-ellipsoid", "name": "impactor", "radii": 0.02, "clearance": 0.05}


# --- the mesh --------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def _shape(change: Callable[[BagShape], BagShape]) -> Iterator[None]:
    make = build.build_shape
    with mock.patch.object(build, "build_shape", lambda bag: change(make(bag))):
        yield


def _with_triangles(shape: BagShape, triangles: np.ndarray, kept: slice | np.ndarray = slice(None)) -> BagShape:
    old = shape.surface
    surface = Surface.build(triangles[kept], old.part[kept], old.part_names, old.node_count)
    return dataclasses.replace(
        shape, surface=surface, reference=shape.reference[kept], layers=shape.layers[kept], leak=shape.leak[kept]
    )


def reversed_normals():
    return _shape(lambda shape: _with_triangles(shape, shape.surface.triangles[:, ::-1]))


def flipped_triangle():
    def change(shape):
        triangles = shape.surface.triangles.copy()
        triangles[100] = triangles[100, ::-1]
        return _with_triangles(shape, triangles)

    return _shape(change)


def hole():
    return _shape(
        lambda shape: _with_triangles(shape, shape.surface.triangles, np.arange(shape.surface.triangle_count) != 100)
    )


def open_seam():
    """One node of the rim is there twice: once for the front, once for the rear."""

    def change(shape):
        old, rim = shape.surface, 5
        triangles = old.triangles.copy()
        rear = old.part != old.part_names.index("front")
        triangles[rear] = np.where(triangles[rear] == rim, old.node_count, triangles[rear])
        return dataclasses.replace(
            shape,
            surface=Surface.build(triangles, old.part, old.part_names, old.node_count + 1),
            positions=np.vstack([shape.positions, shape.positions[rim]]),
            fixed=np.append(shape.fixed, False),
        )

    return _shape(change)


def degenerate_reference():
    def change(shape):
        reference = shape.reference.copy()
        reference[100, 2] = 0.5 * (reference[100, 0] + reference[100, 1])
        return dataclasses.replace(shape, reference=reference)

    return _shape(change)


def mirrored_reference():
    """Two corners of one triangle exchange their places in the cut; of those of the front, the least equilateral."""

    def change(shape):
        reference = shape.reference.copy()
        edges = np.linalg.norm(reference - np.roll(reference, 1, axis=1), axis=2)
        worst = int(np.ptp(edges, axis=1)[shape.surface.triangles_of("front")].argmax())
        first = int(np.abs(edges[worst] - np.roll(edges[worst], -1)).argmax())
        pair = [first, (first + 1) % 3]
        reference[worst, pair] = reference[worst, pair[::-1]]
        return dataclasses.replace(shape, reference=reference)

    return _shape(change)


def stray_node():
    def change(shape):
        positions = shape.positions.copy()
        positions[100] *= 1000.0
        return dataclasses.replace(shape, positions=positions)

    return _shape(change)


# --- the solver ------------------------------------------------------------------------------------------------------


def large_step():
    limit = time_loop.stable_dt
    return mock.patch.object(time_loop, "stable_dt", lambda model, state: 4.0 * limit(model, state))


def at_every_step(damage: Callable[[State], None]):
    """Damage the state between all steps."""
    look = recorder.RunRecorder.step

    def step(self, model: Model, state: State) -> None:
        look(self, model, state)
        damage(state)

    return mock.patch.object(recorder.RunRecorder, "step", step)


def at_step(number: int, damage: Callable[[State], None]):
    """Damage the state once, after so many steps."""
    return at_every_step(lambda state: damage(state) if state.step == number else None)


def nan_position():
    return at_step(50, lambda state: state.positions.__setitem__((123, 1), np.nan))


def nan_gas():
    def damage(state):
        state.gas.content.energy *= np.nan

    return at_step(50, damage)


def hot_gas():
    def damage(state):
        state.gas.content.energy *= 30.0

    return at_step(50, damage)


def kicked_node():
    return at_step(50, lambda state: state.velocities.__setitem__((100, 2), 3000.0))


def full_disk():
    def refuse(self, arrays):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    return mock.patch.object(Journal, "frame", refuse)


# --- what lies on disk -----------------------------------------------------------------------------------------------


def run_twice(place: Path, case: Case) -> None:
    simulate.simulate(case, place / "run", threads=1)
    simulate.simulate(case, place / "run", threads=1)


def interrupted(place: Path, case: Case) -> Path:
    """The folder of a run that was asked to stop half-way."""

    def stop(progress) -> None:
        if progress.time > 0.0:
            os.kill(os.getpid(), signal.SIGTERM)

    with contextlib.suppress(KeyboardInterrupt):
        simulate.simulate(case, place / "run", progress=stop, threads=1)
    return place / "run.partial"


def run_over_interrupted(place: Path, case: Case) -> None:
    interrupted(place, case)
    simulate.simulate(case, place / "run", threads=1)


def _resume(place: Path, case: Case, name: str, damage: Callable[[bytes], bytes]) -> None:
    path = interrupted(place, case) / name
    path.write_bytes(damage(path.read_bytes()))
    simulate.resume(place / "run", threads=1)


def resume_damaged_case(place: Path, case: Case) -> None:
    _resume(place, case, "case.toml", lambda data: data[: len(data) // 2] + b"\n[")


def resume_changed_case(place: Path, case: Case) -> None:
    _resume(place, case, "case.toml", lambda data: data.replace(b"density = 800.0", b"density = 900.0"))


def resume_cut_checkpoint(place: Path, case: Case) -> None:
    _resume(place, case, "checkpoint_a.safetensors", lambda data: data[:-1000])


def resume_cut_journal(place: Path, case: Case) -> None:
    _resume(place, case, "journal.bin", lambda data: data[:1000])


def resume_without_checkpoint(place: Path, case: Case) -> None:
    (interrupted(place, case) / "checkpoint_a.safetensors").unlink()
    simulate.resume(place / "run", threads=1)


def open_changed_run(place: Path, case: Case) -> None:
    path = simulate.simulate(case, place / "run", threads=1).folder / "histories.csv"
    path.write_text(path.read_text().replace("0", "1", 1))
    Result.open(place / "run")


def open_incomplete_run(place: Path, case: Case) -> None:
    (simulate.simulate(case, place / "run", threads=1).folder / "fabric.vtkhdf").unlink()
    Result.open(place / "run")
