"""The still air outside, and the gas that is inside at the start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Ambient(NamedTuple):
    """Still air outside: pressure [Pa], temperature [K], mass_fractions (species,) in the order of the gas."""

    pressure: float
    temperature: float
    mass_fractions: np.ndarray


@dataclass(frozen=True)
class InitialGas:
    """What each chamber holds at time zero: pressure [Pa] and temperature [K], (chambers,); mass_fractions (chambers,
    species)."""

    pressure: np.ndarray
    temperature: np.ndarray
    mass_fractions: np.ndarray

    @classmethod
    def like(cls, ambient: Ambient, chambers: int) -> InitialGas:
        """Ambient air in every chamber."""
        return cls(
            np.full(chambers, ambient.pressure),
            np.full(chambers, ambient.temperature),
            np.tile(ambient.mass_fractions, (chambers, 1)),
        )
