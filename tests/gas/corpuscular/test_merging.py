"""Merging every two particles into one keeps what a gas has, to rounding, and what it is like, to statistics."""

from __future__ import annotations

import numpy as np
import pytest
from gas_in_a_box import SIDE, Box
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.apps.verification.gas import GAMMA, IDEAL, inflow, steps
from billow.apps.verification.particles import LID, in_a_box
from billow.apps.verification.scenes import HEIGHT, VOLUME, bag_of_height
from billow.base import compiled
from billow.parts.gas.corpuscular import corpuscular
from billow.parts.gas.corpuscular.cells import Cells, sort_into_cells
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, degrees_of_freedom
from billow.parts.gas.corpuscular.merging import GROUP, Remainder, merge, merges_ahead
from billow.parts.gas.corpuscular.particles import sum_particles
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import VENT, Passage


class Divided(Box):
    """A box whose halves in z are chambers of their own."""

    def __init__(self, species, counts, temperatures, seed=0):
        super().__init__(species, counts, temperatures, seed=seed)
        self.particles.chamber[:] = self.particles.position[:, 2] > 0.5 * SIDE
        self.cells, self.remainder, self.left = Cells.of(2), Remainder.none(2, len(counts)), np.zeros(2)
        self.merges = 0

    def merge(self):
        sort_into_cells(self.cells, self.particles, self.seed, self.merges)
        self.left += merge(self.particles, self.kinds, self.cells, self.remainder, self.seed, self.merges)
        self.merges += 1
        self.kinds = ParticleKinds(self.kinds.table, 2.0 * self.kinds.molecules)

    def sums(self):
        return sum_particles(self.particles, self.kinds.mass, 2)


@settings(max_examples=40)
@given(counts=st.lists(st.integers(0, 300), min_size=3, max_size=3), seed=st.integers(0, 99))
def test_down_to_the_last_particle_nothing_is_lost(counts, seed):
    """Masses by chamber and species exactly; momentum and energy to the rounding of some hundred additions."""
    box = Divided(["N2", "CO2", "He"], counts, [300.0, 600.0, 400.0], seed)
    before = box.sums()
    scale = np.sqrt(2.0 * before.flight_energy.sum() * (before.particles @ box.kinds.mass).sum())
    for _ in range(5):
        box.merge()
        now = box.sums()
        assert (now.particles + box.remainder.number == before.particles / 2.0**box.merges).all()
        assert np.abs(box.remainder.number).max() <= 0.5
        momentum = now.momentum.sum(axis=0) + box.remainder.momentum
        assert np.abs(momentum - before.momentum.sum(axis=0)).max() <= 1e-13 * scale
        assert now.energy + box.remainder.energy + box.left.sum() == pytest.approx(before.energy, rel=1e-13)
    assert box.particles.count <= sum(counts) // 32 + 3


def test_energies_of_flight_and_internal_energies_are_kept_in_each_chamber():
    """Even numbers of everything: nothing is left over."""
    box = Divided(["N2", "CO2"], [4000, 4000], [300.0, 900.0])
    box.particles.chamber[:] = np.arange(8000) // 2 % 2
    box.particles.species[:] = np.arange(8000) % 2
    before = box.sums()
    places = {
        place.tobytes(): chamber for place, chamber in zip(box.particles.position, box.particles.chamber, strict=True)
    }
    box.merge()
    now, n = box.sums(), box.particles.count
    assert n == 4000
    assert not box.remainder.number.any()
    assert now.particles * 2 == pytest.approx(before.particles, abs=0.0)
    scale = np.sqrt(2.0 * before.flight_energy * (before.particles @ box.kinds.mass))
    assert np.abs(now.momentum - before.momentum).max() <= 1e-14 * scale.max()
    assert now.flight_energy == pytest.approx(before.flight_energy, rel=1e-14)
    assert now.internal_energy == pytest.approx(before.internal_energy, rel=1e-14)
    # Everyone is where one of them was, and goes by a name of its own.
    assert len(np.unique(box.particles.identity[:n])) == n
    for place, chamber in zip(box.particles.position[:n], box.particles.chamber[:n], strict=True):
        assert places[place.tobytes()] == chamber


def test_a_gas_at_equilibrium_stays_there():
    """Maxwell's fourth moment, 3; variance of stores over mean^2, 2/zeta; even in space. Four standard deviations.

    A group's energy is that of twice as many particles and varies less than its own would: 1/GROUP off the moment.
    """
    box = Divided(["N2"], [60_000], [600.0])
    box.merge()
    n = box.particles.count
    velocity = box.particles.velocity[:n].ravel()
    sigma = np.sqrt(600.0 * box.kinds.heat / box.kinds.mass[0])
    assert np.std(velocity) == pytest.approx(sigma, rel=4.0 * np.sqrt(0.5 / 180_000))  # of the particles before
    kurtosis = np.mean(velocity**4) / np.mean(velocity**2) ** 2
    assert kurtosis == pytest.approx(3.0, abs=4.0 * np.sqrt(24.0 / len(velocity)) + 1.0 / GROUP)
    zeta = degrees_of_freedom(box.kinds.table[0], 600.0)
    store = box.particles.internal_energy[:n]
    spread = np.var(store) / np.mean(store) ** 2
    # Of exponential stores (zeta = 2): var(s^2)/s^4 = 8/n, and the mean counts twice, less their covariance.
    assert spread == pytest.approx(2.0 / zeta, rel=4.0 * np.sqrt(4.0 / n) + 1.0 / GROUP)
    assert box.particles.position[:n].mean(axis=0) == pytest.approx(SIDE / 2.0, abs=4.0 * SIDE / np.sqrt(12.0 * n))


