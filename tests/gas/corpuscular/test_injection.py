"""Injection delivers mass, enthalpy and thrust of the inflator, particle by particle."""

from __future__ import annotations

import numpy as np
import pytest
from gas_in_a_box import Box
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.parts.gas.corpuscular.injection import Injector, Nozzles, folded_shift, turned
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.particles import Particles, sum_particles
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant, mixture_temperature
from billow.parts.gas.supply.outflow import jet_speed
from billow.parts.gas.supply.species import Species, find_species, thermo_table

UP = np.array([0.0, 0.0, 1.0])
TABLE = thermo_table([find_species(name, "test") for name in ("N2", "H2O", "CO2")])
FRACTIONS = np.array([0.45, 0.30, 0.25]) / TABLE[:, 0]
FRACTIONS /= FRACTIONS.sum()
END = 0.05


def ring(count=6, lean=1.0, half_angle=0.3, spin=0.0, radius=0.0025):
    azimuth = 2.0 * np.pi * np.arange(count) / count
    radial = np.column_stack([np.cos(azimuth), np.sin(azimuth), np.zeros(count)])
    direction = np.sin(lean) * radial + np.cos(lean) * UP
    return Nozzles(0.04 * radial, direction, np.arange(count, dtype=np.int32), radius, half_angle, UP, spin)


def injector(particles=3000, nozzles=None, hot=800.0, cold=600.0, table=TABLE, fractions=FRACTIONS, mass=0.05):
    curve = Inflator(
        np.array([0.0, 0.008, END]), np.array([0.0, 2.0 * mass / END, 0.0]), np.array([0.0, END]),
        np.array([cold, hot]), fractions,
    )  # fmt: skip
    return Injector(ParticleKinds.sharing(table, mass * fractions, particles), curve, nozzles or ring())


def blow_all(source, dt=2e-4, velocity=(0.0, 0.0, 0.0), pressure=1.2e5, seed=0):
    delivery, particles, births = source.start(), Particles.room_for(10), []
    for step in range(round(END / dt)):
        births.append(source.blow(delivery, particles, step * dt, dt, np.zeros(3), np.array(velocity), pressure, seed))
    return delivery, particles, births


@settings(max_examples=25)
@given(
    particles=st.integers(1, 2000), dt=st.floats(5e-5, 2e-3), until=st.floats(1e-3, 1.2 * END), seed=st.integers(0, 99)
)
def test_mass_is_the_closed_form_to_one_particle(particles, dt, until, seed):
    source = injector(particles)
    delivery, flock = source.start(), Particles.room_for(0)
    time = 0.0
    while time < until:
        source.blow(delivery, flock, time, dt, np.zeros(3), np.zeros(3), 1e5, seed)
        time += dt
    counted = np.bincount(flock.species[: flock.count], minlength=3) * source.kinds.mass
    assert delivery.mass(source.kinds) == pytest.approx(counted, abs=1e-14)
    pending = source.inflator.delivered(time) * FRACTIONS - counted
    molecules = pending / source.kinds.mass  # in particles
    assert -1e-9 < molecules.sum() < 1.0
    assert np.abs(molecules).max() < 1.5
    assert len(np.unique(flock.identity[: flock.count])) == flock.count


def test_species_and_nozzles_get_their_share():
    source = injector(6000)
    delivery, _, _ = blow_all(source)
    exact = 0.05 * FRACTIONS / source.kinds.mass / 6
    assert np.abs(delivery.born - exact).max() <= 1.0


def test_every_batch_has_its_enthalpy():
    """Energy of a batch is that of its particles; sums reach the delivered enthalpy to a fraction of a particle."""
    source = injector(40000)
    delivery, particles, births = blow_all(source)
    first, given_energy = 0, 0.0
    for birth in births:
        last = first + birth.count
        flight = np.sum(
            source.kinds.mass[particles.species[first:last]] * np.sum(particles.velocity[first:last] ** 2, axis=1) / 2.0
        )
        assert flight + particles.internal_energy[first:last].sum() == pytest.approx(birth.energy, rel=1e-12, abs=1e-15)
        first, given_energy = last, given_energy + birth.energy
    assert delivery.energy == pytest.approx(given_energy, rel=1e-12)
    # Enthalpy of the curve: the exact integral of flow times h(T(t)).
    time = np.linspace(0.0, END, 4001)
    flow = np.interp(time, source.inflator.flow_time, source.inflator.mass_flow)
    enthalpy = [mixture_enthalpy(TABLE, FRACTIONS, t) for t in np.interp(time, [0.0, END], [600.0, 800.0])]
    assert delivery.offered == pytest.approx(np.trapezoid(flow * enthalpy, time), rel=1e-4)  # midpoint rule
    assert abs(delivery.pending_energy) < 1.0 * delivery.offered / 40000
    # Batch by batch, where the temperature does not change.
    steady = injector(40000, hot=700.0, cold=700.0)
    _, particles, births = blow_all(steady)
    for birth in births:
        if birth.count > 30:
            assert birth.energy == pytest.approx(mixture_enthalpy(TABLE, birth.mass, 700.0), rel=1e-9)


