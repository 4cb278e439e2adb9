"""Passes that each thread makes for its own cells or triangles: the same bits however many parts there are."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.compiled import CHUNK
from billow.geometry.search_grid import _list
from billow.parts.gas.corpuscular.cells import _place
from billow.parts.gas.corpuscular.impact_bank import HIT_NUMBERS, HITS_PER_CHUNK, _collect
from billow.parts.gas.corpuscular.particles import ParticleArrays, Particles

PARTS = (2, 3, 16)


def collected(parts):
    rng = np.random.default_rng(1)
    count = rng.integers(0, HITS_PER_CHUNK + 1, 5)
    triangle = rng.integers(0, 40, (5, HITS_PER_CHUNK)).astype(np.int32)
    triangle = np.where(rng.random(triangle.shape) < 0.5, triangle, ~triangle)
    held, struck = np.zeros((40, 3, 3)), np.zeros((40, 2, 2))
    numbers = rng.normal(size=(5, HITS_PER_CHUNK, HIT_NUMBERS))
    _collect.serial(int(count.sum()), parts, count, triangle, numbers, held, struck)
    return held, struck


def placed(parts):
    rng = np.random.default_rng(2)
    cell, first = rng.integers(0, 50, 3000).astype(np.int32), np.array([0, 20, 50])
    cell[rng.random(3000) < 0.5] = 7
    start, order, partners = np.full(60, 9, np.int32), np.zeros(3000, np.int32), np.zeros(2)
    _place.serial(3000, parts, cell, first, start, order, np.array([1800, 1200]), partners)
    assert np.array_equal(order, np.argsort(cell, kind="stable"))
    return start[:51], order, partners


def listed(parts):
    rng = np.random.default_rng(3)
    counts = np.array([9, 5, 4])
    low = rng.integers(0, counts, (200, 3))
    high = np.minimum(low + rng.integers(0, 4, (200, 3)), counts - 1)
    spans = np.stack([low, high], axis=2).reshape(200, 6).astype(np.int32)
    number = np.zeros(counts.prod(), np.int32)
    _list.serial(200, parts, spans, counts, number, np.empty(0, np.uint32))
    first = np.concatenate([[0], np.cumsum(number)]).astype(np.int32)
    triangles = np.empty(first[-1], np.uint32)
    _list.serial(200, parts, spans, counts, first[:-1].copy(), triangles)
    for cell, place in enumerate(np.ndindex(*counts)):
        own = np.flatnonzero(((low <= place) & (place <= high)).all(axis=1))
        assert np.array_equal(triangles[first[cell] : first[cell + 1]], own)
    return number, triangles


@pytest.mark.parametrize("done", [collected, placed, listed])
def test_parts_do_not_change_a_bit(done):
    whole = done(1)
    for parts in PARTS:
        for one, many in zip(whole, done(parts), strict=True):
            assert np.array_equal(one, many)


def test_reordering_moves_whole_particles():
    """All that is known of a particle goes with it, and dropping particles keeps the order of those that stay."""
    rng, n = np.random.default_rng(4), 3 * CHUNK
    particles = Particles.room_for(n + 100)
    particles.add(n)
    particles.position[:n], particles.velocity[:n] = rng.normal(size=(2, n, 3))
    particles.internal_energy[:n] = rng.random(n)
    for name in ("species", "chamber", "overlap"):
        getattr(particles, name)[:n] = rng.integers(0, 5, n)
    for _ in range(3):  # the arrays that are free take turns
        before = ParticleArrays(*(values.copy() for values in particles.arrays()))
        order = rng.permutation(n).astype(np.int32)
        particles.reorder(order)
        assert particles.capacity == n + 100
        for old, new in zip(before, particles.arrays(), strict=True):
            assert np.array_equal(old[order], new)
    before, wanted = ParticleArrays(*(values.copy() for values in particles.arrays())), rng.random(n) < 0.7
    particles.keep(wanted)
    assert particles.count == np.count_nonzero(wanted)
    for old, new in zip(before, particles.arrays(), strict=True):
        assert np.array_equal(old[wanted], new)
    particles.make_room(500)  # of another size from now on
    particles.reorder(np.arange(particles.count, dtype=np.int32)[::-1].copy())
    assert np.array_equal(particles.identity[: particles.count], before.identity[wanted][::-1])
