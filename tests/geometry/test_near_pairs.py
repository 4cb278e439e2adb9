"""Pairs of nodes and triangles that are near each other, against every node with every triangle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.geometry.near_pairs import MOST_CELLS, near_pairs
from billow.geometry.surface import area_vectors

NOTHING = np.empty(0, np.int64), np.empty(0, np.int64)


def distances(points, corners):
    """Of every point from every triangle [m], (points, triangles): the nearest of the foot in the plane and on each
    side; corners (triangles, 3, 3)."""
    best = np.full((len(points), len(corners)), np.inf)
    for t, (a, b, c) in enumerate(corners):
        system = np.column_stack([b - a, c - a])
        weights, *_ = np.linalg.lstsq(system, (points - a).T, rcond=None)
        over = (weights >= 0.0).all(axis=0) & (weights.sum(axis=0) <= 1.0)
        height = np.linalg.norm(points - a - (system @ weights).T, axis=1)
        best[over, t] = height[over]
        for p, q in ((a, b), (b, c), (c, a)):
            along = np.clip((points - p) @ (q - p) / np.sum((q - p) ** 2), 0.0, 1.0)
            best[:, t] = np.minimum(best[:, t], np.linalg.norm(points - p - along[:, None] * (q - p), axis=1))
    return best


def crumpled(seed, across, height):
    """A square sheet of 2 across^2 triangles, pushed together at random; height: of its folds, in edges."""
    random = np.random.default_rng(seed)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(across + 1), np.arange(across + 1), indexing="ij"))
    flat = np.column_stack([i, j, np.zeros_like(i)]).astype(float)
    folds = random.normal(size=(6, 2))
    for wave in folds:
        phase = flat[:, :2] @ wave
        flat += height * np.column_stack([np.sin(phase), np.cos(1.3 * phase), np.sin(phase + 1.0)])
    flat += 0.1 * random.normal(size=flat.shape)
    a = (np.arange(across)[:, None] * (across + 1) + np.arange(across)).ravel()
    below = np.column_stack([a, a + across + 1, a + across + 2])
    return flat, np.concatenate([below, np.column_stack([a, a + across + 2, a + 1])])


def soup(seed, nodes, count):
    """Any triangles of any nodes."""
    random = np.random.default_rng(seed)
    return random.uniform(-3.0, 3.0, (nodes, 3)), np.array(
        [random.choice(nodes, 3, replace=False) for _ in range(count)]
    )


def expected(positions, nodes, triangles, faces, reach, outward, kept):
    apart = distances(positions[nodes], positions[triangles[faces]])
    near = outward[nodes] @ area_vectors(triangles, positions)[faces].T < 0.0
    near[np.searchsorted(nodes, kept[0]), np.searchsorted(faces, kept[1])] = True
    near &= apart <= reach
    near &= ~(nodes[:, None, None] == triangles[faces]).any(axis=2)
    p, t = np.nonzero(near)
    order = np.lexsort((faces[t], nodes[p]))
    return nodes[p][order], faces[t][order], apart[p, t][order]


def check(positions, nodes, triangles, faces, reach, outward, kept=NOTHING):
    found = near_pairs(positions, nodes, triangles, faces, reach, outward, *kept)
    node, triangle, apart = expected(positions, nodes, triangles, faces, reach, outward, kept)
    whose = np.repeat(np.arange(len(positions)), np.diff(found.start))
    assert np.array_equal(whose, node)
    assert np.array_equal(found.triangle, triangle)
    assert np.sqrt(found.apart[:, 0]) == pytest.approx(apart, rel=1e-9, abs=1e-9)
    normals = area_vectors(triangles, positions)[triangle]
    up = np.sum((positions[node] - positions[triangles[triangle, 0]]) * normals, axis=1)
    up /= np.linalg.norm(normals, axis=1)
    assert found.apart[:, 1] == pytest.approx(apart**2 - up**2, rel=1e-6, abs=1e-9)
    return len(node)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), height=st.floats(0.0, 2.0), reach=st.sampled_from([0.2, 0.8, 3.0]))
def test_crumpled_sheets(seed, height, reach):
    positions, triangles = crumpled(seed, 9, height)
    outward = np.random.default_rng(seed).normal(size=positions.shape)
    check(positions, np.arange(len(positions)), triangles, np.arange(len(triangles)), reach, outward)


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6), nodes=st.integers(4, 80), count=st.integers(1, 120),
    reach=st.sampled_from([0.05, 0.5, 20.0]), dropped=st.integers(1, 4),
)  # fmt: skip
def test_any_triangles_and_some_of_them(seed, nodes, count, reach, dropped):
    positions, triangles = soup(seed, nodes, count)
    outward = np.random.default_rng(seed).normal(size=positions.shape)
    some, faces = np.arange(0, nodes, dropped), np.arange(0, count, dropped)
    check(positions, some, triangles.astype(np.uint32), faces, reach, outward)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0.0, 1.0))
def test_pairs_that_are_kept(seed, share):
    """Whichever way their nodes point, whether they are found anyway or not."""
    positions, triangles = crumpled(seed, 7, 1.0)
    random = np.random.default_rng(seed)
    outward = random.normal(size=positions.shape)
    nodes, faces = np.arange(len(positions)), np.arange(len(triangles))
    p, t = np.nonzero(random.uniform(size=(len(nodes), len(faces))) < 0.2 * share)
    strange = (p[:, None] != triangles[t]).all(axis=1)
    order = random.permutation(strange.sum())
    check(positions, nodes, triangles, faces, 0.8, outward, (p[strange][order], t[strange][order]))


def test_a_bag_has_pairs():
    """Else the tests above show nothing: two layers close to each other, and the folds of a crumpled sheet."""
    positions, triangles = crumpled(3, 12, 1.5)
    outward = np.random.default_rng(3).normal(size=positions.shape)
    everything = np.arange(len(positions)), triangles, np.arange(len(triangles))
    assert check(positions, *everything, 0.8, outward) > len(positions)


def test_a_flat_sheet_and_a_wide_scene():
    """A grid of one layer of cells; and cells and blocks that have to grow, so that a few of them fill the scene."""
    positions, triangles = crumpled(0, 8, 0.0)
    positions[:, 2] = 0.0
    lifted = positions + np.array([0.3, 0.3, 0.5])
    both, faces = np.vstack([positions, lifted]), np.vstack([triangles, triangles[:, ::-1] + len(positions)])
    outward = np.zeros_like(both)
    outward[: len(positions), 2], outward[len(positions) :, 2] = 1.0, -1.0
    assert check(both, np.arange(len(both)), faces, np.arange(len(faces)), 0.8, outward) > len(both)
    both = np.vstack([both, [4000.0, -3000.0, 2000.0]])
    outward = np.vstack([outward, [0.0, 0.0, 1.0]])
    assert MOST_CELLS < 4000.0 * 3000.0 * 2000.0
    assert check(both, np.arange(len(both)), faces, np.arange(len(faces)), 0.8, outward) > len(both)


def test_nothing_has_no_pairs():
    positions, triangles = crumpled(0, 3, 0.0)
    for nodes, faces in ((NOTHING[0], np.arange(4)), (np.arange(4), NOTHING[0])):
        found = near_pairs(positions, nodes, triangles, faces, 1.0, positions, *NOTHING)
        assert len(found.triangle) == 0
        assert not found.start.any()


def test_triangles_without_area_have_no_pairs():
    positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 1.0, 0.0]])
    triangles = np.array([[0, 1, 2], [0, 0, 1], [0, 2, 4]])
    found = near_pairs(positions, np.array([3]), triangles, np.arange(3), 1.0, -np.ones_like(positions), *NOTHING)
    assert list(found.triangle) == [2]


def test_same_bits_for_any_threads(threads):
    positions, triangles = crumpled(5, 30, 1.0)
    arguments = positions, np.arange(len(positions)), triangles, np.arange(len(triangles)), 0.8, positions, *NOTHING
    found = []
    for count in (1, 2):
        threads(count)
        found.append(near_pairs(*arguments))
    assert all(one.tobytes() == other.tobytes() for one, other in zip(*found, strict=True))
