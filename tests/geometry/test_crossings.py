"""Edges through triangles: cases done by hand, every edge against every triangle, and what only touches."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.geometry.crossings import crossings, edges_of

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def count(edge, corners=TRIANGLE):
    """Crossings of one edge (2, 3) with one triangle (3, 3) that has no node in common with it."""
    return int(crossings(np.array([[0, 1, 2]]), np.array([[3, 4]]), np.vstack([corners, edge])).sum())


def turn(seed):
    """A rotation at random."""
    matrix, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return matrix


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("edge", "expected"),
    [
        ([[0.2, 0.3, -0.5], [0.2, 0.3, 0.5]], 1),  # through the middle
        ([[0.2, 0.3, -0.5], [0.25, 0.35, 1e-6]], 1),  # just through
        ([[0.2, 0.3, 0.1], [0.2, 0.3, 0.5]], 0),  # above
        ([[2.0, 2.0, -0.5], [2.0, 2.0, 0.5]], 0),  # beside
        ([[0.2, 0.3, 0.0], [0.2, 0.3, 0.5]], 0),  # its end touches
        ([[0.5, 0.5, -0.5], [0.5, 0.5, 0.5]], 0),  # touches a side
        ([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]], 0),  # touches a corner
        ([[-1.0, 0.2, 0.0], [1.0, 0.2, 0.0]], 0),  # in its plane
        ([[-0.6, 0.2, 1e-3], [1.0, 0.2, -1e-3]], 1),  # nearly in its plane
        ([[-30.0, 0.2, -30.2], [30.0, 0.2, 29.8]], 1),  # much longer than the triangle
    ],
)
def test_by_hand_wherever_it_is(edge, expected, seed):
    """Turned and moved in space, so that what touches does so up to rounding."""
    points = np.vstack([TRIANGLE, edge]) @ turn(seed).T + np.array([0.3, -0.2, 0.1])
    assert count(points[3:], points[:3]) == expected


def test_what_shares_a_node_does_not_cross():
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    points = np.random.default_rng(1).normal(size=(5, 3))
    assert crossings(triangles, edges_of(triangles), points).sum() == 0


def test_layers_in_one_place_touch():
    """A bag that lies flat on itself, turned in space."""
    grid = np.stack(np.meshgrid(np.arange(8.0), np.arange(8.0), [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.arange(64).reshape(8, 8)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    lower = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    upper = np.concatenate([np.column_stack([a, d, b]), np.column_stack([b, d, c])]) + 64  # the other diagonals
    points = np.vstack([grid, grid]) @ turn(2).T
    triangles = np.vstack([lower, upper])
    assert crossings(triangles, edges_of(triangles), points).sum() == 0


def of_all(triangles, edges, positions):
    """Every edge against every triangle, by signs of volumes."""

    def volume(a, b, c, d):
        return np.einsum("...i,...i->...", np.cross(b - a, c - a), d - a)

    p, q = (positions[edges[:, k]][:, None] for k in range(2))
    a, b, c = (positions[triangles[:, k]][None] for k in range(3))
    around = np.stack([volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)])
    through = (np.abs(np.sign(around).sum(axis=0)) == 3) & (volume(a, b, c, p) * volume(a, b, c, q) < 0.0)
    shared = (edges[:, None, :, None] == triangles[None, :, None, :]).any(axis=(2, 3))
    return (through & ~shared).sum(axis=0)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.sampled_from([0.05, 0.3, 1.0]), nodes=st.integers(4, 60))
def test_as_every_edge_against_every_triangle(seed, size, nodes):
    """Soups of triangles of very different sizes."""
    random = np.random.default_rng(seed)
    triangles = np.array([random.choice(nodes, 3, replace=False) for _ in range(120)])
    points = random.normal(size=(nodes, 3)) * random.choice([size, 1.0], nodes)[:, None]
    edges = edges_of(triangles)
    assert np.array_equal(crossings(triangles, edges, points), of_all(triangles, edges, points))


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
def test_what_is_no_surface_is_refused(bad):
    points = TRIANGLE.copy()
    points[1, 2] = bad
    with pytest.raises(ValueError, match="positions"):
        crossings(np.array([[0, 1, 2]]), np.array([[0, 1]]), points)


def stack(layers, side, edge=0.005, apart=5e-4):
    """Triangles and positions of sheets that lie on each other, each shifted a little."""
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    one = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    x, y = (edge * axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side), indexing="ij"))
    shifts = np.random.default_rng(3).uniform(-0.3, 0.3, (layers, 2)) * edge
    points = [np.column_stack([x + s[0], y + s[1], np.full(side * side, k * apart)]) for k, s in enumerate(shifts)]
    return np.vstack([one + k * side * side for k in range(layers)]), np.vstack(points)


def test_a_stack_of_sixty_thousand_triangles_takes_less_than_half_a_second():
    triangles, points = stack(20, 40)
    edges = edges_of(triangles)
    assert len(triangles) > 60_000
    assert crossings(triangles, edges, points).sum() == 0
    spent = []
    for _ in range(3):
        begun = time.thread_time()
        crossings(triangles, edges, points)
        spent.append(time.thread_time() - begun)
    assert min(spent) < 0.5
    points[777, 2] += 8e-4  # a node through the next layer: its edges cross it
    assert crossings(triangles, edges, points).sum() >= 3
