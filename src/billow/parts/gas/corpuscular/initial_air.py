"""Ambient air in the start shape: even by volume, Maxwell's velocities, no net momentum, exact energy."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.corpuscular.inside_points import points_inside
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import gamma, normal, stream

INITIAL_AIR = 0x41495220
"""Names the random numbers of the air's motion."""


def air_count(kinds: ParticleKinds, pressure: float, temperature: float, volumes: np.ndarray) -> np.ndarray:
    """Particles in volumes [m^3] (chambers,) at pressure [Pa] and temperature [K], to the nearest whole one: int64."""
    return np.rint(pressure * volumes / (kinds.heat * temperature)).astype(np.int64)


def fill_with_air(
    particles: Particles, kinds: ParticleKinds, mass_fractions: np.ndarray, pressure: float, temperature: float,
    volumes: np.ndarray, triangles: np.ndarray, positions: np.ndarray, behind: np.ndarray, ahead: np.ndarray, seed: int,
) -> None:  # fmt: skip
    """Add the air of each chamber at rest: mass_fractions (species,), pressure [Pa], temperature [K].

    volumes [m^3] (chambers,); surface as `points_inside` takes it. The air of a chamber has exactly the energy that
    temperature asks of its particles, and no momentum; its mass is right to half a particle.
    """
    number = air_count(kinds, pressure, temperature, volumes)
    points, chamber, _ = points_inside(triangles, positions, behind, ahead, number, seed)
    count = len(points)
    particles.make_room(count)
    first, last = particles.count, particles.count + count
    particles.position[first:last] = points
    particles.chamber[first:last] = chamber
    particles.identity[first:last] = particles.next_identity + np.arange(count)
    share = mass_fractions / kinds.mass
    _stir(
        chamber, particles.identity[first:last], kinds.table, kinds.mass, kinds.heat, share / share.sum(), temperature,
        seed, particles.species[first:last], particles.velocity[first:last], particles.internal_energy[first:last],
    )  # fmt: skip
    particles.count, particles.next_identity = last, particles.next_identity + count


@scalar
def _stir(
    chamber, identity, table, mass, heat, mole_fractions, temperature, seed, species_out, velocity_out, energy_out
):
    """Species, velocities and stores of particles that are listed chamber by chamber."""
    begin, total = 0, len(chamber)
    while begin < total:
        end = begin
        while end < total and chamber[end] == chamber[begin]:
            end += 1
        given = np.zeros(len(mass))
        momentum = np.zeros(3)
        weight, flight, stored, owed = 0.0, 0.0, 0.0, 0.0
        for i in range(begin, end):
            kind = 0
            for k in range(len(mass)):  # the most overdue species
                if (i + 1 - begin) * mole_fractions[k] - given[k] > (i + 1 - begin) * mole_fractions[kind] - given[
                    kind
                ]:
                    kind = k
            given[kind] += 1.0
            species_out[i] = kind
            key = stream(seed + INITIAL_AIR, 0, identity[i])
            dof = degrees_of_freedom(table[kind], temperature)
            energy_out[i] = gamma(key, 3, 0.5 * dof)
            stored += energy_out[i]
            owed += 0.5 * dof
            weight += mass[kind]
            for axis in range(3):
                velocity_out[i, axis] = math.sqrt(heat * temperature / mass[kind]) * normal(key, axis)
                momentum[axis] += mass[kind] * velocity_out[i, axis]
        for i in range(begin, end):
            for axis in range(3):
                velocity_out[i, axis] -= momentum[axis] / weight
                flight += 0.5 * mass[species_out[i]] * velocity_out[i, axis] ** 2
        # A single particle cannot both rest and fly: its energy of flight is stored.
        faster = math.sqrt(1.5 * (end - begin) * heat * temperature / flight) if flight > 0.0 else 0.0
        if flight == 0.0:
            owed += 1.5 * (end - begin)
        for i in range(begin, end):
            velocity_out[i] *= faster
            energy_out[i] *= owed * heat * temperature / stored if stored > 0.0 else 0.0
        begin = end
