"""Small cases that the trust figures are measured on."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable

import numpy as np

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.solver.checkpoint import flatten
from billow.solver.model import Model, State
from billow.solver.run import Recorder, Schedule

PLATE = {"shape": "plate"}


def impact_case(gas: str = "uniform-pressure") -> Case:
    """A coarse driver bag that strikes a free obstacle within its first milliseconds."""
    obstacle = {
        "shape": "super-ellipsoid",
        "locked": False,
        "degree": 3.0,
        "angle_about_x": 20.0,
        "clearance": 0.02,
        "velocity": [0.0, 0.3, -4.0],
    }
    return Case.from_dict(
        {
            "bag": {"element_size": 0.035},
            "fabric": {"permeability": 0.025},
            "gas": {"model": gas},
            "obstacles": [PLATE, obstacle],
            "run": {"end_time": 0.012, "frames": 4},
        }
    )


def impact(gas: str = "uniform-pressure") -> tuple[Model, Schedule]:
    case = impact_case(gas)
    return build_model(case), build_schedule(case.run)


def state_sha256(state: State) -> str:
    """SHA-256 over every array and number of a state."""
    arrays, numbers = flatten(state)
    digest = hashlib.sha256(repr(sorted((k, repr(v)) for k, v in numbers.items())).encode())
    for name in sorted(arrays):
        digest.update(name.encode() + np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()


class Listener(Recorder):
    """A recorder that hashes every row of histories and calls `at_step` after every step."""

    def __init__(self, at_step: Callable[[State], None] = lambda state: None):
        self.at_step, self.digest = at_step, hashlib.sha256()

    def history(self, model: Model, state: State) -> None:
        totals = dataclasses.astuple(model.gas.totals(state.gas))
        self.digest.update(repr((state.time, *map(str, totals), dataclasses.astuple(state.ledger))).encode())

    def frame(self, model: Model, state: State) -> None:
        self.digest.update(state_sha256(state).encode())

    def step(self, model: Model, state: State) -> None:
        self.at_step(state)
