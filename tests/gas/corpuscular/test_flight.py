"""Flight between walls: mirror images, moving walls, pressure, openings, vents, ledgers, bits."""

from __future__ import annotations

import numpy as np
import pytest
from flights import MASS, Scene, box, enclosure, flock_of, kinetic

from billow.geometry import search_grid
from billow.parts.gas.corpuscular.flight import STANDOFF
from billow.parts.gas.corpuscular.winding_number import winding_numbers

CUBE = box()
DT = 1e-4


def random_flock(n, rng, speed=400.0, low=0.01, high=0.99):
    return flock_of(rng.uniform(low, high, (n, 3)), rng.normal(0.0, speed, (n, 3)))


def folded(x):
    """Mirror images of an endless straight line in the unit interval."""
    x = np.mod(x, 2.0)
    return np.where(x > 1.0, 2.0 - x, x)


def test_paths_are_mirror_images_of_straight_lines():
    """A specular box unfolds: x(t) = fold(x0 + v t). Each hit turns back STANDOFF too early, 2 STANDOFF of path."""
    flock = random_flock(2000, np.random.default_rng(1), speed=900.0)
    start, velocity = flock.position.copy(), flock.velocity.copy()
    scene = Scene(*CUBE[:2], flock)
    steps, hits = 40, 0
    for _ in range(steps):
        hits += scene.advance(DT).hits
    most = np.abs(velocity).max() * steps * DT + 1.0
    assert hits > 5000
    assert np.abs(flock.position - folded(start + velocity * steps * DT)).max() < 2.0 * STANDOFF * most
    assert np.allclose(np.abs(flock.velocity), np.abs(velocity), rtol=1e-12)


@pytest.mark.parametrize("w", [-120.0, 0.0, 80.0])
def test_a_moving_wall_reflects_in_its_own_frame(w):
    """v_n' = 2 w - v_n; the particle loses J w; the hit is where the wall was met."""
    triangles, positions, _, _ = CUBE
    v = 300.0
    flock = flock_of([[0.9, 0.37, 0.41]], [[v, 50.0, -20.0]])
    scene = Scene(triangles, positions, flock)
    end = positions.copy()
    end[positions[:, 0] == 1.0, 0] += w * 5e-4
    tally = scene.advance(5e-4, end)
    t = 0.1 / (v - w)
    assert tally.hits == 1
    assert flock.velocity[0] == pytest.approx([2.0 * w - v, 50.0, -20.0], rel=1e-12)
    met = 1.0 + w * t
    assert flock.position[0, 0] == pytest.approx(met + (2.0 * w - v) * (5e-4 - t), abs=1e-8)
    impulse = 2.0 * MASS * (v - w)
    assert scene.bank.held.sum(axis=(0, 1)) == pytest.approx([impulse, 0.0, 0.0], rel=1e-12, abs=1e-18)
    assert tally.energy_to_walls == pytest.approx(impulse * w, rel=1e-12, abs=1e-18)
    # Barycentric weights: the impulse acts where the particle met the wall.
    corners = positions[triangles]
    moment = np.einsum("tci,tc->i", corners, scene.bank.held[:, :, 0]) / impulse
    assert moment[1:] == pytest.approx([0.37 + 50.0 * t, 0.41 - 20.0 * t], abs=1e-7)


def test_pressure_is_two_thirds_of_the_energy_density():
    """Kinetic theory, paper equation 8; each wall's mean has deviation 1.13 / sqrt(hits) (docs/theory.md, case T19)."""
    rng = np.random.default_rng(3)
    flock = random_flock(50_000, rng)
    scene = Scene(*CUBE[:2], flock)
    for _ in range(40):
        scene.advance(DT)
    expected = 2.0 / 3.0 * kinetic(flock)
    face = np.repeat(np.arange(6), 2 * 4 * 4)
    for k in range(6):
        struck = scene.bank.struck[face == k, 0]
        pressure, hits = struck[:, 0].sum() / (40 * DT), struck[:, 1].sum() / MASS
        assert pressure == pytest.approx(expected, rel=4.0 * 1.13 / np.sqrt(hits))


