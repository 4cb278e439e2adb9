"""The contact force on a free obstacle, learned from the histories of training runs.

The solver's penalty law turns micrometres of penetration into kilonewtons; a surrogate errs by millimetres, so the
force cannot be recomputed from its shape. The shape does show where fabric lies within reach of the body,
and which way it faces. For each reach d the area vector is

    a_d = - sum_i A_i exp(-max(0, distance_i) / d) n_i

with the nodes' fabric areas A_i and outward normals n_i of the body. Fabric that lies on the body under a pressure p
would push it with p a_d for a small d.

Networks map design, time, the area vectors about the body where it now is, and the body's velocity, to the mean force
over the next `EVERY` intervals of the histories. The target is the change of momentum in the histories, filtered to
CFC 180, because faster chatter depends on the last digits of a run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.rom.coupled.impactor import Impactor
from billow.rom.learn.progress import Progress
from billow.rom.learn.train import import_network
from billow.rom.surrogate.regression import Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling

REACHES = (5e-3, 20e-3)
"""[m]: about the error of a surrogate, and well beyond it."""

FARTHEST = 7.0
"""Reaches beyond which fabric does not count: its weight is below 1e-3."""

EVERY = 4
"""Intervals of the histories for which a force is held: 0.4 ms at 10 kHz, short against what CFC 180 lets through."""

EPOCHS = 20
STATE_NOISE = 0.05
"""Random disturbance of the state inputs while learning, over their deviation: a closed loop visits states that no run
went through, and must not drift further away because of them."""


def area_vectors(nodes: np.ndarray, area: np.ndarray, body: Impactor, centre: np.ndarray) -> np.ndarray:
    """Area vectors of all `REACHES`: [m^2], (reaches, 3).

    nodes: [m], (nodes, 3); area: fabric of each node [m^2], (nodes,); centre: of the body now [m], (3,)
    """
    # |y_k| <= a_k G along each axis: a node so far outside its box is out of reach before any power is taken.
    far = FARTHEST * max(REACHES)
    outside = np.abs((nodes - centre) @ body.rotation) - body.radii
    near = (outside < far).all(axis=1)
    nodes, area = nodes[near], area[near]
    distance, normal = body.distance_to(nodes, centre)
    weights = area * np.exp(-np.maximum(distance, 0.0) / np.array(REACHES)[:, None])
    return -weights @ normal


def node_area(reference: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Fabric of each node in the start shape: [m^2], (nodes,), a third of each of its triangles."""
    a, b, c = (reference[triangles[:, k]].astype(float) for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(triangles.ravel(), np.repeat(third, 3), minlength=len(reference))


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


def learn_contact_law(
    inputs: InputScaling, design, times, state, force, seed: int, progress: Progress | None = None
) -> ContactLaw:
    """Learn a law from runs.

    inputs: scaling of design and time, without further inputs; design: (runs, parameters); times: [s], (steps,), the
    middle of each step; state: (runs, steps, state); force: [N], (runs, steps, 3)
    """
    mean = state.mean(axis=(0, 1))
    deviation = np.maximum(state.std(axis=(0, 1)), 1e-9)
    scaling = replace(inputs, recipe="shared", further=state.shape[-1])
    size = np.full((2, 3), force.std(axis=(0, 1)).max())
    outputs = OutputScaling(np.array([inputs.start, inputs.end]), np.zeros((2, 3), np.float32), size.astype(np.float32))
    noise = STATE_NOISE * np.random.default_rng(seed).standard_normal(state.shape)
    features = scaling(design, times, (state - mean) / deviation + noise)
    targets = (force / size[0]).reshape(-1, 3).astype(np.float32)
    weights, biases = import_network().train_shared(features, targets, epochs=EPOCHS, seed=seed, progress=progress)
    return ContactLaw(Regression("shared", weights, biases, scaling, outputs), mean, deviation)
