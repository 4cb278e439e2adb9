"""The contact force on a free obstacle, learned from the histories of training runs.

What the solver's contact does between two shapes of a surrogate cannot be recomputed from these shapes (`contact_reach`
says why), so it is learned: networks map design, time, the area vectors of the predicted bag about the body where it
now is, and the body's velocity, to the mean force over the next `EVERY` intervals of the histories. The target is the
change of momentum in the histories, filtered to CFC 180, because faster chatter depends on the last digits of a run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.rom.learn.train import import_network
from billow.rom.surrogate.regression import Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling

EVERY = 4
"""Intervals of the histories for which a force is held: 0.4 ms at 10 kHz, short against what CFC 180 lets through."""

EPOCHS = 20
STATE_NOISE = 0.05
"""Random disturbance of the state inputs while learning, over their deviation: a closed loop visits states that no run
went through, and must not be driven further off by them."""


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """regression: from design, time and scaled state to a force [N] with components x, y, z
    mean, deviation: of the state, (state,) float64, as `scaled` needs them
    """

    regression: Regression
    mean: np.ndarray
    deviation: np.ndarray

    def __call__(self, design: np.ndarray, time: float, state: np.ndarray) -> np.ndarray:
        """Mean force over a step around `time`: [N], (3,). design: (parameters,); state: (state,)."""
        further = ((state - self.mean) / self.deviation).astype(np.float32)[None, None]
        return self.regression(design[None], np.array([time]), further)[0, 0].astype(float)


def learn_contact_law(inputs: InputScaling, design, times, state, force, seed, progress=None) -> ContactLaw:
    """Learn a law from runs.

    inputs: scaling of design and time, without further inputs; design: (runs, parameters); times: [s], (steps,), the
    middle of each step; state: (runs, steps, state); force: [N], (runs, steps, 3)
    """
    network = import_network()
    mean = state.mean(axis=(0, 1))
    deviation = np.maximum(state.std(axis=(0, 1)), 1e-9)
    scaling = InputScaling(inputs.low, inputs.high, inputs.start, inputs.end, "shared", further=state.shape[-1])
    size = np.full((2, 3), force.std(axis=(0, 1)).max())
    outputs = OutputScaling(np.array([inputs.start, inputs.end]), np.zeros((2, 3), np.float32), size.astype(np.float32))
    random = np.random.default_rng(seed)
    further = (state - mean) / deviation + STATE_NOISE * random.standard_normal(state.shape)
    features = scaling(design, times, further)
    targets = (force / size[0]).reshape(-1, 3).astype(np.float32)
    weights, biases = network.train_shared(features, targets, epochs=EPOCHS, seed=seed, progress=progress)
    return ContactLaw(Regression("shared", weights, biases, scaling, outputs), mean, deviation)
