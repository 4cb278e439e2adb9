"""Stress-strain curves as they come out of a test."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Curve:
    """Points of a curve through (0, 0), joined by straight lines, going on with the last slope.

    Yarns: true (logarithmic) strain [-] against true stress [Pa]. Shear: angle [rad] against shear stress [Pa].
    """

    strain: tuple[float, ...]
    stress: tuple[float, ...]

    @property
    def end(self) -> float:
        """Last strain."""
        return self.strain[-1]

    @cached_property
    def slopes(self) -> np.ndarray:
        """Of each piece [Pa], (points - 1,)."""
        return np.diff(self.stress) / np.diff(self.strain)

    def at(self, strain: np.ndarray | float) -> np.ndarray:
        """Stress [Pa] at strains of any size from 0 on, same shape."""
        beyond = np.maximum(0.0, np.asarray(strain) - self.end)
        return np.interp(strain, self.strain, self.stress) + self.slopes[-1] * beyond


@dataclass(frozen=True)
class TestedCurve:
    """Loading, and unloading from the end of the test; without unloading the fabric is elastic in this direction."""

    __test__ = False  # it is no test of pytest's

    loading: Curve
    unloading: Curve | None = None
