"""What is wrong with force inputs, or with what a coupled model is to learn from."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from here import Here
from triggers_surrogates import ANSWERABLE

from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.impactor import ImpactorOfDesign
from billow.rom.learn.force_modes import learn_force_inputs
from billow.rom.surrogate.surrogate import Surrogate


def study_of(locked: bool) -> SimpleNamespace:
    """Two runs of an obstacle whose mass follows no parameter."""

    def result(run):
        return SimpleNamespace(
            case_toml={
                "obstacles": [
                    {
                        "shape": "super-ellipsoid", "name": "head", "radii": 0.1, "degree": 2.0, "clearance": 0.1,
                        "offset": [0.0, 0.0], "angle_about_x": 0.0, "locked": locked, "mass": 4.0 + int(run),
                        "velocity": [0.0, 0.0, 0.0],
                    }
                ]
            }
        )  # fmt: skip

    parameters = SimpleNamespace(name="a"), SimpleNamespace(name="b")
    return SimpleNamespace(result=result, parameters=parameters, design=lambda runs: np.ones((len(runs), 2)))


def couple_with_forces(here: Here):
    surrogate = SimpleNamespace(runs=("0",), forces="z")
    still = SimpleNamespace(centre=np.zeros((9, 3)), velocity=np.zeros((9, 3)))
    run = SimpleNamespace(histories=SimpleNamespace(time=np.arange(9) * 1e-4), body=lambda name: still)
    here.patch.setattr(ImpactorOfDesign, "learn", lambda dataset, runs: SimpleNamespace(name="head"))
    Coupled.train(SimpleNamespace(result=lambda name: run), surrogate)


def never_judged(here: Here):
    bag = SimpleNamespace(runs=("0",))
    Coupled(bag, SimpleNamespace(name="head"), None, np.arange(9) * 1e-4, np.zeros(3)).deploy({})


TRIGGERS = {
    "E-CPL-001": lambda here: learn_force_inputs(None, (), 3, "w", 0),
    "E-CPL-002": lambda here: Surrogate.load(here.bench.surrogate).predict(ANSWERABLE, previous_forces=np.zeros(3)),
    "E-CPL-003": lambda here: ImpactorOfDesign.learn(study_of(locked=True), ["0", "1"]),
    "E-CPL-004": lambda here: ImpactorOfDesign.learn(study_of(locked=False), ["0", "1"]),
    "E-CPL-005": couple_with_forces,
    "E-CPL-007": never_judged,
    "E-CPL-008": lambda here: ImpactorOfDesign("head", -np.ones((12, 2)))(np.ones(1)),
    "E-CPL-006": lambda here: Coupled.load(here.bench.surrogate),
}
