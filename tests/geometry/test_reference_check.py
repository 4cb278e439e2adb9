"""What is said of a start shape before a run: stretched, compressed, collapsed, mirrored, and where."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.concerns import concerns_of, start_panels
from billow.case.schema import Case
from billow.geometry.bag_shapes import square_bag
from billow.geometry.flat_cut import signed_areas
from billow.geometry.reference_check import panels, require_unmirrored
from billow.run.check import describe

BAG = square_bag(0.4, 8, 1e-9)


def look(positions, flat=BAG.reference):
    elements = np.arange(BAG.surface.triangle_count)
    return {p.name: p for p in panels(BAG.surface, positions, elements, flat)}


def test_a_start_that_is_the_cut():
    for panel in look(BAG.positions).values():
        assert panel.longest == pytest.approx(1.0, abs=1e-9)
        assert panel.shortest == pytest.approx(1.0, abs=1e-9)
        assert panel.stretched == panel.compressed == panel.collapsed == 0.0
        assert panel.flat_area == pytest.approx(0.4**2, rel=1e-12)
    assert not look(BAG.positions)["front"].from_inside
    assert look(BAG.positions)["rear"].from_inside


def test_stretch_and_compression_are_counted_and_placed():
    positions = BAG.positions * [1.1, 0.9, 1.0]
    for panel in look(positions).values():
        assert panel.longest == pytest.approx(1.1, rel=1e-9)
        assert panel.shortest == pytest.approx(0.9, rel=1e-9)
        assert panel.stretched == panel.compressed == 1.0
    pulled = BAG.positions.copy()
    front = np.unique(BAG.surface.triangles[BAG.surface.triangles_of("front")])
    node = front[np.linalg.norm(BAG.positions[front] - [0.05, 0.05, 0.0], axis=1).argmin()]
    pulled[node, 2] += 0.05
    around = (BAG.surface.triangles == node).any(axis=1)
    panel = look(pulled)["front"]
    assert panel.stretched == pytest.approx(around.sum() / 128)
    assert around[panel.longest_at]
    # The shortest edges, of 0.05 m, become hypotenuses over 0.05 m.
    assert panel.longest == pytest.approx(np.sqrt(2.0), rel=1e-6)
    assert look(pulled)["rear"].stretched == 0.0


def test_collapsed_triangles_are_counted_and_placed():
    flat = BAG.positions.copy()
    node = BAG.surface.triangles[20, 0]
    flat[node] = flat[BAG.surface.triangles[20, 1]]
    panel = look(flat)["front"]
    gone = (BAG.surface.triangles == node).any(axis=1) & (BAG.surface.triangles == BAG.surface.triangles[20, 1]).any(
        axis=1
    )
    assert panel.collapsed == pytest.approx(gone[:128].sum() / 128)
    assert gone[panel.collapsed_at]


def test_the_same_is_seen_from_the_model():
    """The flat cut recovered from the membranes, warp turned or not."""
    case = Case.from_dict({"bag": {"shape": "square", "element_size": 0.05, "warp_angle": {"front": 33.0}}})
    shape, found = build_shape(case.bag), start_panels(build_model(case))
    cloth = shape.surface.triangles_of_kind("fabric")
    for one, two in zip(found, panels(shape.surface, shape.positions, cloth, shape.reference[cloth]), strict=True):
        assert dataclasses.asdict(one).keys() == dataclasses.asdict(two).keys()
        assert one.flat_area == pytest.approx(two.flat_area, rel=1e-12)
        assert one.longest == pytest.approx(two.longest, rel=1e-9)
        assert one.from_inside == two.from_inside
    assert "front: 0.36" in describe(case)
    assert "seen from inside" in describe(case)


def test_a_bag_that_is_high_at_the_start_is_warned_of():
    case = Case.from_dict({"bag": {"element_size": 0.05, "initial_gap": 0.12}})
    found = [w for w in concerns_of(case, build_model(case)) if w.code == "W-MESH-002"]
    assert len(found) == 1
    assert "part front" in found[0].what
    assert "at (" in found[0].where


def test_mirrored_panels_are_refused_where_it_matters():
    require_unmirrored(BAG, {})
    require_unmirrored(BAG, {"rear": 0.5 * np.pi})  # warp and weft are mirrored onto themselves
    with pytest.raises(InputError, match="E-GEO-037") as caught:
        require_unmirrored(BAG, {"rear": 0.3})
    assert "rear" in caught.value.where
    require_unmirrored(dataclasses.replace(BAG, seen_from_inside=("rear",)), {"rear": 0.3})
    odd = BAG.reference.copy()
    odd[7] = odd[7] * [-1.0, 1.0]
    with pytest.raises(InputError, match="E-GEO-036") as caught:
        require_unmirrored(dataclasses.replace(BAG, reference=odd), {})
    assert "triangle 7 " in caught.value.where
    assert signed_areas(odd)[7] < 0.0
