"""The books of a corpuscular gas: what is inside, held against what came in, what left, and what the walls got."""

from __future__ import annotations

import math

import numpy as np

from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.corpuscular.energy_settlement import thermal_energy
from billow.parts.gas.corpuscular.inflow import pending
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.particles import ParticleSums, sum_particles
from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import ChamberTotals, GasTotals
from billow.parts.gas.supply.mixture import mixture_gamma, mixture_temperature

AS_KEPT = "enthalpy_in", "enthalpy_out", "mass_error", "energy_error", "heat_lost", "blocked_area"
"""Totals that the state keeps under the same names."""


def take_stock(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds) -> None:
    """Masses, energy, pressure and temperature from the particles."""
    gas.sums = sums = sum_particles(gas.particles, kinds.mass, setup.chambers.count)
    gas.masses = sums.particles * kinds.mass
    gas.particle_energy = sums.energy
    weight = np.maximum(gas.masses.sum(axis=1), 1e-300)
    drift = 0.5 * np.sum(sums.momentum**2, axis=1) / weight
    gas.pressure = 2.0 / 3.0 * (sums.flight_energy - drift) / gas.volume  # LS-DYNA paper, equation 8
    thermal = thermal_energy(sums, kinds.mass)
    for c in range(setup.chambers.count):
        if thermal[c] > 0.0:
            masses, guess = gas.masses[c], gas.temperature[c]
            gas.temperature[c] = mixture_temperature(setup.table, masses, thermal[c], guess)
            gas.gamma[c] = mixture_gamma(setup.table, masses, gas.temperature[c])


def sums_of(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds) -> ParticleSums:
    """Sums over the particles as they were when stock was last taken."""
    if gas.sums is None:  # a state just restored
        gas.sums = sum_particles(gas.particles, kinds.mass, setup.chambers.count)
    return gas.sums


def _mass(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds) -> np.ndarray:
    """In particles, and what is not yet one or no longer [kg], (species,)."""
    return gas.masses.sum(axis=0) + pending(setup, gas, kinds, gas.gas_time) + gas.remainder.mass(kinds)


def _energy(gas: CorpuscularState) -> float:
    """Of particles, of what is not yet one or no longer, of the bank, and what is owed [J]."""
    waiting = sum(delivery.pending_energy for delivery in gas.deliveries) + gas.remainder.energy
    return gas.particle_energy + waiting + gas.in_bank + float(gas.pool.sum())


def close_books(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds) -> None:
    """Hold mass, energy and momentum of the state against the books; keep the largest relative errors."""
    injected = sum(i.delivered(gas.gas_time) * i.mass_fractions for i in setup.supply.inflators)
    came = gas.start_masses + injected + gas.drawn
    gap = _mass(setup, gas, kinds) + gas.left.sum(axis=0) - came
    gas.mass_error = max(gas.mass_error, float(np.abs(gap).max() / came.sum()))
    booked = gas.start_energy + gas.enthalpy_in - gas.enthalpy_out - gas.load.work - gas.heat_lost
    scale = gas.start_energy + gas.enthalpy_in
    gas.energy_error = max(gas.energy_error, abs(_energy(gas) - booked) / scale)
    held = np.ascontiguousarray(gas.load.held.T).sum(axis=1)  # sums down rows of three take ten times as long
    momentum = gas.sums.momentum.sum(axis=0) + gas.remainder.momentum + held + gas.load.given
    gap = momentum - gas.start_momentum - gas.impulse
    scale = math.sqrt(2.0 * gas.sums.flight_energy.sum() * gas.masses.sum())
    gas.momentum_error = max(gas.momentum_error, float(np.abs(gap).max() / scale))


def content(setup: Setup, gas: CorpuscularState) -> tuple[np.ndarray, np.ndarray]:
    """Mass [kg] (chambers, species) and energy [J] (chambers,) that the books find in each chamber.

    With the particles goes what is not yet one or no longer, what is owed, and what walls were given and did not
    pass on.
    """
    kinds = setup.kinds(gas)
    sums = sums_of(setup, gas, kinds)
    thermal = thermal_energy(sums, kinds.mass)
    energy = sums.flight_energy + sums.internal_energy + gas.pool
    energy += (gas.in_bank + gas.remainder.energy) * thermal / max(thermal.sum(), 1e-300)
    masses = gas.masses + gas.remainder.number * kinds.mass
    for source, delivery in zip(setup.supply.sources, gas.deliveries, strict=True):
        inflator = source.inflator
        delivered = inflator.delivered(gas.gas_time) * inflator.mass_fractions
        masses[inflator.chamber] += delivered - delivery.mass(kinds)
        energy[inflator.chamber] += delivery.pending_energy
    return masses, energy


def totals(setup: Setup, gas: CorpuscularState) -> GasTotals:
    """What the gas is as a whole, for histories and ledgers."""
    kinds = setup.kinds(gas)
    left = gas.left.sum(axis=1)
    flows = [
        (passed, 0.0) if OUTSIDE not in (row.behind, row.ahead) else (gone, gone)
        for row, passed, gone in zip(setup.supply.passages.rows, gas.passed.tolist(), left.tolist(), strict=True)
    ]
    vented_by, leaked_by, passed = setup.supply.outflow_by_name(flows)
    single = setup.chambers.count == 1
    volume = float(gas.volume.sum())
    mass = gas.masses.sum(axis=1)
    share = mass / max(mass.sum(), 1e-300)
    return GasTotals(
        pressure=float(gas.pressure @ gas.volume) / volume,
        temperature=float(gas.temperature @ share) if mass.any() else setup.supply.ambient.temperature,
        volume=volume,
        mass_by_species=_mass(setup, gas, kinds),
        energy=_energy(gas),
        injected=float(sum(i.delivered(gas.gas_time) for i in setup.supply.inflators)),
        vented=sum(vented_by.values()),
        leaked=sum(leaked_by.values()),
        drawn_in=float(gas.drawn.sum()),
        work=gas.load.work,
        ambient_work=gas.load.ambient_work,
        **{name: getattr(gas, name) for name in AS_KEPT},
        vented_by=vented_by,
        leaked_by=leaked_by,
        passed=passed,
        chambers=() if single else _each(setup, gas, kinds),
    )


def _each(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds) -> tuple[ChamberTotals, ...]:
    sums = sums_of(setup, gas, kinds)
    energy = sums.flight_energy + sums.internal_energy
    mass = gas.masses.sum(axis=1) + gas.remainder.number @ kinds.mass
    columns = (gas.pressure, gas.temperature, gas.volume, mass, energy)
    return tuple(map(ChamberTotals, setup.chambers.names, *(column.tolist() for column in columns)))
