"""T15 to T20: the corpuscular gas against closed forms of kinetic theory, and a leak audit.

Boxes, tolerances and numbers of particles as in billow.apps.verification.particles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAS_CONSTANT, HEIGHT, IDEAL, VOLUME, bag_of_height
from billow.apps.verification.particles import books, in_a_box, over_walls, steps, wall_areas
from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case
from billow.parts.gas.corpuscular.corpuscular import SMOOTHING, Corpuscular
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import VENT, Passage
from billow.parts.gas.supply.species import SPECIES, Species, mass_fractions

MONATOMIC = [Species.ideal("monatomic", GAS_CONSTANT, 5.0 / 3.0)]
DRIVER = {
    "bag": {"element_size": 0.05, "initial_gap": 0.04},
    "fabric": {"permeability": 0.0275},
    "gas": {"model": "corpuscular", "particles": 8000},
}


def maxwell() -> Iterator[Measurement]:
    """T15: particles that all start equally fast end with Maxwell's speeds: mean over rms sqrt(8/(3 pi)) = 0.92132, and
    kurtosis 3 of a component. 8,000 particles, 10 times 0.5 ms apart: 0.1 % and 0.3 %.
    """
    gas = in_a_box(MONATOMIC, 8_000, 1e5, 300.0)
    state = gas.start(bag_of_height(HEIGHT))
    velocity = state.particles.velocity[: state.particles.count]
    speed = np.sqrt(3.0 * GAS_CONSTANT * 300.0)
    velocity *= (speed / np.linalg.norm(velocity, axis=1))[:, None]
    state.sums = None
    ratio, kurtosis = [], []
    for k, _ in enumerate(steps(gas, state, 160, 5e-5)):
        if k >= 60 and k % 10 == 9:
            velocity = state.particles.velocity[: state.particles.count]
            square = np.sum(velocity**2, axis=1)
            ratio.append(np.sqrt(square).mean() / np.sqrt(square.mean()))
            kurtosis.append(np.mean(velocity**4) / np.mean(velocity**2) ** 2)
    yield Measurement("mean over rms speed [-]", np.mean(ratio), np.sqrt(8.0 / (3.0 * np.pi)), 2e-3)
    yield Measurement("kurtosis of a component [-]", np.mean(kurtosis), 3.0, 1e-2)


def flux() -> Iterator[Measurement]:
    """T16: molecules strike walls n c/4 times a second and area, which is p/sqrt(2 pi R T) = 0.39894 p/sqrt(R T) of
    mass; those that leave through a small hole fly with 2 k T (Bird, Molecular Gas Dynamics, 1994, section 4.2).

    A monatomic gas; 2e5 hits: 0.2 %. Then holes that let one in fifty pass, until half of 8,000 particles have left:
    0.7/sqrt(4,000) = 1.1 %, four of them independent: 0.55 %. The additional k T/2 of the outflow is booked separately.
    """
    gas = in_a_box(MONATOMIC, 8_000, 1e5, 300.0)
    state = gas.start(bag_of_height(HEIGHT))
    expected = 1e5 / np.sqrt(2.0 * np.pi * GAS_CONSTANT * 300.0)
    struck = [over_walls(state.bank.mass_flux[:, 0]) for _ in steps(gas, state, 220, 1e-4)]
    yield Measurement("flux of mass on a wall [kg/m^2/s]", np.mean(struck[20:]), expected, 1e-2)
    hole = Passage("holes", VENT, ORIFICE, 0, triangles=np.arange(12), area=0.02)
    taken = warmth = 0.0
    for seed in range(4):
        gas = replace(in_a_box(MONATOMIC, 8_000, 1e5, 300.0, passages=(hole,), outside=1.0), seed=seed)
        state = gas.start(bag_of_height(HEIGHT))
        before = state.masses.sum(), state.temperature[0]
        for _ in steps(gas, state, 100, 1e-4):
            mass, temperature = state.masses.sum(), state.temperature[0]
            warmth += (before[0] - mass) * GAS_CONSTANT * before[1]
            before = mass, temperature
        taken += state.enthalpy_out
    yield Measurement("energy of those that leave over k T [-]", taken / warmth - 0.5, 2.0, 1e-2)


def relaxation() -> Iterator[Measurement]:
    """T17: a gas of two internal degrees of freedom that starts with all its energy in flight ends at T = 0.6 T0.

    8,000 particles, 200 steps, of which 20 are independent: 0.13 %.
    """
    gas = in_a_box(IDEAL, 8_000, 1e5, 300.0)
    state = gas.start(bag_of_height(HEIGHT))
    state.particles.internal_energy[:] = 0.0
    state.sums = None
    start = 2.0 / 3.0 * _flight(state, gas).sum() / VOLUME
    pressure = []
    for k, _ in enumerate(steps(gas, state, 260, 5e-5)):
        if k >= 60:
            pressure.append(state.pressure[0])
    yield Measurement("flight temperature over that at the start [-]", np.mean(pressure) / start, 0.6, 5e-3)


def mixture() -> Iterator[Measurement]:
    """T18: helium at 450 K and argon at 300 K in one box, half of the molecules each, end at 375 K and at p = n k T.

    4,000 particles each: sqrt(2/3)/sqrt(4,000) = 1.3 % at a time, 0.2 % over 200 steps.
    """
    species = [SPECIES["He"], SPECIES["Ar"]]
    fractions = np.array(list(mass_fractions({"He": 0.5, "Ar": 0.5}).values()))
    gas = in_a_box(species, 8_000, 1e5, 300.0, fractions=fractions)
    state = gas.start(bag_of_height(HEIGHT))
    number = state.particles.count
    light = state.particles.species[:number] == 0
    state.particles.velocity[:number][light] *= np.sqrt(1.5)
    state.sums = None
    kinds = ParticleKinds(gas.table, state.molecules)
    total = 2.0 / 3.0 * _flight(state, gas).sum()
    found, pressure = [], []
    for k, _ in enumerate(steps(gas, state, 300, 5e-5)):
        if k >= 100:
            species_now = state.particles.species[:number]
            energy = _flight(state, gas)
            found.append([energy[species_now == s].mean() / (1.5 * kinds.heat) for s in (0, 1)])
            pressure.append(over_walls(state.bank.pressure[:, 0]))
    common = total / (number * kinds.heat)
    helium, argon = np.mean(found, axis=0)
    yield Measurement("temperature of helium [K]", helium, common, 5e-3)
    yield Measurement("temperature of argon [K]", argon, common, 5e-3)
    yield Measurement("pressure on the walls [Pa]", np.mean(pressure), number * kinds.heat * common / VOLUME, 5e-3)


def wall_noise() -> Iterator[Measurement]:
    """T19: the pressure from some hits varies by sqrt(4/pi)/sqrt(hits) = 1.13/sqrt(hits) of itself: speeds across a
    wall are Rayleigh's, <v^2>/<v>^2 = 4/pi, and arrivals are independent.

    Pressure of single steps, from the running mean that takes the share 1 - exp(-dt/tau) of each. A step sees 1 % of
    the particles at most, which are as good as independent. Triangles of three sizes and two numbers of particles; 480
    steps, four triangles: 2 % for each standard deviation.
    """
    dt, area = 5e-5, wall_areas()
    share = -np.expm1(-dt / SMOOTHING)
    hits, noise, level = [], [], []
    for particles in (1_000, 8_000):
        gas = in_a_box(MONATOMIC, particles, 1e5, 300.0)
        state = gas.start(bag_of_height(HEIGHT))
        means = [state.bank.pressure[:, 0].copy() for _ in steps(gas, state, 500, dt)]
        pressure = (np.diff(means, axis=0) / share + means[:-1])[20:] / 1e5
        a_second = state.particles.count / VOLUME * np.sqrt(GAS_CONSTANT * 300.0 / (2.0 * np.pi))
        level.append(pressure.mean(axis=0) @ area / area.sum())
        for size in np.unique(area.round(9)):
            of_size = np.isclose(area, size)
            hits.append(a_second * size * dt)
            noise.append(np.sqrt(np.mean((pressure[:, of_size] - 1.0) ** 2)))
    slope, _ = np.polyfit(np.log(hits), np.log(noise), 1)
    yield Measurement("mean pressure over n k T [-]", np.mean(level), 1.0, 5e-3)
    yield Measurement("noise times sqrt(hits) [-]", np.mean(noise * np.sqrt(hits)), np.sqrt(4.0 / np.pi), 0.1)
    yield Measurement("slope of noise over hits, double logarithmic [absolute]", slope, -0.5, 0.03)


def leak_audit() -> Iterator[Measurement]:
    """T20: a driver bag is crushed to a sixth of its height, blown up and shaken within 20 ms, while jets blow into it
    and gas leaves through vents and fabric. Each motion is affine, so that no fabric goes through other fabric, and the
    mouth does not tilt. Independent checks on the way find every particle in its chamber, and the balances close.
    """
    case = Case.from_dict(DRIVER)
    shape = build_shape(case.bag)
    gas, x = build_gas(case, shape).model, shape.positions
    still = np.zeros_like(x)
    state = gas.start(Bag(shape.surface, x.copy(), still))
    dt, last, force = 2e-5, x.copy(), np.zeros((shape.surface.triangle_count, 3, 3))
    for k in range(1000):
        phase = 2.0 * np.pi * (k + 1) * dt / 0.010
        moved = x * [1.0, 1.0, 4.0 ** np.sin(phase) * 0.5 ** (0.5 - 0.5 * np.cos(phase))]
        moved[:, 0] += 2.0 * np.sin(3.0 * phase) * moved[:, 2]
        moved[:, 1] += np.sin(2.0 * phase) * moved[:, 2]
        gas.advance(state, Bag(shape.surface, moved, (moved - last) / dt), k * dt, dt, force)
        last = moved
    yield Measurement("particles found outside their chamber [absolute]", state.escaped, 0.0, 0.5)
    yield from books(state)


def _flight(state: CorpuscularState, gas: Corpuscular) -> np.ndarray:
    """Kinetic energy of each particle [J], (particles,)."""
    particles, kinds = state.particles, ParticleKinds(gas.table, state.molecules)
    n = particles.count
    return 0.5 * kinds.mass[particles.species[:n]] * np.sum(particles.velocity[:n] ** 2, axis=1)