def test_momentum_and_energy_close():
    """Gas + bank is constant, whatever the walls do: to 1e-12 of what was exchanged."""
    rng = np.random.default_rng(5)
    triangles, positions, _, _ = CUBE
    flock = random_flock(20_000, rng)
    momentum, energy = MASS * flock.velocity.sum(axis=0), kinetic(flock)
    scene = Scene(triangles, positions, flock)
    swirl = rng.normal(0.0, 60.0, positions.shape)
    for _ in range(30):
        scene.advance(DT, scene.positions + swirl * DT)
    exchanged = np.abs(scene.bank.held).sum()
    assert np.abs(MASS * flock.velocity.sum(axis=0) + scene.bank.held.sum(axis=(0, 1)) - momentum).max() < (
        1e-12 * exchanged
    )
    assert abs(kinetic(flock) + scene.work - energy) < 1e-12 * energy
    assert abs(scene.work) > 1e-3 * energy


def test_a_moving_scene_is_the_same_scene():
    """Galilean invariance: everything at 100 m/s more changes nothing but rounding."""
    triangles, positions, _, _ = CUBE
    drift = np.array([100.0, -40.0, 10.0])
    ends = []
    for v in (np.zeros(3), drift):
        flock = random_flock(300, np.random.default_rng(7))
        flock.velocity[:] += v
        scene = Scene(triangles, positions, flock)
        for _ in range(10):
            scene.advance(DT, scene.positions + v * DT)
        ends.append(flock.position - v * 10 * DT)
    assert np.abs(ends[1] - ends[0]).max() < 1e-9


def test_exact_aim_at_corners_edges_and_diagonals_stays_inside():
    """From the centre at every node, every edge's middle and every triangle's middle of a cube, in binary fractions."""
    triangles, positions, _, _ = CUBE
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    targets = np.concatenate([positions, positions[edges].mean(axis=1), positions[triangles].mean(axis=1)])
    velocity = (targets - 0.5) * 1024.0
    flock = flock_of(np.full_like(targets, 0.5), velocity)
    scene = Scene(triangles, positions, flock)
    for _ in range(64):  # steps that end exactly at the walls are among them
        scene.advance(2.0**-12)
        assert (flock.position > 0.0).all()
        assert (flock.position < 1.0).all()
    assert np.allclose((flock.velocity**2).sum(axis=1), (velocity**2).sum(axis=1), rtol=1e-12)


def test_an_inner_wall_separates_two_rooms_and_its_opening_joins_them():
    """Tight: no particle changes rooms, both sides feel their own gas. Open: a particle's chamber follows it."""
    triangles, positions, behind, ahead = box(rooms=2)
    rng = np.random.default_rng(9)
    inner = (behind == 0) & (ahead == 1)
    for opening in (0.0, 1.0):
        flock = random_flock(4000, rng)
        flock.chamber[:] = rng.integers(0, 2, 4000)
        flock.position[:, 0] += flock.chamber
        before = flock.chamber.copy()
        scene = Scene(triangles, positions, flock, behind, ahead, np.where(inner, opening, 0.0))
        for _ in range(30):
            tally = scene.advance(DT)
            assert (flock.chamber == (flock.position[:, 0] > 1.0)).all()
        assert (flock.position > 0.0).all()
        assert (flock.position < [2.0, 1.0, 1.0]).all()
        struck = scene.bank.struck[inner]
        assert (struck[:, :, 1].sum(axis=0) > 0.0).all()  # both sides
        if opening:
            assert 0 < np.count_nonzero(flock.chamber != before) < 4000
            assert tally.passed > 0
            assert not scene.bank.held[inner].any()
        else:
            assert (flock.chamber == before).all()


def test_an_opening_that_flaps_mistakes_no_particle():
    """An opening turns so far in a step that straight paths pass a triangle of it, and back: by the winding number each
    particle is in the chamber that flight says, with the overlap that it counts."""
    triangles, positions, behind, ahead = box(rooms=2)
    inner, rng = (behind == 0) & (ahead == 1), np.random.default_rng(3)
    flapping = (positions[:, 0] == 1.0) & (np.abs(positions[:, 1:] - 0.5).max(axis=1) < 0.4)
    flock = random_flock(6000, rng)
    flock.chamber[:] = rng.integers(0, 2, 6000)
    flock.position[:, 0] += flock.chamber
    scene = Scene(triangles, positions, flock, behind, ahead, np.where(inner, 1.0, 0.0))
    passed = 0
    for _ in range(10):
        end = scene.positions.copy()
        end[flapping] = positions[flapping] + rng.uniform(-0.1, 0.1, (flapping.sum(), 3))
        passed += scene.advance(DT, end).passed
        winding = winding_numbers(flock.position, flock.chamber, enclosure(triangles, end, behind, ahead))
        np.testing.assert_array_equal(winding, 1 + flock.overlap)
    assert passed > 1000


