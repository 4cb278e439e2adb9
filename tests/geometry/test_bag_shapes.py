"""Generated bags: closed, outward, of the right volume and areas, well-shaped triangles, the same every time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import flat_area
from billow.case.schema import Case
from billow.geometry.bag_shapes import round_bag, square_bag
from billow.geometry.surface import area_vectors, check_closed


def driver(**settings):
    return build_shape(Case.from_dict({"bag": settings}).bag)


def altitudes(shape):
    """Smallest flat altitude of each fabric triangle [m]."""
    cloth = shape.surface.triangles_of_kind("fabric")
    flat = shape.reference[cloth]
    edges = [np.linalg.norm(flat[:, i] - flat[:, j], axis=1) for i, j in ((0, 1), (1, 2), (2, 0))]
    return 2.0 * flat_area(flat) / np.max(edges, axis=0)


def vent_areas(shape):
    """Area of each vent [m^2] in the start shape."""
    names = [name for name in shape.surface.part_names if name.startswith("vent")]
    areas = np.linalg.norm(area_vectors(shape.surface.triangles, shape.positions), axis=1)
    return [areas[shape.surface.triangles_of(name)].sum() for name in names]


@pytest.mark.parametrize("size", [0.008, 0.010, 0.012, 0.015, 0.020, 0.025, 0.030, 0.035, 0.040, 0.045, 0.050])
def test_a_driver_bag_of_any_element_size(size):
    shape = driver(element_size=size)
    check_closed(shape.surface, shape.positions, "bag")
    # A shallow dome of the gap's height over a disc, less what chords cut off its rim.
    volume = 0.5 * np.pi * 0.35**2 * 0.002
    assert shape.surface.volume(shape.positions) == pytest.approx(volume, rel=0.7 * (size / 0.35) ** 2 + 1e-4)
    assert vent_areas(shape) == pytest.approx([np.pi * 0.0175**2] * 2, rel=1e-12)
    # Holes of 35 mm need shorter edges than the coarsest sizes.
    assert altitudes(shape).min() > (0.3 if size < 0.04 else 0.19) * size
    panels = flat_area(shape.reference)
    assert panels.sum() == pytest.approx(2.0 * np.pi * 0.35**2, rel=2.0 * (size / 0.35) ** 2)
    # Reference and start shape agree: nothing starts stretched.
    edges = np.linalg.norm(np.diff(shape.positions[shape.surface.triangles], axis=1), axis=2)
    assert edges == pytest.approx(np.linalg.norm(np.diff(shape.reference, axis=1), axis=2), rel=1e-3)


def test_a_driver_bag_is_held_at_its_mouth_and_strapped():
    shape = driver(element_size=0.02)
    radius = np.hypot(*shape.positions[shape.fixed, :2].T)
    assert radius.max() == pytest.approx(0.05, rel=1e-12)
    assert not shape.positions[shape.fixed, 2].any()
    mouth = shape.surface.triangles_of("mouth")
    assert flat_area(shape.reference)[mouth].sum() == pytest.approx(np.pi * 0.05**2, rel=0.1)
    assert len(shape.straps) == 4
    for k, strap in enumerate(shape.straps):
        front, ring = shape.positions[strap.bars[:, 0]], shape.positions[strap.bars[:, 1]]
        assert shape.fixed[strap.bars[:, 1]].all()
        assert not shape.fixed[strap.bars[:, 0]].any()
        assert np.hypot(front[:, 0], front[:, 1]) == pytest.approx(0.08, rel=1e-12)
        assert np.hypot(ring[:, 0], ring[:, 1]) == pytest.approx(0.05, rel=1e-12)
        assert strap.width * len(strap.bars) == pytest.approx(0.06, rel=1e-12)
        middle = np.arctan2(*front.mean(axis=0)[[1, 0]]) - 0.5 * np.pi * k
        assert np.cos(middle) == pytest.approx(1.0, abs=1e-9)


def test_the_same_mesh_every_time():
    for make in (lambda: driver(element_size=0.02), lambda: round_bag(0.3, 8, 0.01), lambda: square_bag(0.3, 8, 0.01)):
        one, two = make(), make()
        for field in ("positions", "reference", "fixed"):
            assert getattr(one, field).tobytes() == getattr(two, field).tobytes()
        assert one.surface.triangles.tobytes() == two.surface.triangles.tobytes()
        assert one.surface.part.tobytes() == two.surface.part.tobytes()


@pytest.mark.parametrize("rings", [4, 8, 16])
def test_a_round_bag_is_two_paraboloids(rings):
    shape = round_bag(0.3, rings, 0.05)
    check_closed(shape.surface, shape.positions, "bag")
    assert shape.surface.volume(shape.positions) == pytest.approx(0.5 * np.pi * 0.3**2 * 0.05, rel=1.5 / rings**2)
    assert np.ptp(shape.positions[:, 2]) == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize("divisions", [2, 6, 16])
def test_a_square_bag_keeps_its_panels(divisions):
    shape = square_bag(0.4, divisions, 0.05)
    assert flat_area(shape.reference).sum() == pytest.approx(2.0 * 0.4**2, rel=1e-12)
    assert (flat_area(shape.reference) > 0.0).all()
    check_closed(shape.surface, shape.positions, "bag")
    exact = 0.05 * 0.4**2 * (2.0 / 3.0) ** 2
    assert shape.surface.volume(shape.positions) == pytest.approx(exact, rel=3.0 / divisions**2)


@pytest.mark.parametrize(
    ("settings", "where"),
    [
        ({"mouth_radius": 0.2}, "bag.mouth_radius"),
        ({"straps": {"stitch_radius": 0.33}}, "bag.straps.stitch_radius"),
        ({"vents": {"distance": 0.34}}, "bag.vents"),
        ({"vents": {"distance": 0.06}}, "bag.vents"),
        ({"vents": {"diameter": 0.15, "distance": 0.2, "count": 9}}, "bag.vents"),
    ],
)
def test_what_does_not_fit_is_refused(settings, where):
    with pytest.raises(InputError, match="E-GEO-010") as caught:
        driver(element_size=0.03, **settings)
    assert caught.value.where == where
    assert where.split(".")[1] in caught.value.remedy


@settings(max_examples=150)
@given(
    size=st.floats(0.02, 0.1),
    diameter=st.floats(0.2, 1.0),
    mouth=st.floats(0.01, 0.1),
    vents=st.tuples(st.integers(0, 6), st.floats(0.005, 0.1), st.floats(0.05, 0.4)),
    straps=st.tuples(st.integers(0, 6), st.floats(0.02, 0.2)),
)
# Vents whose polygons would cut the rim, the retainer ring, or one another.
@example(size=0.057, diameter=0.616, mouth=0.052, vents=(4, 0.0268, 0.29336), straps=(2, 0.145))
@example(size=0.072, diameter=0.853, mouth=0.0526, vents=(4, 0.0515, 0.0897), straps=(5, 0.026))
@example(size=0.02, diameter=0.6, mouth=0.01, vents=(4, 0.1, 0.0712), straps=(0, 0.1))
def test_a_bag_is_whole_or_refused(size, diameter, mouth, vents, straps):
    """Any sizes: a closed bag whose vents have the area asked for, or the message that something does not fit."""
    try:
        shape = driver(
            element_size=size, diameter=diameter, mouth_radius=mouth,
            vents={"count": vents[0], "diameter": vents[1], "distance": vents[2]},
            straps={"count": straps[0], "stitch_radius": straps[1]},
        )  # fmt: skip
    except InputError as error:
        refused = error
    else:
        check_closed(shape.surface, shape.positions, "bag")
        assert vent_areas(shape) == pytest.approx([0.25 * np.pi * vents[1] ** 2] * vents[0], rel=1e-9)
        assert len(shape.straps) == straps[0]
        assert altitudes(shape).min() > 0.0
        return
    assert refused.code == "E-GEO-010"
