"""Contact forces of the time before as further inputs of the networks: the ROM paper's "Model Including Forces".

A contact force is a field over the whole bag, so it is reduced first. For each chosen component, over all training
snapshots (paper, Methods):

1. the Euclidean norm of each snapshot is a sample of a distribution; those outside mean +- 3 deviations
   leave (`force_basis`)
2. the POD of the rest gives M force modes (paper equation 4)
3. each coefficient's mean and deviation over the rest give a normal distribution, whose cumulative function brings the
   coefficient into [0, 1]
4. what the networks see at time t is the scaled coefficient of time t - 1

A snapshot that left the basis is still learned from: its force is extreme, its shape is not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.rom.learn.force_basis import force_bases
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.snapshots import COMPONENTS


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

    @classmethod
    def learn(
        cls, dataset, runs, modes: int, components: str, seed: int, memory: int = DEFAULT_MEMORY
    ) -> tuple[ForceInputs, np.ndarray]:
        """Force modes from the recorded forces of `runs`, and the inputs of these runs: [-], (runs, times, width).

        modes: M of each component; components: letters, such as "z" or "xyz"; memory: [byte], as `force_bases`
        Raises InputError E-CPL-001 for components that do not exist or never felt a force, E-ROM-007 for a number of
        modes that cannot be made, E-ROM-009 for forces that are not finite.
        """
        chosen = tuple(COMPONENTS.index(letter) for letter in components if letter in COMPONENTS)
        if not chosen or len(set(chosen)) != len(components):
            raise _no_component(components, "components are x, y and z, each at most once")
        bases, coefficients, usual = force_bases(dataset, tuple(runs), modes, chosen, seed, memory)
        if None in bases:
            raise _no_component(COMPONENTS[chosen[bases.index(None)]], "no training run felt a force in it")
        learned = [known[:, kept].astype(float) for known, kept in zip(coefficients, usual, strict=True)]
        # A mode that the rank of the data does not reach has coefficients of rounding only.
        least = [1e-6 * basis.singular_values[0] for basis in bases]
        found = cls(
            chosen,
            np.stack([basis.modes for basis in bases]),
            np.array([known.mean(axis=1) for known in learned]),
            np.array([np.maximum(known.std(axis=1), low) for known, low in zip(learned, least, strict=True)]),
        )
        # (components, modes, runs * times) -> (runs, times, components, modes)
        by_run = np.stack(coefficients).reshape(len(chosen), modes, len(runs), -1).transpose(2, 3, 0, 1)
        return found, found.scaled(previous(by_run))

    def __call__(self, forces: np.ndarray) -> np.ndarray:
        """Inputs from nodal forces: [N], (..., nodes, 3) -> [-], (..., width) float32.

        They are inputs for the time after that of the forces.
        """
        coefficients = [forces[..., c] @ modes.T for c, modes in zip(self.components, self.modes, strict=True)]
        return self.scaled(np.stack(coefficients, axis=-2))

    def scaled(self, coefficients: np.ndarray) -> np.ndarray:
        """[N], (..., components, modes) -> [-], (..., width) float32 in [0, 1]: the normal cumulative function."""
        standard = (coefficients - self.mean) / self.deviation
        scaled = 0.5 * (1.0 + np.vectorize(math.erf, otypes=[float])(standard / math.sqrt(2.0)))
        return scaled.reshape(*coefficients.shape[:-2], -1).astype(np.float32)


def previous(series: np.ndarray) -> np.ndarray:
    """Values of the time before: (runs, times, ...) -> the same shape. Before the first time nothing touches: 0."""
    shifted = np.zeros_like(series)
    shifted[:, 1:] = series[:, :-1]
    return shifted


def _no_component(components: str, why: str) -> InputError:
    return InputError(
        "E-CPL-001",
        f"contact forces {components!r} cannot be inputs",
        where="force_components",
        why=why,
        remedy='choose among "x", "y" and "z" those in which the obstacle pushes, or train without forces',
    )
