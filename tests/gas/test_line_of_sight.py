"""What hides what: squares of directions give the same as every wall against every line of sight."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.parts.gas.supply.inflator import JetRing
from billow.parts.gas.supply.jets import Jets, aim
from billow.parts.gas.supply.line_of_sight import (
    HEIGHT,
    MOST,
    NEARNESS,
    NO_WALLS,
    THRUST,
    WEIGHT,
    WIDTH,
    hide,
    lit_triangles,
    sort_out,
)

UP, X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def covered(of_lit, jet_of_lit, screens, jet_of_screen):
    """Which lines of sight end at a screen of the same jet, all pairs at once."""
    u, v, near = (of_lit[:, column, None] for column in (WIDTH, HEIGHT, NEARNESS))
    (au, av, an), (bu, bv, bn), (cu, cv, cn) = screens.reshape(-1, 3, 3).transpose(1, 2, 0)
    whole = (bu - au) * (cv - av) - (bv - av) * (cu - au)
    second = ((u - au) * (cv - av) - (v - av) * (cu - au)) / whole
    third = ((bu - au) * (v - av) - (bv - av) * (u - au)) / whole
    inside = (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0)
    nearer = an + second * (bn - an) + third * (cn - an) > near * (1.0 + 1e-6)
    return (inside & nearer & (jet_of_lit[:, None] == jet_of_screen)).any(axis=1)


def shreds(seed, count, size):
    """Triangles of all directions in front of the jets, (count, 3) and nodes [m]."""
    random = np.random.default_rng(seed)
    far = 0.3 * np.sqrt(random.uniform(0.01, 1.0, count))
    around, lean = random.uniform(0.0, 2.0 * np.pi, count), random.normal(0.6, 0.15, count)
    middle = np.column_stack([np.sin(lean) * np.cos(around), np.sin(lean) * np.sin(around), np.cos(lean)])
    corners = far[:, None, None] * middle[:, None] + size * random.normal(size=(count, 3, 3))
    return np.arange(3 * count).reshape(-1, 3), corners.reshape(-1, 3)


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.sampled_from([1, 30, 400, 1500]),
    size=st.sampled_from([0.003, 0.02, 0.1]),
    jets=st.integers(1, 12),
)
def test_the_same_as_all_pairs(seed, count, size, jets):
    triangles, positions = shreds(seed, count, size)
    ring = Jets(JetRing(jets, 0.04, 0.005, 0.6), np.array([0]), UP, X).nozzles(np.zeros((1, 3)))
    lit, of_lit, jet_of_lit, screens, jet_of_screen = sort_out(triangles, *NO_WALLS, positions, *ring, 0.005)
    hidden = covered(of_lit, jet_of_lit, screens, jet_of_screen)
    left = of_lit.copy()
    hide(left, jet_of_lit, screens, jet_of_screen, jets)
    assert np.array_equal(left[:, WEIGHT] == 0.0, hidden)
    assert np.array_equal(left[~hidden], of_lit[~hidden])
    found, share, seen = lit_triangles(triangles, *NO_WALLS, positions, *ring, 0.005)
    assert np.array_equal(found, lit[~hidden])
    assert seen == len(set(jet_of_lit[~hidden]))
    corners = positions[triangles[found]]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in set(jet_of_lit[~hidden]):  # along its axis with all it has, if it takes no more than twice
        mine = jet_of_lit[~hidden] == k
        forward = 0.5 * np.sum(share[mine] * of_lit[~hidden][mine, THRUST])
        force = np.linalg.norm(share[mine] @ area[mine])
        assert force < MOST + 1e-12
        assert np.isclose(forward, 1.0, rtol=1e-12) or (forward < 1.0 and np.isclose(force, MOST, rtol=1e-12))


def test_a_wall_that_a_jet_grazes_takes_no_more_than_twice_its_thrust():
    """One triangle whose normal leans: thrust over the cosine of that angle, and never more than twice the thrust."""
    ring = Jets(JetRing(1, 0.0, 0.005, 0.0), np.array([0]), UP, X).nozzles(np.zeros((1, 3)))
    flat = np.array([[0.02, 0.0, 0.0], [-0.01, 0.017, 0.0], [-0.01, -0.017, 0.0]])
    for degrees in (0.0, 45.0, 59.0, 61.0, 85.0, 89.0):
        angle = np.radians(degrees)
        turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        corners = flat @ turn.T + 0.1 * UP
        found, share, seen = lit_triangles(np.array([[0, 1, 2]]), *NO_WALLS, corners, *ring, 0.005)
        force = share[0] * 0.5 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
        assert (found.tolist(), seen) == ([0], 1)
        assert np.isclose(force, min(MOST, 1.0 / np.cos(angle)), rtol=1e-12)


def test_shreds_hide_each_other():
    """Else the test above shows nothing."""
    triangles, positions = shreds(0, 1500, 0.02)
    ring = Jets(JetRing(6, 0.04, 0.005, 0.6), np.array([0]), UP, X).nozzles(np.zeros((1, 3)))
    _, of_lit, *others = sort_out(triangles, *NO_WALLS, positions, *ring, 0.005)
    assert 0.2 < covered(of_lit, *others).mean() < 0.9


def test_a_wall_may_be_any_triangle_and_turned_round():
    """Only the walls count, in their order, whichever way their corners are listed."""
    triangles, positions = shreds(3, 600, 0.02)
    walls = np.arange(0, 600, 2)
    turned = walls % 3 == 0
    listed = triangles.copy()
    listed[walls[turned]] = listed[walls[turned]][:, ::-1]
    jets = Jets(JetRing(6, 0.04, 0.005, 0.6), np.array([0]), UP, X, walls, turned)
    plain = Jets(JetRing(6, 0.04, 0.005, 0.6), np.array([0]), UP, X)
    some, expected = aim(jets, listed, positions), aim(plain, triangles[walls], positions)
    assert len(some.triangles) > 10
    assert np.array_equal(some.triangles, walls[expected.triangles])
    assert np.array_equal(np.abs(some.share), expected.share)
    assert np.array_equal(some.share < 0.0, turned[expected.triangles])
