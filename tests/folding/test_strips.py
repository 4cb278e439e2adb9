"""Strips of folded bags: closed, all of the bag, and parted where the folds are."""

from __future__ import annotations

import numpy as np
import pytest

from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.schema import Case
from billow.geometry.folding.strips import find_strips
from billow.geometry.surface import area_vectors

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


def strips_of(bag):
    case = Case.from_dict({"bag": bag})
    shape = build_shape(case.bag)
    return shape, find_strips(fold_plan(case.bag), shape)


@pytest.fixture(params=[(TUBE, 4), (DRIVER, 25)], ids=["tube", "driver"], scope="module")
def parted(request):
    bag, count = request.param
    return *strips_of(bag), count


def test_there_is_a_strip_between_neighbouring_lines(parted):
    shape, strips, count = parted
    assert strips.count == count
    assert strips.missing == ()
    assert set(strips.chambers.behind[: shape.surface.triangle_count]) == set(range(count))
    lengths = np.bincount(strips.chambers.behind[: len(strips.area)], strips.area)
    assert lengths.sum() == pytest.approx(strips.area.sum())
    if count == 4:  # of equal length
        assert lengths == pytest.approx(strips.area.sum() / 4, rel=0.02)


def test_strips_are_closed_and_fill_the_bag(parted):
    shape, strips, _ = parted
    for positions in (shape.positions, shape.positions * [1.0, 1.0, 30.0]):
        volumes = strips.chambers.volumes(strips.triangles, positions)
        assert (volumes > 0.0).all()
        assert volumes.sum() == pytest.approx(shape.surface.volume(positions), rel=1e-12)
        for strip in range(strips.count):
            boundary = strips.chambers.boundary(strip, strips.triangles)
            vectors = area_vectors(boundary, positions)
            assert np.abs(vectors.sum(axis=0)).max() < 1e-12 * np.abs(vectors).sum()


def test_walls_have_the_bag_s_nodes_and_lie_between_two_strips(parted):
    shape, strips, _ = parted
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
    monkeypatch.setattr("billow.geometry.folding.strips._is_closed", lambda *_: False)
    shape, strips = strips_of(TUBE)
    assert strips.count == 1
    assert len(strips.triangles) == shape.surface.triangle_count
    assert len(strips.missing) == 1


def test_a_roll_has_no_strips():
    _, strips = strips_of(ROLLED)
    assert strips.count == 1
    assert strips.missing == ("the roll across x",)
