"""Collisions keep momentum and energy, and lead every gas to the equilibrium its energy table asks for.

Tolerances are four standard deviations of the finite number of particles and averages unless said otherwise.
"""

from __future__ import annotations

import numpy as np
import pytest
from gas_in_a_box import Box

from billow.parts.gas.corpuscular.collisions import collision_time
from billow.parts.gas.supply.mixture import mixture_cp, mixture_gas_constant
from billow.parts.gas.supply.species import Species

DIATOMIC = Species.ideal("diatomic", 287.0, 1.4)
DT = 2e-5


def settle(box, steps, dt=DT):
    for _ in range(steps):
        box.fly(dt)
        box.collide(1.0)


def settled_flight(box, steps):
    """Flight temperature of each species, relative to the temperature of the whole gas, averaged over steps."""
    found = []
    for _ in range(steps):
        settle(box, 1)
        found.append(box.flight_temperatures())
    return np.mean(found, axis=0) / box.temperature()


def test_every_step_keeps_momentum_and_energy():
    box = Box(["He", "N2", "CO2"], [4000, 3000, 3000], [300.0, 700.0, 1200.0])
    scale = np.sum(box.mass * np.abs(box.particles.velocity[:, 0]))
    for _ in range(10):
        before = box.sums()
        assert box.collide(1.0) > 4000
        after = box.sums()
        assert np.abs(after.momentum - before.momentum).max() < 1e-13 * scale
        assert after.energy == pytest.approx(before.energy, rel=1e-13)
        assert (after.internal_energy != before.internal_energy).all()


def test_maxwell():
    """All particles start equally fast. Mean over rms speed sqrt(8/(3 pi)) = 0.92132, kurtosis of a component 3."""
    box = Box(["Ar"], [20000], [500.0])
    velocity = box.particles.velocity
    velocity /= np.linalg.norm(velocity, axis=1)[:, None] / 500.0
    ratio, kurtosis = [], []
    settle(box, 10)
    for _ in range(20):  # independent after two or three steps: 1e5 samples and more
        settle(box, 1)
        speed = np.linalg.norm(velocity, axis=1)
        ratio.append(speed.mean() / np.sqrt(np.mean(speed**2)))
        kurtosis.append(np.mean(velocity**4) / np.mean(velocity**2) ** 2)
    assert np.mean(ratio) == pytest.approx(np.sqrt(8.0 / (3.0 * np.pi)), rel=0.002)
    assert np.mean(kurtosis) == pytest.approx(3.0, rel=0.01)


def test_internal_energy_comes_from_flight():
    """zeta = 2, nothing stored at the start: 3/2 k T0 is shared by 5 degrees of freedom, T = 0.6 T0."""
    box = Box([DIATOMIC], [30000], [500.0], stored=False)
    start = box.flight_temperatures()[0]
    settle(box, 20)
    found = []
    for _ in range(20):
        settle(box, 1)
        found.append(box.flight_temperatures()[0] / start)
    assert np.mean(found) == pytest.approx(0.6, rel=0.002)


def test_helium_and_argon_reach_a_common_temperature():
    box = Box(["He", "Ar"], [15000, 15000], [300.0, 900.0])
    settle(box, 60)  # a collision of 4 with 40 g/mol evens out a sixth of the difference
    relative = settled_flight(box, 300)  # which deviate by 0.1 %
    # Partial pressures go with the numbers of molecules.
    assert relative == pytest.approx(1.0, rel=0.005)
    assert relative.mean() == pytest.approx(1.0, rel=1e-3)  # both equally many: the energy is all in flight


@pytest.mark.parametrize(
    ("species", "counts", "temperatures", "tolerance"),
    [
        ([DIATOMIC], [20000], [500.0], 0.002),
        (["N2", "H2O", "CO2"], [9000, 6000, 5000], [800.0] * 3, 0.003),
        (["He", "Ar", "N2", "CO2"], [5000] * 4, [300.0, 500.0, 900.0, 1200.0], 0.005),
        (["CO2"], [20000], [650.0], 0.005),
    ],
    ids=["constant-cp", "pyro", "four-species", "carbon-dioxide"],
)
def test_equilibrium_is_that_of_the_energy_table(species, counts, temperatures, tolerance):
    """Flight at T means p V = N k T with the T of the table. Where zeta bends, cells of ten particles are off by up to
    0.3 %, on top of the statistics: 0.14 % for the mean of 60 steps, 0.06 % for that of 300."""
    box = Box(species, counts, temperatures)
    settle(box, 15)
    assert settled_flight(box, 300) == pytest.approx(1.0, rel=tolerance)


