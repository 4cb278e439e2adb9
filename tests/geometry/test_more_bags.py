"""Window bags, tubes, passenger bags: chambers, seams, mouth and volume; straps end where they were asked to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import area_vectors, check_closed
from billow.run.check import describe
from billow.solver.run import Schedule, run

WINDOW = {"shape": "window", "length": 0.8, "width": 0.3, "tubes": 6, "gallery": 0.1, "element_size": 0.0125}
TUBE = {"shape": "tube", "length": 0.5, "width": 0.1, "mouth_radius": 0.02, "element_size": 0.0125}


def shape_of(**bag):
    return build_shape(Case.from_dict({"bag": bag}).bag)


def paper_bag(width, height):
    """Volume [m^3] of two inextensible rectangles sewn at their edges (Robin, Mathematics Today 40 (2004) 104)."""
    return width**3 * (height / (np.pi * width) - 0.142 * (1.0 - 10.0 ** (-height / width)))


PASSENGER = {"shape": "passenger", "element_size": 0.03}


@pytest.mark.parametrize("bag", [WINDOW, TUBE, PASSENGER])
def test_every_bag_is_closed_well_meshed_and_blows_into_its_mouth(bag):
    shape = shape_of(**bag)
    check_closed(shape.surface, shape.positions, "bag")
    mouth = shape.surface.triangles_of("mouth")
    normals = area_vectors(shape.surface.triangles[mouth], shape.positions)
    assert (normals[:, 2] < 0.0).all()  # out of the bag is down
    assert shape.fixed[shape.surface.triangles[mouth]].all()
    cut = shape.reference[shape.surface.triangles_of_kind("fabric")]
    edges = np.linalg.norm(cut - np.roll(cut, 1, axis=1), axis=2)
    altitude = 2.0 * flat_area(cut) / edges.max(axis=1)
    assert altitude.min() > 0.25 * bag["element_size"]


def test_window_bag_has_its_seams_below_the_gallery_only_and_openings_in_it():
    shape = shape_of(**WINDOW)
    chambers = shape.surface.chambers
    assert chambers.names == tuple(f"chamber_{k + 1}" for k in range(6))
    front = set(shape.surface.triangles[shape.surface.triangles_of("front")].ravel().tolist())
    rear = set(shape.surface.triangles[shape.surface.triangles_of("rear")].ravel().tolist())
    shared = shape.positions[sorted(front & rear)]
    inner = shared[(np.abs(shared[:, 0]) < 0.399) & (np.abs(shared[:, 1]) < 0.1499)]
    walls = np.linspace(-0.4, 0.4, 7)[1:-1]
    assert np.abs(inner[:, :1] - walls).min(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert inner[:, 1].max() == pytest.approx(0.05, abs=1e-9)  # the gallery's lower edge
    opening = shape.positions[np.unique(shape.surface.triangles[shape.surface.triangles_of("opening_1")])]
    assert opening[:, 1].min() == pytest.approx(0.05, abs=1e-9)
    assert shape.mouth_centre[1] == pytest.approx(0.1)


def filled(bag, grams, end=0.03, damping=0.0):
    """Model and state at the end [s]; damping [1/s] brings a bag to rest."""
    case = Case.from_dict(
        {
            "bag": bag,
            "inflator": {"mass_flow": {"time": [0.0, 0.002, 0.015], "value": [0.0, grams / 7.5, 0.0]}},
            "obstacles": [],
            "fabric": {"permeability": 0.0, "self_contact": False},
        }
    )
    model = replace(build_model(case), mass_damping=damping)
    state = run(model, Schedule(end, 1, 20))
    return model, state


def test_a_tube_fills_to_the_volume_of_the_closed_form():
    bag = TUBE | {"vents": {"count": 0}}
    model, state = filled(bag, 3.0)
    volume, expected = model.surface.volume(state.positions), paper_bag(0.1, 0.5)
    stretch = 1.0 + (state.gas.vitals.pressure - 101325.0) * 0.1 / np.pi / 0.3e-3 / 0.4e9
    assert volume == pytest.approx(expected * stretch**2, rel=0.04)


def test_tubes_of_a_window_bag_become_cylinders_side_by_side():
    """Of each tube the flat width w becomes a circle of girth 2 w, with its seams on a diameter: at rest, and far from
    the ends, whose seams stay flat (tubes of 0.4 m are wider by 4 %)."""
    bag = WINDOW | {"element_size": 0.0167, "tubes": 4, "gallery": 0.12, "width": 0.8}
    model, state = filled(bag, 35.0, damping=300.0)
    flat, cut = model.start[:, :2], 0.2
    row = flat[np.abs(flat[:, 1] + 0.06).argmin(), 1]  # half way along the tubes
    seams = [np.flatnonzero((np.abs(flat - [x, row]) < 1e-9).all(axis=1)) for x in (-0.4, -0.2, 0.0, 0.2, 0.4)]
    assert [len(nodes) for nodes in seams] == [1] * 5
    apart = np.linalg.norm(np.diff(state.positions[np.concatenate(seams)], axis=0), axis=1)
    gauge = state.gas.vitals.pressure - 101325.0
    stretch = 1.0 + gauge * cut / np.pi / 0.3e-3 / 0.4e9
    assert gauge > 20e3
    assert apart == pytest.approx(2.0 * cut / np.pi * stretch, rel=0.015)


def test_a_window_bag_rolls_up_to_its_gallery():
    fold = {"kind": "roll", "across": "y", "sides": "low", "turns": 1.5, "core": 0.015, "layer_gap": 0.002}
    shape = shape_of(**WINDOW | {"element_size": 0.015, "width": 0.35, "gallery": 0.12}, folds=[fold])
    assert np.ptp(shape.positions[:, 1]) < 0.3
    check_closed(shape.surface, shape.positions, "bag")


STRAP = {"front": [0.1, 0.05], "rear": [0.08, 0.02], "length": 0.2}


def test_straps_say_how_far_their_ends_are_from_where_they_were_asked_for():
    shape = shape_of(shape="driver", element_size=0.02, tethers=[STRAP])
    line = shape.straps[-1]
    front, rear = shape.positions[line.bars[0]]
    away = max(np.hypot(*(front[:2] - STRAP["front"])), np.hypot(*(rear[:2] - STRAP["rear"])))
    assert line.moved == pytest.approx(away)
    assert 0.0 < line.moved < 0.02
    text = describe(Case.from_dict({"bag": {"element_size": 0.02, "tethers": [STRAP]}}))
    assert f"{1e3 * line.moved:.2g} mm from where they were asked for" in str(text)


@pytest.mark.parametrize(
    "bag",
    [
        {"shape": "driver", "element_size": 0.02, "tethers": [STRAP | {"front": [0.5, 0.0]}]},
        {"shape": "square", "straps": [STRAP | {"rear": [10.0, 8.0]}]},
        WINDOW | {"gallery": 0.3},
        WINDOW | {"mouth_tube": 7},
        WINDOW | {"gallery": 0.05},
    ],
)
def test_what_does_not_fit_is_refused(bag):
    with pytest.raises(InputError):
        shape_of(**bag)
