"""Settlement of energy that is owed to the gas, or by it, pooled by chamber (docs/theory.md, Outlets, inflow and
returned energy)."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.parts.gas.corpuscular.particles import Particles, ParticleSums
from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.supply.ambient import heat_lost
from billow.parts.gas.supply.mixture import mixture_cv

LARGEST_SHARE = 0.05
"""Share of a chamber's thermal energy that may be settled at once; the rest stays in the pool."""


def settle(particles: Particles, sums: ParticleSums, mass: np.ndarray, pool: np.ndarray) -> np.ndarray:
    """Give pool [J] (chambers,) to the particles; returns what was given (chambers,).

    sums: of the particles as they are; mass of a particle [kg] (species,).
    """
    mean = sums.momentum / np.maximum(sums.particles @ mass, 1e-300)[:, None]
    thermal = thermal_energy(sums, mass)
    given = np.clip(pool, -LARGEST_SHARE * thermal, LARGEST_SHARE * thermal)
    square = 1.0 + given / np.maximum(thermal, 1e-300)
    _warm(particles.count, particles.arrays(), mean, np.sqrt(square), square)
    return given


def thermal_energy(sums: ParticleSums, mass: np.ndarray) -> np.ndarray:
    """Energy without that of each chamber's mean motion [J], (chambers,)."""
    weight = np.maximum(sums.particles @ mass, 1e-300)
    return sums.flight_energy + sums.internal_energy - 0.5 * np.sum(sums.momentum**2, axis=1) / weight


@kernel
def _warm(n, particles, mean, factor, square):
    velocity, internal_energy, chamber = particles.velocity, particles.internal_energy, particles.chamber
    for i in prange(n):
        c = chamber[i]
        internal_energy[i] *= square[c]
        for k in range(3):
            velocity[i, k] = mean[c, k] + factor[c] * (velocity[i, k] - mean[c, k])


def lose_heat(setup: Setup, gas: CorpuscularState, span: float) -> None:
    """Owe the heat that walls let out in `span` [s], at the temperatures of the last gas step.

    The chamber as a whole owes it: a coefficient of the whole wall does not say where gas cools.
    """
    for c, conductance in enumerate(() if setup.supply.heat_conductance is None else setup.supply.heat_conductance):
        masses, temperature = gas.masses[c], gas.temperature[c]
        if conductance > 0.0 and masses.any():
            capacity = mixture_cv(setup.table, masses, temperature)
            heat = heat_lost(capacity, temperature - setup.supply.ambient.temperature, conductance, span)
            gas.pool[c] -= heat
            gas.heat_lost += float(heat)
