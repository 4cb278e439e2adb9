"""From impulses to forces: patches cover the fabric once, and every newton second is given, none twice."""

from __future__ import annotations

import numpy as np
import pytest

from billow.gas.corpuscular.wall_load import PARTICLES_PER_PATCH, Patches, Squares, WallLoad
from billow.geometry.surface import area_vectors
from billow.verification.meshes import sphere

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
        assert (patches.patch[members] == p).all()
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