def test_a_jet_through_resting_gas_stays_a_jet():
    """A third of the particles at 600 m/s, the others at rest, all cold: a mean of two would fly at 300 m/s."""
    box = Divided(["N2"], [9000], [1.0])
    fast = box.particles.position[:, 0] * 3.0 < SIDE * (0.5 + box.particles.position[:, 1] / SIDE)
    box.particles.velocity[fast, 0] += 600.0
    before = box.sums()
    box.merge()
    now = box.sums()
    speed = box.particles.velocity[: box.particles.count, 0]
    # Groups are put right by factors within a few tenths, where jet and rest meet.
    assert np.mean((speed > 150.0) & (speed < 450.0)) < 0.005
    assert np.mean(speed > 450.0) == pytest.approx(fast.mean(), abs=0.01)
    energy = now.energy + box.remainder.energy
    assert energy == pytest.approx(before.energy, rel=1e-13)


def test_same_bits_with_the_parallel_compilation(monkeypatch, threads):
    def merged(count):
        monkeypatch.setattr(compiled, "PARALLEL_FROM", 0)
        threads(count)
        box = Divided(["N2", "He"], [5001, 3000], [300.0, 600.0])
        box.merge()
        return b"".join(array.tobytes() for array in box.particles.arrays())

    assert merged(1) == merged(2)


def test_merges_ahead():
    """So many that the start has between half of the particles and all: 2^merges <= growth in molecules."""
    table = np.zeros((2, 16))
    table[:, 0] = 300.0, 600.0
    grows = lambda start, end: merges_ahead(table, np.array(start), np.array(end))  # noqa: E731
    assert grows([1.0, 0.0], [1.0, 0.0]) == 0
    assert grows([1.0, 0.0], [1.0, 0.4]) == 0
    assert grows([1.0, 0.0], [1.0, 0.5]) == 1  # twice the molar mass in half the mass
    assert grows([1.0, 0.0], [9.0, 0.0]) == 3
    assert grows([0.0, 0.0], [1.0, 1.0]) == 10


def filled(particles, passages=(), forget=False):
    """50 g at 600 K within 25 ms into 60 l that hold 3.5 g; gives the gas after each step."""
    flow = inflow(2.0, 0.025, 600.0, np.ones(1))
    gas = in_a_box(IDEAL, particles, 5e3, 300.0, inflator=flow, passages=passages, outside=5e3)
    state = gas.start(bag_of_height(HEIGHT))
    for k, time in enumerate(steps(gas, state, 600, 5e-5)):
        if forget and k % 7 == 0:
            state.grid = state.hits = state.sums = state.patches = None
        yield time, state


def test_a_rigid_box_fills_as_if_nothing_were_merged(monkeypatch):
    """Flight's share of the energy, by which pressures of one history differ from another's, in means of 100 steps.

    0.52/sqrt(N) at a time; a mean holds about 10 independent ones, a difference two such means: 4 sigma = 0.93/sqrt(N).
    Without merging there are N of 170 particles at the start, 2000 at the end; with it never fewer than 950.
    """
    means, counts = [], []
    for merges in (merges_ahead, lambda *_: 0):
        monkeypatch.setattr(corpuscular, "merges_ahead", merges)
        history = [(state.pressure[0], state.particles.count, state) for _, state in filled(2000)]
        pressure, count, (*_, state) = zip(*history, strict=True)
        means.append(np.array(pressure).reshape(6, 100).mean(axis=1))
        counts.append(np.array(count).reshape(6, 100).mean(axis=1))
        assert state.merges == (3 if merges is merges_ahead else 0)
        assert max(count) <= 2000 + 2000 // 50 + 64 == state.particles.capacity
        assert count[-1] + state.remainder.number.sum() == pytest.approx(2000, abs=1.0)
        assert state.mass_error < 2e-14
        assert state.energy_error < 2e-14
        assert state.momentum_error < 4e-14
        assert state.escaped == 0
    noise = 0.93 * np.sqrt(0.5 / counts[0] + 0.5 / counts[1])
    assert (np.abs(means[0] / means[1] - 1.0) <= noise).all()
    thermal = 5e3 * VOLUME / (GAMMA - 1.0) + 0.05 * GAMMA / (GAMMA - 1.0) * 287.0 * 600.0  # at rest, at the end
    assert means[0][-1] == pytest.approx((GAMMA - 1.0) * thermal / VOLUME, rel=0.93 / np.sqrt(2.0 * 2000))


def test_merging_works_with_rebuilt_caches_and_vents():
    """Merged while gas leaves: same bits after all caches are rebuilt, and books that close."""
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=LID, area=1e-3)

    def end(forget):
        *_, (_, state) = filled(1000, (hole,), forget)
        assert state.merges >= 2
        assert state.left.sum() > 0.0
        assert state.mass_error < 2e-14
        assert state.energy_error < 2e-14
        assert state.momentum_error < 4e-14
        n = state.particles.count
        return state.particles.position[:n].tobytes() + state.load.force.tobytes()

    assert end(True) == end(False)
