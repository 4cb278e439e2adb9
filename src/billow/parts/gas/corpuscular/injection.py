"""Injection: inflators blow particles into the bag through nozzles (docs/theory.md, Injection)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.base.compiled import scalar
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.random_numbers import gamma, normal, stream, uniform
from billow.parts.gas.supply.curve import interpolate
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.outflow import jet_speed

INJECTION = 0x494E4A45
"""Names the random numbers of injection."""

INSET = 1e-5
"""Height [m] of new particles above the plane of the mouth: inside the bag, and below any gap."""

GENTLEST, STRONGEST = 0.5, 2.0
"""Bounds of the factor on thermal speed that makes a batch exact."""


@dataclass(frozen=True)
class Nozzles:
    """Holes of one inflator, in the present position of its mouth.

    offset: of each hole from the mouth's centre [m], and direction: of its jet, unit vectors, both before any spin,
    (nozzles, 3); chamber: into which it blows, (nozzles,) int32; radius: of a hole [m]; half_angle: of the cone in
    which a jet leaves, cosine-weighted [rad]; normal: of the mouth, unit vector into the bag, (3,); spin: rate [rad/s]
    at which offsets and directions turn about the normal.
    """

    offset: np.ndarray
    direction: np.ndarray
    chamber: np.ndarray
    radius: float
    half_angle: float
    normal: np.ndarray
    spin: float = 0.0

    @property
    def area(self) -> float:
        """Of all holes [m^2]."""
        return len(self.offset) * math.pi * self.radius**2


@dataclass
class Delivery:
    """What one inflator has delivered so far.

    born: (nozzles, species), number of present particles: halved when particles are merged in pairs, and exact, since a
    float holds halves and quarters. offered: enthalpy delivered [J]. energy: taken by particles [J], relative to the
    mouth; the difference is pending.
    """

    born: np.ndarray
    offered: float = 0.0
    energy: float = 0.0

    def mass(self, kinds: ParticleKinds) -> np.ndarray:
        """Mass in particles [kg], (species,)."""
        return self.born.sum(axis=0) * kinds.mass

    @property
    def pending_energy(self) -> float:
        """Delivered, but not in any particle yet [J]; may be negative by a fraction of a particle's energy."""
        return self.offered - self.energy


@dataclass(frozen=True)
class Birth:
    """The new particles of one step, `count` of them, the last ones: mass [kg] (species,); energy [J] relative to the
    mouth; carried_energy [J], what the motion of the mouth adds to it; impulse [N s] (3,), their momentum."""

    count: int
    mass: np.ndarray
    energy: float
    carried_energy: float
    impulse: np.ndarray


@dataclass(frozen=True)
class Injector:
    """One inflator with its nozzles."""

    kinds: ParticleKinds
    inflator: Inflator
    nozzles: Nozzles

    def start(self) -> Delivery:
        """Nothing delivered yet."""
        return Delivery(np.zeros((len(self.nozzles.offset), len(self.kinds.mass))))

    def blow(
        self, delivery: Delivery, particles: Particles, time: float, dt: float, mouth: np.ndarray,
        mouth_velocity: np.ndarray, pressure: float, seed: int,
    ) -> Birth:  # fmt: skip
        """Add what comes in from time to time + dt [s].

        mouth: centre at the end of the step [m] (3,), mouth_velocity [m/s] (3,); pressure [Pa] around the nozzles.
        """
        inflator, nozzles, kinds = self.inflator, self.nozzles, self.kinds
        after = inflator.delivered(time + dt)
        arrived = after - inflator.delivered(time)
        fractions = inflator.mass_fractions
        temperature = interpolate(inflator.temperature_time, inflator.temperature, time + 0.5 * dt)
        enthalpy = mixture_enthalpy(kinds.table, fractions, temperature)
        delivery.offered += arrived * enthalpy
        due = after * fractions / kinds.mass
        count = math.floor(due.sum() - delivery.born.sum())
        if count <= 0:
            return Birth(0, np.zeros(len(kinds.mass)), 0.0, 0.0, np.zeros(3))
        constant = mixture_gas_constant(kinds.table, fractions)
        density = pressure / (constant * temperature)
        drift = min(jet_speed(kinds.table, fractions, temperature), arrived / (dt * density * nozzles.area))
        warmth = mixture_temperature(kinds.table, fractions, enthalpy - 0.5 * drift * drift, temperature)
        # What earlier batches could not take.
        waiting = (due - delivery.born.sum(axis=0)) * kinds.mass
        excess = delivery.pending_energy - mixture_enthalpy(kinds.table, waiting, temperature)
        born = delivery.born.copy()
        new, nozzle = particles.add(count), np.empty(count, np.int64)
        _choose(due, born, nozzle, new.species)
        new.chamber[:] = nozzles.chamber[nozzle]
        mass = (born - delivery.born).sum(axis=0) * kinds.mass
        owed = mixture_enthalpy(kinds.table, mass, temperature) + excess
        angle = nozzles.spin * (time + dt)
        energy = _set_in_motion(
            new, nozzle, turned(nozzles.direction, nozzles.normal, angle), math.sin(nozzles.half_angle) ** 2,
            kinds.table, kinds.mass, kinds.heat, drift, warmth, owed, seed,
        )  # fmt: skip
        holes = turned(nozzles.offset, nozzles.normal, angle) + mouth
        _place(new, nozzle, holes, nozzles.normal, nozzles.radius, seed)
        delivery.born = born
        delivery.energy += energy
        impulse = kinds.mass[new.species] @ new.velocity
        carried = float(mouth_velocity @ impulse + 0.5 * mass.sum() * mouth_velocity @ mouth_velocity)
        new.velocity[:] += mouth_velocity
        return Birth(count, mass, energy, carried, impulse + mass.sum() * mouth_velocity)


