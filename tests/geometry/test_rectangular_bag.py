"""Square and rectangular bags: closed chambers, true openings, vents of their area, seams in the right places."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import flat_area
from billow.case.schema import Case
from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import area_vectors, check_closed


def bag(**settings):
    return build_shape(Case.from_dict({"bag": settings}).bag)


def part_area(shape, part, positions=None):
    triangles = shape.surface.triangles[shape.surface.triangles_of(part)].astype(np.int64)
    return np.linalg.norm(area_vectors(triangles, shape.positions if positions is None else positions), axis=1).sum()


@pytest.mark.parametrize("size", [0.01, 0.017, 0.03])
def test_a_square_bag_keeps_its_panels_mouth_and_vents(size):
    vents = {"count": 2, "diameter": 0.04, "distance": 0.17, "panel": "rear"}
    shape = bag(shape="square", side=0.5, element_size=size, mouth_radius=0.05, vents=vents)
    check_closed(shape.surface, shape.positions, "bag")
    assert flat_area(shape.reference).sum() == pytest.approx(2.0 * 0.5**2, rel=1e-12)
    # Volume under a roof of height g (1 - (1 - d/a)^2), d the distance to the edge, a half the side: layer by layer
    # the area is (2 (a - d))^2, so V = int_0^a 8 (a - d) h(d) dd = 8 g a^2 (1/2 - 1/4); chords cut the ridge off.
    exact = 8.0 * 0.002 * 0.25**2 * 0.25
    assert shape.surface.volume(shape.positions) == pytest.approx(exact, rel=2.0 * size / 0.5)
    for vent in ("vent_1", "vent_2"):
        assert part_area(shape, vent) == pytest.approx(np.pi * 0.02**2, rel=1e-12)
    on_ring = np.hypot(*shape.positions[shape.fixed, :2].T)
    assert on_ring.max() == pytest.approx(0.05, rel=1e-12)
    assert not shape.positions[shape.fixed, 2].any()
    # A polygon of n corners has sin(2 pi / n) / (2 pi / n) of the circle's area.
    n = round(2.0 * np.pi * 0.05 / size)
    assert part_area(shape, "mouth") == pytest.approx(0.5 * n * 0.05**2 * np.sin(2.0 * np.pi / n), rel=1e-9)


def test_a_vent_in_the_front_panel():
    shape = bag(shape="square", element_size=0.02, vents={"count": 1, "panel": "front", "distance": 0.1})
    nodes = np.unique(shape.surface.triangles[shape.surface.triangles_of("vent_1")])
    front = np.unique(shape.surface.triangles[shape.surface.triangles_of("front")])
    assert np.isin(nodes, front).all()
    assert shape.positions[nodes, 0].mean() == pytest.approx(0.1, abs=1e-9)


def test_the_mesh_is_symmetric_away_from_holes():
    """Alternating diagonals: turned by a half turn the front panel is itself."""
    shape = bag(shape="square", side=0.4, element_size=0.02)
    front = shape.surface.triangles[shape.surface.triangles_of("front")].astype(np.int64)
    centres = shape.positions[front].mean(axis=1)[:, :2]
    key = {tuple(np.round(c, 9)) for c in centres}
    assert {tuple(np.round(-c, 9) + 0.0) for c in centres} == {tuple(np.array(k) + 0.0) for k in key}


@pytest.mark.parametrize("place", [0.0, 0.5, 1.0])
def test_two_chambers_and_the_opening_between_them(place):
    gap = 0.1
    shape = bag(
        shape="rectangular", length=0.6, width=0.3, chambers=2, element_size=0.02, initial_gap=0.004,
        openings={"width": gap, "place": place},
    )  # fmt: skip
    surface = shape.surface
    check_closed(surface, shape.positions, "bag")
    assert surface.chambers.names == ("chamber_1", "chamber_2")
    volumes = surface.chambers.volumes(surface.triangles, shape.positions)
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-12)
    assert surface.volume(shape.positions) == pytest.approx(volumes.sum(), rel=1e-15)
    opening = surface.triangles_of_kind("opening")
    assert (surface.chambers.behind[opening] == 0).all()
    assert (surface.chambers.ahead[opening] == 1).all()
    areas = area_vectors(surface.triangles[opening].astype(np.int64), shape.positions)
    assert np.allclose(areas[:, 1:], 0.0, atol=1e-12)
    assert (areas[:, 0] > 0.0).all()
    # The opening lies on the wall, is as long as the gap, and grows with the front panel's height.
    nodes = np.unique(surface.triangles[opening])
    assert not shape.positions[nodes, 0].any()
    assert np.ptp(shape.positions[nodes, 1]) == pytest.approx(gap, rel=1e-9)
    risen = shape.positions * [1.0, 1.0, 3.0]
    assert part_area(shape, "opening_1", risen) == pytest.approx(3.0 * part_area(shape, "opening_1"), rel=1e-9)
    outer = surface.chambers.ahead[surface.triangles_of_kind("fabric")]
    assert (outer == OUTSIDE).all()


def test_a_window_bag_of_five_tubes():
    shape = bag(
        shape="rectangular", length=1.4, width=0.4, chambers=5, mouth_chamber=3, element_size=0.02,
        vents={"chambers": [1, 5], "diameter": 0.03, "panel": "front"}, openings={"width": 0.08, "place": 0.9},
    )  # fmt: skip
    check_closed(shape.surface, shape.positions, "bag")
    assert shape.mouth_centre == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert [n for n in shape.surface.part_names if n.startswith("opening")] == [f"opening_{k}" for k in range(1, 5)]
    chamber = {
        name: shape.surface.chambers.behind[shape.surface.triangles_of(name)] for name in shape.surface.part_names
    }
    assert set(chamber["vent_1"]) == {0}
    assert set(chamber["vent_2"]) == {4}
    assert set(chamber["mouth"]) == {2}
    assert part_area(shape, "vent_2") == pytest.approx(np.pi * 0.015**2, rel=1e-3)  # it lies on the dome's slope


def test_seams_weigh_what_they_weigh():
    """Two layers within 8 mm of the rim and of the inner seam, whatever the element size: 1 % from corners and tips."""
    for size in (0.01, 0.02, 0.03):
        shape = bag(shape="square", side=0.5, element_size=size, seam={"width": 0.008, "layers": 2})
        extra = flat_area(shape.reference) @ (shape.layers - 1.0)
        assert extra == pytest.approx(2.0 * (0.5**2 - 0.484**2), rel=0.01)
        shape = bag(
            shape="rectangular", length=0.6, width=0.3, chambers=2, element_size=size, mouth_radius=0.03,
            openings={"width": 0.1, "place": 0.5}, seam={"width": 0.008, "layers": 3},
        )  # fmt: skip
        rim = 0.6 * 0.3 - 0.584 * 0.284
        inner = 2.0 * (0.016 * (0.1 - 0.008) + 0.5 * np.pi * 0.008**2)
        assert flat_area(shape.reference) @ (shape.layers - 1.0) == pytest.approx(2.0 * 2.0 * (rim + inner), rel=0.01)


def test_warp_angles_turn_the_flat_cut_of_one_panel():
    plain, turned = (bag(shape="square", element_size=0.03, warp_angle={"front": a}) for a in (0.0, 30.0))
    front, rear = (plain.surface.triangles_of(name) for name in ("front", "rear"))
    np.testing.assert_array_equal(plain.reference[rear], turned.reference[rear])
    warp = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    np.testing.assert_allclose(turned.reference[front][..., 0], plain.reference[front] @ warp, atol=1e-15)


def test_coated_panels_do_not_leak():
    shape = bag(shape="square", element_size=0.03, coated=["front"])
    assert not shape.leak[shape.surface.triangles_of("front")].any()
    assert (shape.leak[shape.surface.triangles_of("rear")] == 1.0).all()


@pytest.mark.parametrize(
    ("settings", "code", "where", "words"),
    [
        ({"shape": "square", "mouth_radius": 0.29}, "E-GEO-010", "bag.mouth_radius", "mouth"),
        (
            {"shape": "square", "vents": {"count": 1, "diameter": 0.2, "distance": 0.16}},
            "E-GEO-010",
            "bag.vents",
            "overlaps the mouth",
        ),
        ({"shape": "square", "vents": {"count": 1, "distance": 0.29}}, "E-GEO-010", "bag.vents", "does not fit"),
        ({"shape": "square", "vents": {"count": 1, "distance": 5.0}}, "E-GEO-010", "bag.vents", "does not fit"),
        ({"shape": "square", "vents": {"count": 9, "distance": 0.01}}, "E-GEO-010", "bag.vents", "overlap"),
        ({"shape": "rectangular", "chambers": 30}, "E-GEO-010", "bag.mouth_radius", "chamber"),
        ({"shape": "rectangular", "chambers": 3, "mouth_chamber": 4}, "E-GEO-012", "bag.mouth_chamber", "chamber 4"),
        ({"shape": "rectangular", "vents": {"chambers": [0]}}, "E-GEO-012", "bag.vents.chambers", "chamber 0"),
        ({"shape": "square", "element_size": 6e-4}, "E-GEO-011", "bag.side", "triangles"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(settings, code, where, words):
    with pytest.raises(InputError, match=code) as caught:
        bag(**settings)
    assert where in caught.value.where
    assert words in caught.value.what


@settings(max_examples=40, deadline=None)
@given(
    size=st.floats(0.025, 0.06),
    length=st.floats(0.3, 1.5),
    width=st.floats(0.2, 0.8),
    chambers=st.integers(1, 6),
    mouth=st.tuples(st.integers(1, 6), st.floats(0.01, 0.08)),
    gap=st.tuples(st.floats(0.005, 1.0), st.floats(0.0, 1.0)),
    vent=st.tuples(st.integers(1, 6), st.floats(0.01, 0.08), st.floats(-0.1, 0.1), st.sampled_from(["front", "rear"])),
)
def test_a_bag_is_whole_or_refused(size, length, width, chambers, mouth, gap, vent):
    """Any sizes: every chamber closed and with volume, vents of their area, or the message that something does not
    fit."""
    try:
        shape = bag(
            shape="rectangular", element_size=size, length=length, width=width, chambers=chambers,
            mouth_chamber=mouth[0], mouth_radius=mouth[1], openings={"width": gap[0], "place": gap[1]},
            vents={"chambers": [vent[0]], "diameter": vent[1], "offset": [vent[2], 0.0], "panel": vent[3]},
        )  # fmt: skip
    except InputError as error:
        refused = error
    else:
        require_whole(shape, length, width, chambers, vent[1])
        return
    assert refused.code in ("E-GEO-010", "E-GEO-012")


def require_whole(shape, length, width, chambers, vent):
    check_closed(shape.surface, shape.positions, "bag")
    assert (shape.surface.chambers.volumes(shape.surface.triangles, shape.positions) > 0.0).all()
    assert flat_area(shape.reference).sum() == pytest.approx(2.0 * length * width, rel=1e-9)
    assert (flat_area(shape.reference)[shape.surface.triangles_of_kind("fabric")] > 0.0).all()
    vents = flat_area(shape.reference)[shape.surface.triangles_of("vent_1")]
    assert vents.sum() == pytest.approx(0.25 * np.pi * vent**2, rel=1e-9)
    openings = shape.surface.triangles_of_kind("opening")
    assert chambers == 1 or len(openings) >= 2 * (chambers - 1)
