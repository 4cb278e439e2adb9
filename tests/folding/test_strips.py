"""Strips of folded bags: closed, all of the bag, and parted where the folds are."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case
from billow.geometry.folding.fold_plan import panel_side
from billow.geometry.folding.parting import parted
from billow.geometry.folding.strips import find_strips, find_tiles
from billow.geometry.surface import area_vectors
from billow.results.vtkhdf import FabricWriter

TUBE = {
    "shape": "rectangular", "length": 1.0, "width": 0.16, "mouth_radius": 0.02, "mouth_offset": [-0.42, 0.0],
    "element_size": 0.025, "folds": [{"kind": "half"}, {"kind": "half"}],
}  # fmt: skip
LINES = [0.12, 0.205]
DRIVER = {
    "diameter": 0.7, "element_size": 0.03, "vents": {"count": 0}, "straps": {"count": 0},
    "folds": [{"kind": "leporello", "across": axis, "lines": LINES} for axis in "xy"],
}  # fmt: skip
ROLLED = DRIVER | {
    "element_size": 0.012,
    "folds": [{"kind": "roll", "across": "x", "sides": "high", "to": 0.15, "core": 0.05}],
}


TUCKED = DRIVER | {
    "folds": [{"kind": "tuck", "across": "y", "depth": 0.1}, {"kind": "leporello", "across": "x", "lines": LINES}],
}

TILE, CELL = 0.05, 0.03


def strips_of(bag):
    case = Case.from_dict({"bag": bag})
    shape = build_shape(case.bag)
    return shape, find_strips(fold_plan(case.bag), shape, TILE)


@pytest.fixture(
    params=[(TUBE, 4), (DRIVER, 25), (ROLLED, 5), (TUCKED, 5)],
    ids=["tube", "driver", "rolled", "tucked"],
    scope="module",
)
def folded(request):
    bag, count = request.param
    return *strips_of(bag), count


def test_there_is_a_strip_between_neighbouring_lines(folded):
    shape, strips, count = folded
    assert strips.count == count
    assert strips.missing == ()
    assert set(strips.chambers.behind[: shape.surface.triangle_count]) == set(range(count))
    lengths = np.bincount(strips.chambers.behind[: len(strips.area)], strips.area)
    assert lengths.sum() == pytest.approx(strips.area.sum())
    assert (strips.chambers.volumes(strips.triangles, shape.positions) > 0.0).all()
    if count == 4:  # of equal length
        assert lengths == pytest.approx(strips.area.sum() / 4, rel=0.02)


def test_strips_are_closed_and_fill_the_bag(folded):
    shape, strips, _ = folded
    for positions in (shape.positions, shape.positions * [1.0, 1.0, 30.0]):
        volumes = strips.chambers.volumes(strips.triangles, positions)
        assert (volumes > 0.0).all()
        assert volumes.sum() == pytest.approx(shape.surface.volume(positions), rel=1e-12)
        for strip in range(strips.count):
            boundary = strips.chambers.boundary(strip, strips.triangles)
            vectors = area_vectors(boundary, positions)
            assert np.abs(vectors.sum(axis=0)).max() < 1e-12 * np.abs(vectors).sum()


def test_walls_have_the_bag_s_nodes_and_lie_between_two_strips(folded):
    shape, strips, _ = folded
    walls = slice(shape.surface.triangle_count, None)
    assert len(strips.triangles[walls]) > 0
    assert strips.triangles.max() < shape.surface.node_count
    assert (strips.chambers.behind[walls] < strips.chambers.ahead[walls]).all()


def test_a_line_through_a_hole_parts_nothing():
    vents = {"count": 1, "diameter": 0.04, "distance": 0.175}
    fold = {"kind": "leporello", "first_line": 0.12, "panel": 0.06}
    _, strips = strips_of({"shape": "square", "element_size": 0.02, "folds": [fold], "vents": vents})
    assert strips.count == 6  # not 7
    assert strips.missing == ("the line at 0.18 m across x, which elements lie across",)


def test_strips_with_gaps_are_none(monkeypatch):
    monkeypatch.setattr("billow.geometry.folding.parting._is_closed", lambda *_: False)
    shape, strips = strips_of(TUBE)
    assert strips.count == 1
    assert len(strips.triangles) == shape.surface.triangle_count
    assert len(strips.missing) == 1


def test_a_roll_is_parted_along_it():
    """Into strips of about a tile, none over the bag that lies flat before it; gas goes from one to the next alone."""
    shape, strips = strips_of(ROLLED)
    flat = fold_plan(Case.from_dict({"bag": ROLLED}).bag).unfolded(shape.positions)[:, 0]
    own, middle = len(strips.area), flat[shape.surface.triangles].mean(axis=1)
    for strip in range(strips.count):
        some = middle[strips.chambers.behind[:own] == strip]
        assert np.ptp(some) < 1.3 * TILE if strip else some.max() < 0.16
    neighbours = set(zip(strips.chambers.behind[own:].tolist(), strips.chambers.ahead[own:].tolist(), strict=True))
    assert neighbours == {(k, k + 1) for k in range(strips.count - 1)}


def folded_elsewhere(**bag):
    """A folded bag as its start and its reference alone tell of it."""
    return build_shape(Case.from_dict({"bag": bag}).bag)


@pytest.mark.parametrize("bag", [TUBE, DRIVER, ROLLED], ids=["tube", "driver", "rolled"])
def test_tiles_of_a_bag_folded_elsewhere_are_closed_and_fill_it(bag):
    shape = folded_elsewhere(**bag)
    strips = find_tiles(shape, 0.12)
    assert strips.missing == ()
    assert strips.count >= 6
    volumes = strips.chambers.volumes(strips.triangles, shape.positions)
    assert volumes.sum() == pytest.approx(shape.surface.volume(shape.positions), rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(x=st.lists(st.floats(-0.3, 0.3), max_size=4), y=st.lists(st.floats(-0.3, 0.3), max_size=4))
def test_lines_anywhere_part_a_bag_into_closed_rooms(x, y):
    """Also where elements lie across them: rooms fill the bag, or there are none."""
    shape = folded_elsewhere(**DRIVER)
    flat = np.zeros((len(shape.positions), 2))
    flat[shape.surface.triangles.ravel()] = shape.reference.reshape(-1, 2)
    found = parted(shape.surface.triangles.astype(np.int64), shape.surface.chambers, flat, (sorted(x), sorted(y)))
    gaps = [b - a for lines in (x, y) for a, b in itertools.pairwise(sorted(lines))]
    if found is None:
        assert min(gaps) < 0.06  # of two elements
    else:
        triangles, rooms = found
        assert rooms.volumes(triangles, shape.positions).sum() == pytest.approx(
            shape.surface.volume(shape.positions), rel=1e-12
        )


def test_panels_that_were_cut_apart_have_no_tiles():
    shape = folded_elsewhere(**TUBE)
    half = np.arange(len(shape.reference)) < len(shape.reference) // 2
    apart = shape.reference + np.where(half, 2.0, 0.0)[:, None, None]
    assert find_tiles(dataclasses.replace(shape, reference=apart), 0.12) is None


@pytest.mark.parametrize("comes_folded", [True, False])
def test_a_bag_that_comes_folded_as_a_mesh_has_tiles_and_a_flat_one_has_none(comes_folded, tmp_path):
    shape = folded_elsewhere(**TUBE)
    surface, flat = shape.surface, np.zeros_like(shape.positions)
    flat[surface.triangles.ravel(), :2] = shape.reference.reshape(-1, 2)
    pressed = np.column_stack([flat[:, :2], 4e-4 * panel_side(shape, flat)])
    for name, places in (("start", shape.positions if comes_folded else pressed), ("flat", flat)):
        with FabricWriter(
            tmp_path / f"{name}.vtkhdf", places, surface.triangles, surface.part, surface.part_names
        ) as file:
            file.append(0.0, places)
    parts = [
        {"name": name, "kind": kind, "seen_from": "outside" if name == "front" else "inside"}
        for name, kind in zip(surface.part_names, surface.part_kinds, strict=True)
    ]
    bag = {"shape": "mesh", "start": f"{tmp_path}/start.vtkhdf", "reference": f"{tmp_path}/flat.vtkhdf", "parts": parts}
    case = Case.from_dict({"bag": bag, "gas": {"model": "mesh", "cell": CELL}, "obstacles": []})
    strips = build_gas(case, build_shape(case.bag)).model.strips
    assert (strips is not None and strips.count > 6) == comes_folded