def test_every_passage_of_a_step_counts_and_has_its_sign():
    """From 0.5 to the opening at 1, the far wall at 2, the opening, the near wall at 0, the opening: 5 m in a step."""
    triangles, positions, behind, ahead = box(rooms=2)
    inner = (behind == 0) & (ahead == 1)
    ways = np.array([0.3, 2.0, 3.0, 5.0])
    flock = flock_of([[0.5, 0.4, 0.3]] * 4, np.column_stack([ways / DT, np.zeros((4, 2))]))
    passed = []
    for k in range(4):
        one = flock_of(flock.position[k : k + 1], flock.velocity[k : k + 1])
        tally = Scene(triangles, positions, one, behind, ahead, np.where(inner, 1.0, 0.0)).advance(DT)
        passed.append((tally.passed, round(float(tally.through[0]) / MASS, 12)))
    assert passed == [(0, 0.0), (1, 1.0), (2, 0.0), (3, 1.0)]
    back = flock_of([[1.5, 0.4, 0.3]], [[-1.0 / DT, 0.0, 0.0]], chamber=1)
    tally = Scene(triangles, positions, back, behind, ahead, np.where(inner, 1.0, 0.0)).advance(DT)
    assert tally.through.tolist() == [-MASS]


def test_vents_let_their_share_of_particles_pass():
    """The number passing is binomial in the hits; it does not depend on the order of the particles."""
    triangles, positions, behind, ahead = CUBE
    vent = (positions[triangles, 2] == 1.0).all(axis=1)
    share = 0.3
    rng = np.random.default_rng(13)
    first = random_flock(20_000, rng)
    order = rng.permutation(20_000)
    second = flock_of(first.position[order], first.velocity[order])
    second.identity[:] = order
    gone = []
    for flock in (first, second):
        scene = Scene(triangles, positions, flock, behind, ahead, np.where(vent, share, 0.0))
        for _ in range(10):
            scene.advance(DT)
        out = flock.chamber == -1
        assert vent[flock.exit[out]].all()
        assert np.abs(flock.position[out, 2] - 1.0).max() < 1e-12
        met = scene.bank.struck[vent, 0, 1].sum() / MASS
        assert abs(out.sum() - share * met) < 4.0 * np.sqrt(met * share * (1.0 - share))
        gone.append(np.sort(flock.identity[out]))
    assert np.array_equal(*gone)


def test_the_search_does_not_change_the_answer(monkeypatch):
    """Cell size, age of the lists, and knowing which cells are clear decide the time it takes, not one bit of the
    result."""
    triangles, positions, _, _ = box(divisions=4)
    ends = []
    for cell, most_clear in ((0.2, 7), (0.8, 7), (4.0, 7), (0.2, 0)):
        if not most_clear:
            monkeypatch.setattr(search_grid, "cells_to_lists", lambda first, _: np.zeros(len(first) - 1, np.uint8))
        flock = random_flock(3000, np.random.default_rng(15))
        scene = Scene(triangles, positions, flock, fineness=search_grid.Fineness(cell, 0.5))
        for k in range(20):
            scene.advance(DT, positions * (1.0 + 0.02 * np.sin(0.4 * k)))
        ends.append(flock.position)
    assert all(np.array_equal(ends[0], end) for end in ends[1:])


def test_same_bits_for_any_number_of_threads(threads):
    results = []
    for count in (1, 2):
        threads(count)
        flock = random_flock(20_000, np.random.default_rng(17))
        scene = Scene(*CUBE[:2], flock, pass_probability=np.full(len(CUBE[0]), 0.1))
        for k in range(6):
            scene.advance(DT, CUBE[1] * (1.0 + 0.01 * k))
        results.append((flock.position, flock.velocity, flock.chamber, scene.bank.held, scene.bank.struck))
    for one, many in zip(*results, strict=True):
        assert np.array_equal(one, many)


def test_newborn_particles_fly_the_rest_of_the_step():
    """They are the last ones; those before them fly all of it."""
    flock = flock_of([[0.5, 0.5, 0.5]] * 3, [[900.0, 0.0, 0.0]] * 3)
    scene = Scene(*CUBE[:2], flock)
    scene.advance(1e-3, born=np.array([0.25, 0.75]))
    assert flock.position[:, 0] == pytest.approx(folded(0.5 + 900.0 * np.array([1e-3, 0.75e-3, 0.25e-3])), abs=1e-8)


def test_a_particle_without_a_finite_position_is_reported():
    flock = random_flock(5, np.random.default_rng(19))
    flock.velocity[3, 1] = np.nan
    assert Scene(*CUBE[:2], flock).advance(DT).bad == 3
