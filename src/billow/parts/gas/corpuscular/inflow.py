"""Particles that come in: new ones from the inflators, and ambient air drawn in where the pressure outside is
higher."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.injection import Injector, Nozzles
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.random_numbers import gamma, normal, stream, uniform
from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.mixture import mixture_enthalpy

LEAST_BACK_PRESSURE = 1e-6
"""Least pressure [Pa] against which a jet blows: into a vacuum it is choked."""

BIRTH_TIME = 0x4249_5254
"""Names the random numbers of the time within a step at which a particle is born."""

DRAWN_IN = 0x4452_4157
"""Names the random numbers of air drawn in."""

INSET = 1e-6
"""Height [m] of new particles above the triangle through which air is drawn in."""


def coming(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> float:
    """Number of particles that inflators blow in, and passages draw in, up to `time` [s]."""
    return float(((pending(setup, gas, kinds, time) + gas.owed.sum(axis=0)) / kinds.mass).sum())


def pending(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> np.ndarray:
    """Mass that inflators have delivered up to `time` [s] and that is not in any particle yet [kg], (species,)."""
    waiting = np.zeros(len(kinds.mass))
    for source, delivery in zip(setup.supply.sources, gas.deliveries, strict=True):
        inflator = source.inflator
        waiting += inflator.delivered(time) * inflator.mass_fractions - delivery.mass(kinds)
    return waiting


def blow(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag, span: float) -> np.ndarray | None:
    """Add new particles from the inflators; returns at which fraction of the step they start to fly, (newborns,)."""
    first = gas.particles.count
    ready = injectors(setup, kinds, gas.positions)
    for source, injector, delivery in zip(setup.supply.sources, ready, gas.deliveries, strict=True):
        mouth, one = source.jets.mouth_nodes, gas.particles.count
        offered = delivery.offered
        start, end = gas.positions[mouth].mean(axis=0), bag.positions[mouth].mean(axis=0)
        pressure = max(float(gas.pressure[source.inflator.chamber]), LEAST_BACK_PRESSURE)
        birth = injector.blow(
            delivery, gas.particles, gas.gas_time, span, start, (end - start) / span, pressure, setup.seed
        )
        gas.enthalpy_in += delivery.offered - offered + birth.carried_energy
        gas.impulse += birth.impulse
        when = _birth_times(gas, one, setup.seed)
        gas.particles.position[one : gas.particles.count] += when[:, None] * (end - start)
    if gas.particles.count == first:
        return None
    return _birth_times(gas, first, setup.seed)


def injectors(setup: Setup, kinds: ParticleKinds, positions: np.ndarray) -> list[Injector]:
    """The injector of each source at the present place of its mouth; positions: [m], (nodes, 3)."""
    made = []
    for source in setup.supply.sources:
        holes, frames, (axis, _, _) = source.jets.nozzles(positions)
        ring = source.jets.ring
        centre = positions[source.jets.mouth_nodes].mean(axis=0)
        nozzles = Nozzles(
            holes - centre, frames[:, 0], np.full(ring.count, source.inflator.chamber, np.int32),
            0.5 * ring.hole_diameter, ring.cone, axis, ring.spin,
        )  # fmt: skip
        made.append(Injector(kinds, source.inflator, nozzles))
    return made


def _birth_times(gas: CorpuscularState, first: int, seed: int) -> np.ndarray:
    """Fractions of the step at which the particles from `first` on are born, (new particles,)."""
    times = np.empty(gas.particles.count - first)
    _draw_uniform(gas.particles.identity[first : gas.particles.count], seed + BIRTH_TIME, times)
    return times


@scalar
def _draw_uniform(identity, seed, drawn_out):
    for p in range(len(identity)):
        drawn_out[p] = uniform(stream(seed, 0, identity[p]), 0)


def draw_air_in(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag) -> None:
    """Add the particles of air that passages have drawn in, with the velocities of molecules that cross a plane."""
    temperature = setup.supply.ambient.temperature
    for k, row in enumerate(setup.supply.passages.rows):
        number = np.floor(gas.owed[k] / kinds.mass).astype(np.int64)
        if not number.any():
            continue
        mass = number * kinds.mass
        chamber, inward = (row.behind, -1.0) if row.ahead == OUTSIDE else (row.ahead, 1.0)
        new = gas.particles.add(int(number.sum()))
        new.species[:] = np.repeat(np.arange(len(number)), number)
        new.chamber[:] = chamber
        triangles = bag.surface.triangles[row.triangles]
        normals = area_vectors(triangles, bag.positions)
        area = np.linalg.norm(normals, axis=1)
        _place(
            new, bag.positions[triangles], np.cumsum(area) / area.sum(), inward * normals / area[:, None], kinds.table,
            kinds.mass, kinds.heat, temperature, setup.seed,
        )  # fmt: skip
        each = kinds.mass[new.species]
        energy = float(0.5 * each @ np.sum(new.velocity**2, axis=1) + new.internal_energy.sum())
        enthalpy = mixture_enthalpy(setup.table, mass, temperature)
        gas.owed[k] -= mass
        gas.drawn += mass
        gas.enthalpy_in += enthalpy
        gas.pool[chamber] += enthalpy - energy
        gas.impulse += each @ new.velocity


@scalar
def _place(new, corners, share, normals, table, mass, heat, temperature, seed):
    """Positions, velocities and internal energies of new particles; share: running sum of the triangles' areas."""
    for p in range(len(new.identity)):
        key, kind = stream(seed + DRAWN_IN, 0, new.identity[p]), new.species[p]
        t = min(np.searchsorted(share, uniform(key, 0)), len(share) - 1)
        u, v = uniform(key, 1), uniform(key, 2)
        if u + v > 1.0:
            u, v = 1.0 - u, 1.0 - v
        sigma = math.sqrt(heat * temperature / mass[kind])
        across = sigma * math.sqrt(-2.0 * math.log(uniform(key, 3)))  # speeds of molecules that cross a plane
        n = normals[t]
        random = np.array([sigma * normal(key, 4), sigma * normal(key, 5), sigma * normal(key, 6)])
        along = random[0] * n[0] + random[1] * n[1] + random[2] * n[2]
        for k in range(3):
            side = u * (corners[t, 1, k] - corners[t, 0, k]) + v * (corners[t, 2, k] - corners[t, 0, k])
            new.position[p, k] = corners[t, 0, k] + side + INSET * n[k]
            new.velocity[p, k] = random[k] + (across - along) * n[k]
        new.internal_energy[p] = heat * temperature * gamma(key, 7, 0.5 * degrees_of_freedom(table[kind], temperature))
