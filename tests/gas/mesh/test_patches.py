"""Fragments of a surface before and after a step, together."""

from __future__ import annotations

import numpy as np

from billow.apps.verification.scenes import sphere
from billow.base.scratch import Scratch
from billow.geometry.cut_cells import Window, cut_cells, unite
from billow.geometry.surface import area_vectors
from billow.parts.gas.mesh.patches import AREA, BEFORE, SIDE, SPEED, Patches


def test_every_fragment_has_a_patch_and_areas_are_those_of_the_time_between():
    ball, moves = sphere(2.3, 2), np.array([0.4, -0.3, 0.2])
    triangles, before = ball.surface.triangles, ball.positions + 0.37
    after, window = before * 1.05 + moves, Window.none()
    old, new = (cut_cells(triangles, np.ones(len(triangles)), places, window) for places in (before, after))
    _, in_old, in_new = unite(old.key, new.key)
    patches = Patches.find(in_old, in_new, old, new, triangles, np.tile(moves, (len(before), 1)), Scratch())
    rows, own = patches.rows, np.arange(len(patches.triangle))
    np.testing.assert_array_equal(patches.of_old[patches.old[patches.old >= 0]], own[patches.old >= 0])
    np.testing.assert_array_equal(patches.of_new[patches.new[patches.new >= 0]], own[patches.new >= 0])
    assert len(own) < len(old.cell) + len(new.cell)
    np.testing.assert_allclose(rows[:, SPEED : SPEED + 3], np.tile(moves, (len(own), 1)), atol=1e-9)
    whole = np.bincount(patches.triangle, rows[:, BEFORE])
    np.testing.assert_allclose(whole, np.linalg.norm(area_vectors(triangles, before), axis=1), rtol=1e-11)
    for middle in (0.5, 0.2):  # as found, and turned
        if middle != 0.5:
            patches.turn(old, new, middle)
        mean = (1.0 - middle) * area_vectors(triangles, before) + middle * area_vectors(triangles, after)
        for d in range(3):
            found = np.bincount(patches.triangle, rows[:, SIDE + d] * rows[:, AREA])
            np.testing.assert_allclose(found, mean[:, d], atol=1e-12)
