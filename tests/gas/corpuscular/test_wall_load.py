"""From impulses to forces: patches cover the fabric once, and every newton second is given, none twice."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.scenes import sphere
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.wall_load import PARTICLES_PER_PATCH, Patches, Squares, WallLoad, wall_speed

SHAPE = sphere(0.2, 2)
TRIANGLES, X = SHAPE.surface.triangles, SHAPE.positions
NORMALS = area_vectors(TRIANGLES, X)
N = len(TRIANGLES)
FLAT = X[TRIANGLES].mean(axis=1)[:, :2]
PARTS = (X[TRIANGLES].mean(axis=1)[:, 2] > 0.0).astype(np.int64)
NOTHING = np.zeros(N)
SOLID = np.ones(N, np.bool_)


@pytest.mark.parametrize("particles", [0, 3000, 30_000, 10**7])
def test_every_triangle_is_in_one_patch_of_its_part(particles):
    beside = np.full(N, particles / N)
    patches = Patches.of(Squares.of(FLAT, PARTS, 0.03).patches(beside))
    assert sorted(patches.members) == list(range(N))
    for p in range(patches.count):
        members = patches.members[patches.start[p] : patches.start[p + 1]]
        assert len(members)
        assert len(np.unique(PARTS[members])) == 1
    if particles == 0:
        assert patches.count == 2


def test_more_particles_allow_finer_patches():
    """No more than so many that each could have its particles; only where particles are."""
    squares = Squares.of(FLAT, PARTS, 0.03)
    counts = [Patches.of(squares.patches(np.full(N, k / N))).count for k in (0, 2000, 20_000, 10**7)]
    assert counts == sorted(counts)
    assert counts[0] < counts[2] <= 20_000 / PARTICLES_PER_PATCH
    upper = squares.patches(1e5 * PARTS / N)
    assert len(np.unique(upper[PARTS == 0])) == 1
    assert len(np.unique(upper[PARTS == 1])) > 4


def test_even_impulses_become_pressure():
    """Impulse p A n dt on each triangle is the force p A n, whatever the patch: its area vectors add up."""
    span, pressure = 1e-4, 3e4
    load = WallLoad.none(N)
    impulse = np.repeat(pressure * span * NORMALS[:, None] / 3.0, 3, axis=1)
    load.renew(Patches.of(Squares.of(FLAT, PARTS, 0.03).levels[1]), impulse, NORMALS, span)
    assert load.force == pytest.approx(pressure * NORMALS, rel=1e-9)
    assert not impulse.any()


@pytest.mark.parametrize("steps", [1, 3, 8])
def test_impulse_and_work_close_for_any_steps(steps):
    """What patches hold, and what was given, is what was struck; the corners feel it, half in this step."""
    rng = np.random.default_rng(steps)
    load, patches, dt = WallLoad.none(N), Patches.of(PARTS), 1e-5
    velocity = rng.normal(size=X.shape)
    struck = np.zeros(3)
    before, given, work = np.zeros((N, 3, 3)), np.zeros(3), 0.0
    lead = rng.normal(0.0, 500.0, N)
    for _ in range(5):
        impulse = rng.normal(size=(N, 3, 3)) * 1e-5
        struck += impulse.sum(axis=(0, 1))
        load.renew(patches, impulse, NORMALS, steps * dt)
        for _ in range(steps):
            force = np.zeros((N, 3, 3))
            load.push(SOLID, NOTHING, lead, TRIANGLES, X, velocity, dt, force)
            given += 0.5 * dt * (before + force).sum(axis=(0, 1))
            work += 0.5 * dt * np.sum((before + force) * velocity[TRIANGLES])
            before = force
    scale = np.abs(load.force).sum() * dt * steps
    assert np.abs(load.given - given).max() < 1e-12 * scale
    assert np.abs(load.held.sum(axis=0) + load.given - struck).max() < 1e-12 * scale
    assert load.work == pytest.approx(work, rel=1e-10, abs=1e-12 * scale)


def test_holes_are_not_pushed_and_their_impulse_is_booked():
    load = WallLoad.of_pressure(np.full(N, 1e4), NORMALS)
    solid = SOLID.copy()
    solid[:10] = False
    force = np.zeros((N, 3, 3))
    load.push(solid, np.full(N, 1e4), NOTHING, TRIANGLES, X, np.ones_like(X), 1e-5, force)
    assert not force[:10].any()
    assert np.abs(force[10:]).max() < 1e-9 * 1e4  # ambient pressure balances it
    assert load.given == pytest.approx(1e-5 * 1e4 * NORMALS.sum(axis=0), abs=1e-15)


def crumpled(seed=5):
    """A rough sheet of triangles, its patches, places of its nodes [m], and what drew them."""
    random = np.random.default_rng(seed)
    x, y = (k.ravel() for k in np.meshgrid(np.arange(6.0), np.arange(6.0), indexing="ij"))
    start = 0.01 * np.column_stack([x, y, np.zeros(36)]) + random.normal(0.0, 0.003, (36, 3))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(5), np.arange(5), indexing="ij"))
    a = 6 * i + j
    triangles = np.concatenate([np.column_stack([a, a + 6, a + 7]), np.column_stack([a, a + 7, a + 1])])
    return triangles, Patches.of(np.arange(50) // 10), start, random


def test_a_sheet_that_moves_as_a_whole_is_felt_as_it_moves():
    triangles, patches, start, _ = crumpled()
    velocity, span = np.array([3.0, -5.0, 7.0]), 1e-5
    normals = area_vectors(triangles, start)
    along = normals @ velocity / np.linalg.norm(normals, axis=1)
    felt = wall_speed(patches, triangles, start, start + velocity * span, span)
    assert felt == pytest.approx(along, rel=0.0, abs=1e-8)  # rounding of places over the span


def test_what_particles_lose_is_what_the_patch_gets():
    """Impulses along the normals, given to walls at the speed they feel: their work is that of the patches' force."""
    triangles, patches, start, random = crumpled()
    span = 1e-5
    end = start + random.normal(0.0, 10.0, start.shape) * span
    normals = area_vectors(triangles, 0.5 * (start + end))
    size = random.uniform(0.0, 1e-3, len(triangles))
    impulse = np.zeros((len(triangles), 3, 3))
    impulse[:, 0] = (size / np.linalg.norm(normals, axis=1))[:, None] * normals
    load = WallLoad.none(len(triangles))
    load.renew(patches, impulse, normals, span)
    velocity = ((end - start) / span)[triangles].mean(axis=1)
    given = span * float(np.sum(load.force * velocity))
    taken = float(size @ wall_speed(patches, triangles, start, end, span))
    assert given == pytest.approx(taken, rel=1e-9)


def test_a_closed_patch_keeps_its_pressure():
    """Even impulses on a sphere that is one patch, gas step after gas step: nothing of the pressure bleeds away."""
    span, pressure = 2e-5, 3e4
    whole, load = Patches.of(np.zeros(N, np.int64)), WallLoad.none(N)
    positions, still = X.copy(), np.zeros_like(X)
    for _ in range(5):
        impulse = np.repeat(pressure * span * NORMALS[:, None] / 3.0, 3, axis=1)
        load.renew(whole, impulse, NORMALS, span)
        load.push(SOLID, NOTHING, NOTHING, TRIANGLES, positions, still, span, np.zeros((N, 3, 3)))
    assert load.force == pytest.approx(pressure * NORMALS, rel=1e-9, abs=1e-9 * pressure * np.abs(NORMALS).max())
