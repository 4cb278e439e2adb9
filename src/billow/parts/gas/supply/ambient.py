"""The still air outside, the heat it takes, and the gas that is inside at the start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar


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


@scalar
def heat_lost(capacity, warmer, conductance, span):
    """Heat [J] that a chamber's gas loses through its fabric in `span` [s], m cv dT/dt = -h A (T - T_ambient): exact.

    capacity: m cv [J/K]. warmer: T - T_ambient at the start [K]. conductance: h A [W/K].
    """
    return -capacity * warmer * math.expm1(-span * conductance / capacity)