@pytest.mark.parametrize("gamma", [5.0 / 3.0, 1.4, 9.0 / 7.0])
def test_slow_compression_is_isentropic(gamma):
    """Volume 2:1 by a piston at 5 % of the thermal speed: cp/cv is found to 0.01 (the piston's own entropy)."""
    box = Box([Species.ideal("gas", 287.0, gamma)], [6000], [500.0])
    start, speed = box.temperature(), np.sqrt(287.0 * 500.0)
    piston = 0.05 * speed
    steps = 250
    dt = 0.5 * box.length / piston / steps
    for _ in range(steps):
        box.fly(dt, piston)
        box.collide(dt)
    assert 1.0 + np.log(box.temperature() / start) / np.log(2.0) == pytest.approx(gamma, abs=0.01)
    assert box.flight_temperatures()[0] == pytest.approx(box.temperature(), rel=0.02)


def test_compression_with_variable_heat_capacity():
    """Pyrotechnic gas 2:1: integral of cv dT/T = R ln 2."""
    box = Box(["N2", "H2O", "CO2"], [2700, 1800, 1500], [600.0] * 3)
    masses = box.sums().particles.sum(axis=0) * box.kinds.mass
    start, constant = box.temperature(), mixture_gas_constant(box.kinds.table, masses)
    piston, steps = 0.05 * 400.0, 250
    dt = 0.5 * box.length / piston / steps
    for _ in range(steps):
        box.fly(dt, piston)
        box.collide(dt)
    temperatures = np.linspace(start, box.temperature(), 2001)
    slope = [(mixture_cp(box.kinds.table, masses, t) - constant) / t for t in temperatures]
    assert np.trapezoid(slope, temperatures) / constant == pytest.approx(np.log(2.0), rel=0.02)


@pytest.mark.parametrize("times", [0.2, 1.5])
def test_rate_is_one_free_path(times):
    """Each particle collides dt/tau times, tau = 0.75 cells over the mean thermal speed, also more than once."""
    box = Box(["N2"], [30000], [600.0])
    box.collide(0.0)
    tau = collision_time(box.cells, box.kinds, np.ones(1), box.temperature())
    assert tau == pytest.approx(0.75 * box.cells.size[0] / np.sqrt(8.0 / np.pi * 296.8 * box.temperature()), rel=1e-3)
    size = box.cells.size[0]
    collided = 2.0 * box.collide(times * tau)
    expected = times * 30000 * size / box.cells.size[0]
    # Cells of a single particle have no partner for it; the mean of sqrt(T) lies below sqrt of the mean.
    assert 0.97 * expected < collided < 1.01 * expected


def test_same_bits_for_any_number_of_threads(threads):
    def run(count):
        threads(count)
        box = Box(["He", "CO2"], [5000, 5000], [300.0, 900.0])
        settle(box, 3)
        return box.particles.velocity.tobytes() + box.particles.internal_energy.tobytes()

    assert run(1) == run(2)


def test_seeds_differ():
    def run(seed):
        box = Box(["N2"], [1000], [300.0])
        box.seed = seed
        box.collide(1.0)
        return box.particles.velocity.copy()

    assert (run(1) == run(1)).all()
    assert (run(1) != run(2)).any()


def test_too_few_to_collide():
    for count in (0, 1):
        box = Box(["N2"], [count], [300.0])
        before = box.particles.velocity.copy()
        assert box.collide(1.0) == 0
        assert (box.particles.velocity == before).all()
    resting = Box(["N2"], [5], [300.0], stored=False)
    resting.particles.velocity[:] = [10.0, 0.0, 0.0]
    assert resting.collide(1.0) == 0  # one velocity, nothing to share
