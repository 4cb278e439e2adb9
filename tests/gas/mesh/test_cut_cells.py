"""Volumes, apertures and fragments of surfaces cut by a lattice are exact, however the surface lies."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.scenes import box, sphere
from billow.base.scratch import Scratch
from billow.geometry import lattice_clipping
from billow.geometry.cut_cells import Window, cut_cells, neighbours, unite
from billow.geometry.lattice_clipping import NORMAL, WEIGHT, cell_of, clip, key_of
from billow.geometry.surface import area_vectors


def volume(positions, triangles):
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def cut(shape, places):
    return cut_cells(shape.surface.triangles, np.ones(len(shape.surface.triangles)), places, Window.none())


def surfaces():
    ball, block = sphere(3.3, 2), box(3.0, 2.0, 4.0)
    yield "sphere", ball, ball.positions + 0.37
    yield "flat bag", ball, ball.positions * [1.0, 1.0, 0.01] + 0.37
    yield "box in the planes", block, block.positions
    yield "bag that lies in a plane", ball, np.where([0, 0, 1], np.maximum(ball.positions, 0.0), ball.positions)
    yield "far away", ball, ball.positions + np.array([1234.4, -777.1, 31.0])


@pytest.mark.parametrize(("name", "shape", "places"), list(surfaces()), ids=lambda v: v if isinstance(v, str) else "")
def test_volumes_add_up_and_cells_are_closed(name, shape, places):
    found = cut(shape, places)
    exact = volume(places - places[0], shape.surface.triangles)
    assert found.total == pytest.approx(exact, rel=1e-12)
    rows = found.fragments.rows
    normals = rows[:, NORMAL : NORMAL + 3].sum(axis=0)
    assert np.abs(normals).max() < 1e-11
    weights = np.column_stack([1.0 - rows[:, WEIGHT] - rows[:, WEIGHT + 1], rows[:, WEIGHT : WEIGHT + 2]])
    assert weights.min() > -1e-7
    # Levers lie in order of triangles; all of a triangle's add up to a third of it at each corner.
    here, first = found.fragments.number, found.fragments.first
    shares = found.fragments.levers.sum(axis=1)
    np.testing.assert_allclose(found.fragments.levers, shares[:, None] * weights[here], atol=1e-12)
    thirds = np.add.reduceat(found.fragments.levers, first[:-1][np.diff(first) > 0])
    np.testing.assert_allclose(thirds, 1.0 / 3.0, atol=1e-9)
    # What walls close of a cell is what its faces leave open.
    beside = neighbours(found.key)
    for d in range(3):
        below = np.where(beside[:, 2 * d] >= 0, found.aperture[beside[:, 2 * d], d], 0.0)
        walls = np.bincount(found.cell, rows[:, NORMAL + d], len(found.key))
        np.testing.assert_allclose(found.aperture[:, d] - below + walls, 0.0, atol=1e-9)


def test_a_surface_that_lies_in_itself_keeps_its_signed_volume():
    ball = sphere(3.0, 2)
    places = ball.positions.copy()
    places[:, 2] += 2.5 * np.sin(2.0 * places[:, 0])  # folds over itself
    places[:, 0] *= np.cos(1.5 * places[:, 2])
    found = cut(ball, places)
    assert found.inverted < 0.0
    assert found.total == pytest.approx(volume(places, ball.surface.triangles), rel=1e-11)


def test_centroids_of_cut_cells():
    """A box from 0.3 to 2.6 along each axis."""
    block = box(2.3, 2.3, 2.3)
    found = cut(block, block.positions + 0.3)
    first = found.volume.argmin()  # a corner cell
    corner = found.key == key_of(0, 0, 0)
    np.testing.assert_allclose(found.centroid[corner][0], 0.65, atol=1e-12)
    assert found.volume[first] == pytest.approx(0.6**3, rel=1e-12)


def test_no_triangle_has_more_fragments_than_there_is_room_for():
    """Small and large, and through points where planes of the lattice meet, which rounding parts once more."""
    random = np.random.default_rng(5)
    places = random.normal(size=(3000, 3, 3)) * 10.0 ** random.uniform(-1.0, 1.0, (3000, 1, 1))
    crossing = np.round(places[:, :1]) - places.mean(axis=1, keepdims=True)
    places[::2] += crossing[::2]  # the centroid is a corner of cells
    places[::5, :, 2] = np.round(places[::5, :, 2])
    triangles = np.arange(9000, dtype=np.uint32).reshape(-1, 3)
    loose = clip(triangles, np.ones(3000), places.reshape(-1, 3), Scratch())
    assert (np.diff(loose.first) <= np.diff(loose.slot)).all()
    size = np.diff(loose.first).max()
    assert size > 300
    rows = np.concatenate([loose.rows[s : s + n] for s, n in zip(loose.slot, np.diff(loose.first), strict=False)])
    whole = np.add.reduceat(rows[:, NORMAL : NORMAL + 3], loose.first[:-1])
    np.testing.assert_allclose(whole, area_vectors(triangles, places.reshape(-1, 3)), rtol=0.0, atol=1e-10)


def test_keys_and_neighbours():
    key = np.array(sorted(key_of(i, j, k) for i, j, k in ((0, 0, 0), (0, 0, 1), (0, 1, 0), (-1, 0, 0), (5, 5, 5))))
    assert [cell_of(int(k)) for k in key] == sorted([(0, 0, 0), (0, 0, 1), (0, 1, 0), (-1, 0, 0), (5, 5, 5)])
    beside = neighbours(key)
    assert beside[1].tolist() == [0, -1, -1, 3, -1, 2]
    both, first, second = unite(key[:3], key[2:])
    assert both.tolist() == key.tolist()
    assert first.tolist() == [0, 1, 2, -1, -1]
    assert second.tolist() == [-1, -1, 0, 1, 2]


def test_a_fragment_without_room_is_never_written(monkeypatch):
    def too_few(n, triangles, places, slot_out):
        slot_out[1:] = 1

    monkeypatch.setattr(lattice_clipping, "_most", too_few)
    corners = np.array([[0.2, 0.2, 0.2], [3.7, 0.4, 0.3], [0.3, 3.6, 0.4]])
    with pytest.raises(RuntimeError, match="more fragments"):
        clip(np.array([[0, 1, 2]], np.uint32), np.ones(1), corners, Scratch())