def test_batches_of_one_carry_what_they_cannot_take():
    source = injector(300, hot=700.0, cold=700.0)
    delivery, particles, births = blow_all(source, dt=5e-5)
    assert max(birth.count for birth in births) == 1
    assert abs(delivery.pending_energy) < 1.0 * delivery.offered / 300
    assert particles.count == 300


@pytest.mark.parametrize("gamma", [1.4, 1.25])
def test_rigid_tank(gamma):
    """30 g at 600 K into an evacuated 60 l tank: T = gamma 600 K, p = m R T/V (120.5 kPa at 1.4), once it has settled.

    Flight at the end: statistics of 8,000 particles and 40 averages, 4 sigma = 0.4 %.
    """
    table, one = thermo_table([Species.ideal("gas", 287.0, gamma)]), np.ones(1)
    source = injector(8000, hot=600.0, cold=600.0, table=table, fractions=one, mass=0.03)
    _, particles, _ = blow_all(source)
    side = 0.06 ** (1.0 / 3.0)
    box = Box([Species.ideal("gas", 287.0, gamma)], [particles.count], [300.0], molecules=source.kinds.molecules)
    box.particles.velocity[:] = particles.velocity[: particles.count]
    box.particles.internal_energy[:] = particles.internal_energy[: particles.count]
    box.particles.chamber[:] = 0
    assert box.temperature() == pytest.approx(gamma * 600.0, rel=1e-3)  # one particle may be pending
    pressure = []
    for step in range(80):
        box.fly(4e-5)
        box.collide(1.0)
        if step >= 40:
            pressure.append(2.0 / 3.0 * box.sums().flight_energy[0] / side**3)
    assert np.mean(pressure) == pytest.approx(0.03 * 287.0 * gamma * 600.0 / 0.06, rel=0.005)


def test_thrust_is_mass_flow_times_choked_speed():
    """Along each jet; cosine-weighted cone: <cos> = 2/3 (1 - cos^3 a)/sin^2 a. 2 % are 4 sigma of 20,000 particles."""
    source = injector(20000, hot=700.0, cold=700.0)
    _, particles, births = blow_all(source)
    n = particles.count
    nozzle, mass = particles.chamber[:n], source.kinds.mass[particles.species[:n]]
    along = np.sum(particles.velocity[:n] * source.nozzles.direction[nozzle], axis=1)
    cone = 2.0 / 3.0 * (1.0 - np.cos(0.3) ** 3) / np.sin(0.3) ** 2
    speed = jet_speed(TABLE, FRACTIONS, 700.0)
    assert mass @ along == pytest.approx(mass.sum() * speed * cone, rel=0.02)
    assert along.min() > 0.0  # nothing flies back into its hole
    impulse = np.sum([birth.impulse for birth in births], axis=0)
    assert impulse == pytest.approx([0.0, 0.0, mass.sum() * speed * cone * np.cos(1.0)], abs=0.03 * mass.sum() * speed)
    sums = sum_particles(particles, source.kinds.mass, 6)
    assert sums.momentum.sum(axis=0) == pytest.approx(impulse, abs=1e-12)


def test_a_wide_mouth_blows_slowly():
    """u = mdot/(rho A), where that is below the choked speed."""
    nozzles = ring(lean=0.0, half_angle=0.0, radius=0.02)
    source = injector(4000, nozzles=nozzles, hot=700.0, cold=700.0)
    _, particles, _ = blow_all(source, pressure=1e5)
    aside = particles.velocity[: particles.count, :2]
    density = 1e5 / (mixture_gas_constant(TABLE, FRACTIONS) * 700.0)
    drift = 1.0 / (density * nozzles.area)  # mean flow 1 kg/s
    assert drift < 0.7 * jet_speed(TABLE, FRACTIONS, 700.0)
    # Slower than thermal motion, thus the mean of |xi| sigma; hotter than a choked jet.
    assert np.std(aside) > np.sqrt(mixture_gas_constant(TABLE, FRACTIONS) * 700.0)


