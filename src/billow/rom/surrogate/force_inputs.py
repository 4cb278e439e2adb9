"""Contact forces of the previous time as further inputs of the networks: the ROM paper's "Model Including Forces"
(docs/theory.md, Contact forces as inputs)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError

FORCES_DO_NOT_FIT = InputError.declare(
    "E-CPL-002",
    "contact forces do not fit the surrogate",
    where="previous_forces",
    cause="a surrogate trained with force_modes was asked without forces, or another one with them",
    remedy="give forces only to a surrogate trained with force_modes, one for each time and node",
)


@dataclass(frozen=True, eq=False)
class ForceInputs:
    """From nodal contact forces to network inputs.

    components: index of each component used, 0 to 2
    modes: [-], (components, modes, nodes) float32, orthonormal rows for each component
    mean, deviation: [N], (components, modes) float64, of the coefficients of the training data
    """

    components: tuple[int, ...]
    modes: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray

    @property
    def width(self) -> int:
        """Number of inputs: components times modes."""
        return self.mean.size

    def __call__(self, forces: np.ndarray) -> np.ndarray:
        """Inputs for the time after that of the forces: [N], (..., nodes, 3) -> [-], (..., width) float32."""
        coefficients = [forces[..., c] @ modes.T for c, modes in zip(self.components, self.modes, strict=True)]
        return self.scaled(np.stack(coefficients, axis=-2))

    def scaled(self, coefficients: np.ndarray) -> np.ndarray:
        """[N], (..., components, modes) -> [-], (..., width) float32 in [0, 1]."""
        standard = (coefficients - self.mean) / self.deviation
        scaled = 0.5 * (1.0 + np.vectorize(math.erf, otypes=[float])(standard / math.sqrt(2.0)))
        return scaled.reshape(*coefficients.shape[:-2], -1).astype(np.float32)


def previous(series: np.ndarray) -> np.ndarray:
    """Values of the previous time: (runs, times, ...) -> the same shape. Before the first time nothing touches: 0."""
    shifted = np.zeros_like(series)
    shifted[:, 1:] = series[:, :-1]
    return shifted


def further_inputs(forces, model: ForceInputs | None, shape: tuple[int, ...]) -> np.ndarray | None:
    """What a surrogate sees besides design and time: [-], (runs, times, further); None if it needs nothing.

    forces: [N], contact forces of the previous time; model: of the surrogate; shape: (runs, times, nodes, 3) that the
    forces must have, the first of which may be missing
    Raises InputError E-CPL-002 if forces are missing, superfluous, of another shape or not finite.
    """
    if model is None and forces is None:
        return None
    if model is None:
        why = "this surrogate was trained without them"
    elif forces is None:
        why = "this surrogate needs the contact forces of the previous time, and none were given"
    else:
        forces = np.asarray(forces)
        if forces.shape in (shape, shape[1:]) and np.isfinite(forces).all():
            return np.broadcast_to(model(forces), (*shape[:2], model.width))
        why = f"forces have shape {forces.shape}, expected {shape}, or are not finite"
    raise FORCES_DO_NOT_FIT(why=why)
