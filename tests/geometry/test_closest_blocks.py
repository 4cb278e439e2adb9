"""Closest points of blocks of pairs are those of pairs one by one."""

import numpy as np
import pytest

from billow.base.compiled import kernel
from billow.geometry.closest_blocks import (
    BLOCK,
    ROWS,
    SQUARE,
    S,
    T,
    X,
    Y,
    Z,
    fill,
    nodes_on_triangles,
    segments_on_segments,
)  # fmt: skip
from billow.geometry.closest_points import of_segments, on_triangle


@kernel
def answers(n, places, edges, out):
    block = np.zeros(ROWS * BLOCK)
    for j in range(n):
        fill(block, j, places[j], 0, 1, 2, 3)
    if edges:
        segments_on_segments(block)
    else:
        nodes_on_triangles(block)
    for j in range(n):
        out[j, 0], out[j, 1], out[j, 2] = block[S + j], block[T + j], block[X + j]
        out[j, 3], out[j, 4], out[j, 5] = block[Y + j], block[Z + j], block[SQUARE + j]


def scenes(kind, random):
    places = random.normal(size=(BLOCK, 4, 3))
    if kind == "flat":
        places[:, :, 2] *= 1e-6
    elif kind == "on a grid":  # touching, parallel, in one place, without length
        places = random.integers(0, 2, places.shape).astype(float)
    elif kind == "sliver":
        places[:, 3] = places[:, 2] + 1e-4 * places[:, 3]
    elif kind == "far away":
        places = 1e-3 * places + 10.0
    return places


@pytest.mark.parametrize("kind", ["any", "flat", "on a grid", "sliver", "far away"])
@pytest.mark.parametrize("edges", [False, True])
def test_blocks_find_the_closest_points(kind, edges):
    random, out = np.random.default_rng(3), np.empty((BLOCK, 6))
    for _ in range(40):
        places = scenes(kind, random)
        answers(BLOCK, places, edges, out)
        for (a, b, c, d), (s, t, *way, square) in zip(places, out, strict=True):
            nearest = (of_segments if edges else on_triangle)(*a, *b, *c, *d)
            size = np.abs(places).max()
            assert np.sqrt(square) == pytest.approx(np.linalg.norm(nearest[2:]), abs=1e-7 * size)
            one = a + s * (b - a) if edges else a
            other = c + t * (d - c) if edges else b + s * (c - b) + t * (d - b)
            assert np.abs(one - other - way).max() < 1e-12 * size
            assert min(s, t) >= 0.0
            assert (max(s, t) if edges else s + t) <= 1.0 + 1e-12