@scalar
def turned(vectors, axis, angle):
    """Vectors (n, 3) turned by an angle [rad] about a unit axis through the origin (Rodrigues' formula)."""
    result = np.empty_like(vectors)
    cosine, sine = math.cos(angle), math.sin(angle)
    for i in range(len(vectors)):
        x, y, z = vectors[i, 0], vectors[i, 1], vectors[i, 2]
        along = (1.0 - cosine) * (x * axis[0] + y * axis[1] + z * axis[2])
        result[i, 0] = cosine * x + along * axis[0] + sine * (axis[1] * z - axis[2] * y)
        result[i, 1] = cosine * y + along * axis[1] + sine * (axis[2] * x - axis[0] * z)
        result[i, 2] = cosine * z + along * axis[2] + sine * (axis[0] * y - axis[1] * x)
    return result


@scalar
def _choose(due, born, nozzle_out, species_out):
    """Species and nozzle of each new particle: the most overdue species, and the nozzle most overdue for it."""
    nozzles, kinds = born.shape
    for p in range(len(nozzle_out)):
        chosen, most = 0, -np.inf
        for k in range(kinds):
            overdue = due[k] - born[:, k].sum()
            if overdue > most:
                chosen, most = k, overdue
        at = 0
        for z in range(nozzles):
            if born[z, chosen] < born[at, chosen]:
                at = z
        born[at, chosen] += 1
        nozzle_out[p], species_out[p] = at, chosen


@scalar
def folded_shift(mean):
    """s >= 0 such that |s + xi|, xi standard normal, has this mean; 0 if the mean is below sqrt(2/pi)."""
    if mean <= math.sqrt(2.0 / math.pi):
        return 0.0
    s = mean
    for _ in range(40):
        excess = math.sqrt(2.0 / math.pi) * math.exp(-0.5 * s * s) + s * math.erf(s / math.sqrt(2.0)) - mean
        change = excess / math.erf(s / math.sqrt(2.0))  # the mean is convex in s: Newton falls to it from above
        s -= change
        if abs(change) <= 1e-12:
            break
    return s


@scalar
def _set_in_motion(new, nozzle, direction, sine_square, table, mass, heat, drift, warmth, energy, seed):
    """Velocities and internal energies of new particles; returns their energy [J], `energy` if scaling allows.

    direction: of each jet, (nozzles, 3). warmth: temperature [K] of the thermal motion. The velocity of each particle
    is steady + q * thermal, its internal energy q^2 times the one drawn; q follows from the energy of all.
    """
    velocity, internal_energy, species, identity = new.velocity, new.internal_energy, new.species, new.identity
    count = len(species)
    steady = np.empty((count, 3))
    square, linear, constant = 0.0, 0.0, -energy
    for p in range(count):
        key = stream(seed + INJECTION, 0, identity[p])
        kind = species[p]
        axis = direction[nozzle[p]]
        first, second = _perpendicular(axis)
        sine = math.sqrt(sine_square * uniform(key, 0))
        cosine = math.sqrt(1.0 - sine * sine)
        turn = 2.0 * math.pi * uniform(key, 1)
        sigma = math.sqrt(heat * warmth / mass[kind])
        along = sigma * abs(folded_shift(drift * cosine / sigma) + normal(key, 2))
        one, two = sigma * normal(key, 3), sigma * normal(key, 4)
        internal_energy[p] = heat * warmth * gamma(key, 5, 0.5 * degrees_of_freedom(table[kind], warmth))
        square += internal_energy[p]
        for k in range(3):
            outward = math.cos(turn) * first[k] + math.sin(turn) * second[k]
            steady[p, k] = along * axis[k] + drift * sine * outward
            velocity[p, k] = one * first[k] + two * second[k]
            square += 0.5 * mass[kind] * velocity[p, k] * velocity[p, k]
            linear += mass[kind] * steady[p, k] * velocity[p, k]
            constant += 0.5 * mass[kind] * steady[p, k] * steady[p, k]
    factor = GENTLEST
    discriminant = linear * linear - 4.0 * square * constant
    if discriminant > 0.0:
        factor = min(max((math.sqrt(discriminant) - linear) / (2.0 * square), GENTLEST), STRONGEST)
    for p in range(count):
        internal_energy[p] *= factor * factor
        for k in range(3):
            velocity[p, k] = steady[p, k] + factor * velocity[p, k]
    return energy + constant + factor * (linear + factor * square)


@scalar
def _place(new, nozzle, holes, normal_, radius, seed):
    """Positions of new particles: evenly over the discs of their holes, centres [m] (nozzles, 3)."""
    first, second = _perpendicular(normal_)
    for p in range(len(nozzle)):
        key = stream(seed + INJECTION, 0, new.identity[p])
        out, turn = radius * math.sqrt(uniform(key, 6)), 2.0 * math.pi * uniform(key, 7)
        for k in range(3):
            aside = out * (math.cos(turn) * first[k] + math.sin(turn) * second[k])
            new.position[p, k] = holes[nozzle[p], k] + INSET * normal_[k] + aside


@scalar
def _perpendicular(axis):
    """Two unit vectors perpendicular to a unit vector and to each other."""
    seed = np.zeros(3)
    seed[0 if abs(axis[0]) < 0.9 else 1] = 1.0
    first = seed - np.dot(seed, axis) * axis
    first /= math.sqrt(np.dot(first, first))
    return first, np.cross(axis, first)
