"""A bag moved to other sizes keeps nodes and triangles, and has the sizes it was moved to."""

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.schema import Case
from billow.geometry.flat_cut import flat_area
from billow.geometry.morph import smallest_angle


def bag(**sizes):
    table = {"element_size": 0.03, "diameter": 0.675, "vents": {"diameter": 0.035}}
    meshed = {
        "diameter": 0.675,
        "vent_diameter": 0.035,
        "mouth_radius": 0.05,
        "vent_radius": 0.17,
        "stitch_radius": 0.08,
    }
    return build_shape(Case.from_dict({"bag": table | {"mesh_of": meshed}}).vary(sizes).bag)


def area(shape, kind):
    return flat_area(shape.reference)[shape.surface.triangles_of_kind(kind)].sum()


BASE = bag()


def test_sizes_are_those_asked_for():
    shape = bag(**{"bag.diameter": 0.72, "bag.vents.diameter": 0.05, "bag.vents.distance": 0.2,
                   "bag.mouth_radius": 0.06, "bag.straps.stitch_radius": 0.1})  # fmt: skip
    assert np.array_equal(shape.surface.triangles, BASE.surface.triangles)
    assert np.array_equal(shape.straps[0].bars, BASE.straps[0].bars)
    radius = np.hypot(*shape.positions[:, :2].T)
    assert radius.max() == pytest.approx(0.36, abs=1e-9)
    assert area(shape, "vent") == pytest.approx(2 * np.pi / 4 * 0.05**2, rel=1e-8)
    assert area(shape, "mouth") == pytest.approx((0.06 / 0.05) ** 2 * area(BASE, "mouth"), rel=1e-8)
    vent = np.unique(shape.surface.triangles[shape.surface.triangles_of("vent_1")])
    assert np.linalg.norm(shape.positions[vent, :2].mean(axis=0)) == pytest.approx(0.2, abs=1e-9)
    assert radius[shape.straps[0].bars[:, 0]] == pytest.approx(0.1, abs=1e-9)
    assert shape.positions[:, 2].max() == pytest.approx(0.002, rel=1e-6)


def test_a_plain_change_of_scale_keeps_every_angle():
    scale = 0.75 / 0.675
    shape = bag(**{"bag.diameter": 0.75, "bag.mouth_radius": 0.05 * scale, "bag.vents.diameter": 0.035 * scale,
                   "bag.vents.distance": 0.17 * scale, "bag.straps.stitch_radius": 0.08 * scale})  # fmt: skip
    assert shape.positions[:, :2] == pytest.approx(scale * BASE.positions[:, :2], abs=1e-9)
    assert smallest_angle(shape.reference) == pytest.approx(smallest_angle(BASE.reference), abs=1e-6)


def test_the_sizes_it_was_meshed_for_change_nothing():
    plain = build_shape(Case.from_dict({"bag": {"element_size": 0.03, "diameter": 0.675}}).bag)
    assert np.array_equal(plain.positions, BASE.positions)
    assert np.array_equal(plain.reference, BASE.reference)


def test_triangles_stay_shapely_over_the_range_of_a_study():
    for diameter in (0.60, 0.75):
        for vent in (0.02, 0.05):
            assert smallest_angle(bag(**{"bag.diameter": diameter, "bag.vents.diameter": vent}).reference).min() > 15.0


def test_what_would_spoil_the_mesh_is_refused():
    with pytest.raises(InputError) as caught:
        bag(**{"bag.vents.diameter": 0.005})
    assert (caught.value.code, "angle" in caught.value.why) == ("E-GEO-070", True)
    with pytest.raises(InputError) as caught:
        bag(**{"bag.diameter": 0.40, "bag.vents.diameter": 0.1})
    assert caught.value.code == "E-GEO-070"
