"""Each cell holds its particles, all of one chamber, and about as many as wanted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.parts.gas.corpuscular.cells import PARTNERS, Cells, sort_into_cells
from billow.parts.gas.corpuscular.particles import Particles


def scattered(position, chamber):
    particles = Particles.room_for(len(position))
    particles.count = len(position)
    particles.position[:], particles.chamber[:] = position, chamber
    return particles


def check(cells, particles):
    """Every particle once, in the cell its place says, in ascending order within a cell; returns each one's cell."""
    n = particles.count
    assert sorted(cells.order[:n]) == list(range(n))
    assert cells.start[0] == 0
    assert cells.start[cells.count] == n
    cell = np.repeat(np.arange(cells.count), np.diff(cells.start[: cells.count + 1]))
    order, k = cells.order[:n], particles.chamber[cells.order[:n]]
    assert (np.diff(order)[np.diff(cell) == 0] > 0).all()
    assert ((cells.first[k] <= cell) & (cell < cells.first[k + 1])).all()
    shape, place = cells.shape[k], cell - cells.first[k]
    steps = np.column_stack(
        [place // (shape[:, 1] * shape[:, 2]), place // shape[:, 2] % shape[:, 1], place % shape[:, 2]]
    )
    away = (particles.position[order] - cells.origin[k]) / cells.size[k][:, None] - steps
    assert away.min() > -1e-6
    assert away.max() < 1.0 + 1e-6
    return cell


@given(seed=st.integers(0, 10_000), count=st.integers(1, 300), chambers=st.integers(1, 4), flat=st.floats(0.0, 1.0))
def test_every_particle_is_in_its_cell(seed, count, chambers, flat):
    rng = np.random.default_rng(seed)
    position = rng.normal(size=(count, 3)) * np.array([1.0, flat, flat**4])
    particles = scattered(position, rng.integers(0, chambers, count))
    cells = Cells.of(chambers)
    for step in range(3):
        sort_into_cells(cells, particles, seed, step)
        check(cells, particles)
        particles.position += 0.1 * rng.normal(size=position.shape)


@pytest.mark.parametrize(
    "extent", [(0.3, 0.3, 0.3), (0.7, 0.7, 0.002), (1.0, 0.001, 0.001)], ids=["box", "flat", "tube"]
)
def test_size_gives_the_wanted_partners(extent):
    particles = scattered(np.random.default_rng(1).random((20000, 3)) * extent, 0)
    cells = Cells.of(1)
    for step in range(8):
        sort_into_cells(cells, particles, 0, step)
        check(cells, particles)
        assert 0.5 * PARTNERS < cells.partners[0] < 2.0 * PARTNERS  # from the first sort on
    assert cells.partners[0] == pytest.approx(PARTNERS, rel=0.1)


def test_each_chamber_has_its_own_size():
    rng = np.random.default_rng(2)
    position = np.concatenate([rng.random((5000, 3)), 0.1 * rng.random((5000, 3)), np.ones((1, 3))])
    particles = scattered(position, np.repeat([0, 2, 3], [5000, 5000, 1]))
    cells = Cells.of(4)
    for step in range(6):
        sort_into_cells(cells, particles, 0, step)
    check(cells, particles)
    assert cells.size[0] == pytest.approx(10.0 * cells.size[2], rel=0.1)
    assert cells.first[1] == cells.first[2]  # an empty chamber has no cells


def test_a_distant_lump_of_particles_does_not_make_endless_cells():
    rng = np.random.default_rng(3)
    particles = scattered(np.concatenate([1e-6 * rng.random((3000, 3)), [[1.0, 1.0, 1.0]]]), 0)
    cells = Cells.of(1)
    for step in range(3):
        sort_into_cells(cells, particles, 0, step)
        check(cells, particles)
        assert cells.count < 2 * 3001 + 1000
    together = scattered(np.full((20, 3), 0.25), 0)
    sort_into_cells(cells, together, 0, 9)
    check(cells, together)


def test_particles_can_be_dropped_and_added():
    particles = scattered(np.arange(12.0).reshape(4, 3), [0, 1, 0, 1])
    particles.identity[:] = [5, 6, 7, 8]
    particles.keep(np.array([False, True, False, True]))
    assert particles.count == 2
    assert particles.identity[:2].tolist() == [6, 8]
    assert particles.position[1].tolist() == [9.0, 10.0, 11.0]
    particles.make_room(10)
    assert particles.capacity >= 12
    assert particles.identity[:2].tolist() == [6, 8]
    assert particles.chamber[:2].tolist() == [1, 1]