def test_jets_that_spin():
    """A jet inclined by 60 degrees, 40 turns a second: momentum, turned back, points where the hole was at the start.

    0.04 rad are 4 sigma of 20,000 particles.
    """
    spin, dt = 2.0 * np.pi * 40.0, 2e-4
    source = injector(20000, nozzles=ring(count=1, lean=np.radians(60.0), half_angle=0.0, spin=spin))
    _, particles, births = blow_all(source, dt)
    first, total = 0, np.zeros((1, 3))
    for step, birth in enumerate(births):
        last, angle = first + birth.count, spin * dt * (step + 1)
        total += turned(birth.impulse[None, :], UP, -angle)
        hole = [0.04 * np.cos(angle), 0.04 * np.sin(angle), 1e-5]
        if last > first:
            assert np.linalg.norm(particles.position[first:last] - hole, axis=1).max() <= 0.0025 * (1.0 + 1e-9)
        first = last
    assert total[0, 0] > 0.0
    assert total[0, 1] / total[0, 0] == pytest.approx(0.0, abs=0.04)
    assert total[0, 2] / total[0, 0] == pytest.approx(np.tan(np.radians(30.0)), abs=0.04)


@given(angle=st.floats(-10.0, 10.0))
def test_turning(angle):
    vectors = np.array([[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0]])
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    result = turned(vectors, axis, angle)
    assert np.linalg.norm(result, axis=1) == pytest.approx(np.linalg.norm(vectors, axis=1), rel=1e-12)
    assert result @ axis == pytest.approx(vectors @ axis, rel=1e-12, abs=1e-12)
    assert turned(result, axis, -angle) == pytest.approx(vectors, abs=1e-12)
    assert turned(np.array([[1.0, 0.0, 0.0]]), UP, np.pi / 2)[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


def test_a_moving_mouth_carries_its_gas():
    """Same particles, seen from a mouth at rest; what the motion adds is booked apart."""
    source = injector(3000)
    still, moving = blow_all(source), blow_all(source, velocity=(30.0, -20.0, 10.0))
    n = still[1].count
    assert moving[1].velocity[:n] - still[1].velocity[:n] == pytest.approx(
        np.tile([30.0, -20.0, 10.0], (n, 1)), abs=1e-9
    )
    energy = sum_particles(moving[1], source.kinds.mass, 6).energy
    assert energy == pytest.approx(sum(b.energy + b.carried_energy for b in moving[2]), rel=1e-12)
    assert moving[0].energy == still[0].energy


def test_new_particles_start_at_their_hole():
    source = injector(3000)
    _, particles, _ = blow_all(source)
    position, nozzle = particles.position[: particles.count], particles.chamber[: particles.count]
    aside = np.linalg.norm((position - source.nozzles.offset[nozzle])[:, :2], axis=1)
    assert np.abs(position[:, 2] - 1e-5).max() <= 1e-12
    assert 0.0024 < aside.max() <= 0.0025


def test_the_folded_normal():
    """Mean of |s + xi| by quadrature."""
    x = np.linspace(-12.0, 12.0, 200001)
    density = np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi)
    for mean in (0.81, 1.0, 1.7, 5.0):
        assert np.trapezoid(np.abs(folded_shift(mean) + x) * density, x) == pytest.approx(mean, rel=1e-9)
    assert folded_shift(0.5) == 0.0


def test_the_drift_lowers_the_temperature():
    """Temperature across the jet: e(T) = h(T_in) - u^2/2, each direction of flight with R T per mass (3 %)."""
    source = injector(20000, nozzles=ring(lean=0.0, half_angle=0.0), hot=700.0, cold=700.0)
    _, particles, _ = blow_all(source)
    n = particles.count
    mass = source.kinds.mass[particles.species[:n]]
    drift = jet_speed(TABLE, FRACTIONS, 700.0)
    warm = mixture_temperature(TABLE, FRACTIONS, mixture_enthalpy(TABLE, FRACTIONS, 700.0) - 0.5 * drift**2, 700.0)
    across = np.mean(mass * particles.velocity[:n, 0] ** 2) / source.kinds.heat
    assert across > warm  # takes what folding leaves of the motion along the jet
    assert across == pytest.approx(warm, rel=0.2)
