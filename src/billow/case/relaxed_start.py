"""The folded start after it has come to rest: computed once, and kept under the digest of what it depends on."""

from __future__ import annotations

import hashlib
import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from billow import __version__
from billow.base.cache_folder import cache_folder
from billow.case import schema
from billow.case.bag.schema_folds import Relax
from billow.case.gas.schema_gas import Gas
from billow.solver.model import Model
from billow.solver.run import Schedule, run

DAMPING = 1000.0
"""Rate of mass damping [1/s]: motion is gone within a millisecond."""
REST = 0.4
"""Time without change of the reference, in times of the ramp."""


def tense_case(case: schema.Case) -> schema.Case:
    """The case of the bag just folded, whose flat cut comes in by a ramp, without gas, between the plates."""
    bag = case.bag.model_copy(update={"folds": case.bag.folds[:-1], "birth_time": case.bag.relax.time})
    fabric = case.fabric.model_copy(update={"self_contact": "layers"})
    plates = tuple(obstacle for obstacle in case.obstacles if obstacle.shape == "plate")
    return schema.Case(bag=bag, fabric=fabric, gas=Gas(model="none"), obstacles=plates)


def relaxed_start(tense: Model, relax: Relax, digest: str, is_exact: bool) -> np.ndarray:
    """Positions [m], (nodes, 3), of the model of `tense_case` at rest. digest: of that case. is_exact: whether its map
    keeps lengths. Then layers lie as far apart as they have to; growing gaps would only pump the stack up, with a
    hundred times the energy that the map left in it."""
    if is_exact:
        tense = replace(tense, layers=replace(tense.layers, ramp=0.0))
    kept = _kept(tense, f"{digest} {is_exact}")
    if kept is not None and kept.exists():
        found = np.fromfile(kept)
        if found.size == tense.start.size:
            return found.reshape(tense.start.shape)
    damped = replace(tense, mass_damping=DAMPING)
    positions = run(damped, Schedule((1.0 + REST) * relax.time, frames=1, histories_per_frame=10)).positions
    _lift(tense, positions)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        partial = kept.with_name(f"{kept.name}.{os.getpid()}")
        positions.tofile(partial)
        partial.replace(kept)
    return positions


def _lift(tense: Model, positions: np.ndarray) -> None:
    """A bag that presses on a plate lies in it by some micrometres: lift it off, all layers alike, so that none comes
    nearer to another."""
    free = tense.inverse_mass > 0.0
    for plate in tense.bodies.bodies:
        origin, *ends = plate.distance(np.concatenate([np.zeros((1, 3)), np.eye(3)]))[0]
        depth = max(0.0, -float(plate.distance(positions[free])[0].min()))
        positions[free] += depth * (np.array(ends) - origin)


def _kept(tense: Model, digest: str) -> Path | None:
    root = cache_folder()
    if root is None:
        return None
    mesh = tense.start.tobytes() + tense.mass.tobytes() + tense.surface.triangles.tobytes()
    return Path(root) / "relaxed" / hashlib.sha256(f"{__version__} {digest}".encode() + mesh).hexdigest()
