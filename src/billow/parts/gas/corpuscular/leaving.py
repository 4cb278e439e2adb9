"""Particles that leave the bag: who does, and what they take along."""

from __future__ import annotations

import numpy as np

from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.flight import Flock
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.outlets import Outlets
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.mixture import species_enthalpy
from billow.parts.gas.supply.passages import VENT, Passages

LARGEST_PULL = 0.02
"""Of a chamber's particles that a vent may take in a gas step, besides those that strike it."""


def pull_out(
    gas: CorpuscularState, kinds: ParticleKinds, outlets: Outlets, passages: Passages, bag: Bag, flock: Flock,
    span: float,
) -> np.ndarray:  # fmt: skip
    """Hold what leaves against what should; where too few particles strike a vent, let the nearest leave.

    Returns who does, (particles,) bool.
    """
    pulled = np.zeros(len(flock.chamber), np.bool_)
    out = np.flatnonzero(flock.chamber == OUTSIDE)
    where, mass = outlets.passage[flock.exit[out]], kinds.mass[flock.species[out]]
    gas.short += gas.wanted * span - np.bincount(where, mass, len(gas.short))
    gas.short[gas.wanted == 0.0] = 0.0
    for k, row in enumerate(passages.rows):
        if row.kind != VENT or gas.wanted[k] == 0.0 or gas.pass_probability[row.triangles[0]] < 1.0:
            continue
        home = max(row.behind, row.ahead)  # OUTSIDE is -1
        inside = np.flatnonzero(flock.chamber == home)
        mean = kinds.mass[flock.species[inside]].sum() / max(len(inside), 1)
        number = int(min(gas.short[k] / max(mean, 1e-300), LARGEST_PULL * len(inside)))
        if number <= 0:
            continue
        vent = bag.positions[bag.surface.triangles[row.triangles]].mean(axis=(0, 1))
        away = np.sum((flock.position[inside] - vent) ** 2, axis=1)
        who = inside[np.sort(np.argpartition(away, number - 1)[:number])]
        flock.chamber[who], flock.exit[who], pulled[who] = OUTSIDE, row.triangles[0], True
        gas.short[k] -= kinds.mass[flock.species[who]].sum()
    return pulled


def take_out(
    gas: CorpuscularState, kinds: ParticleKinds, outlets: Outlets, passages: Passages, bag: Bag, flock: Flock,
    pulled: np.ndarray,
) -> None:  # fmt: skip
    """Book and drop who left the bag."""
    who = np.flatnonzero(flock.chamber == OUTSIDE)
    if not len(who):
        return
    where = outlets.passage[flock.exit[who]]
    mass, velocity = kinds.mass[flock.species[who]], flock.velocity[who]
    np.add.at(gas.left, (where, flock.species[who]), mass)
    energy = 0.5 * mass * np.sum(velocity**2, axis=1) + gas.particles.internal_energy[who]
    # Outflow takes its enthalpy along; what particles have less, the gas they leave behind pays.
    home = np.array([max(row.behind, row.ahead) for row in passages.rows])[where]  # OUTSIDE is -1
    area = np.linalg.norm(area_vectors(bag.surface.triangles, bag.positions), axis=1)
    missing = outlets.missing_heat(
        area, gas.bank.pressure, gas.bank.mass_flux, gas.masses, gas.temperature
    )[where] * kinds.heat * gas.temperature[home]  # fmt: skip
    enthalpy = np.array([[species_enthalpy(row, t) for row in kinds.table] for t in gas.temperature])
    whole = kinds.mass[flock.species[who]] * enthalpy[home, flock.species[who]]
    debt = np.bincount(home, np.where(pulled[who], whole - energy, missing), len(gas.pool))
    gas.pool -= debt
    gas.enthalpy_out += float(energy.sum() + debt.sum())
    gas.impulse -= mass @ velocity
    gas.particles.keep(flock.chamber != OUTSIDE)
