"""Areas read off frames, of shapes whose areas are known."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from billow.design.measures import measure, section_area
from billow.study.responses import StudyResponse


def sphere(rings: int, sectors: int):
    """Points and triangles of a closed unit sphere, counted round from outside."""
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    azimuth = np.linspace(0.0, 2.0 * np.pi, sectors, endpoint=False)
    body = [[np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)] for p in polar for a in azimuth]
    points = np.array([[0.0, 0.0, 1.0], *body, [0.0, 0.0, -1.0]])
    node = lambda ring, sector: 1 + ring * sectors + sector % sectors  # noqa: E731
    triangles = [[0, node(0, k), node(0, k + 1)] for k in range(sectors)]
    for ring in range(rings - 2):
        for k in range(sectors):
            a, b, c, d = node(ring, k), node(ring + 1, k), node(ring + 1, k + 1), node(ring, k + 1)
            triangles += [[a, b, c], [a, c, d]]
    triangles += [[len(points) - 1, node(rings - 2, k + 1), node(rings - 2, k)] for k in range(sectors)]
    return points, np.array(triangles)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 2.0), (1.0, 0.0, 0.0), (0.3, -0.8, 0.5)])
@pytest.mark.parametrize("height", [0.0, 0.3, -0.6])
def test_the_section_of_a_sphere_is_a_disc(normal, height):
    points, triangles = sphere(120, 120)
    direction = np.array(normal) / np.linalg.norm(normal)
    centre = np.array([5.0, -2.0, 1.0])  # areas do not depend on the origin
    found = section_area(points + centre, triangles, centre + (height + 1e-6) * direction, np.array(normal))
    assert found == pytest.approx(np.pi * (1.0 - height**2), rel=2e-3)


def test_two_separate_lines_of_a_cut_add_up():
    points, triangles = sphere(60, 60)
    both = np.concatenate([points, points + np.array([4.0, 0.0, 0.0])])
    twice = np.concatenate([triangles, triangles + len(points)])
    one = section_area(points, triangles, np.array([0.0, 0.0, 0.1]), np.array([0.0, 0.0, 1.0]))
    assert section_area(both, twice, np.array([0.0, 0.0, 0.1]), np.array([0.0, 0.0, 1.0])) == pytest.approx(2.0 * one)


def run_of_a_square():
    """Two frames of a square of 1 m^2 that grows to 4 m^2; obstacles press on one corner, then on an edge."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    force = np.zeros((2, 4, 3))
    force[0, 1, 2] = force[1, 1:3, 2] = 5.0
    fabric = SimpleNamespace(part_names=["front", "rear"], part=np.array([0, 1]))
    return SimpleNamespace(times=np.array([0.01, 0.02]), reference=points.astype(np.float32), contact_force=force,
                           displacement=np.stack([0.0 * points, points]), triangles=np.array([[0, 1, 2], [0, 2, 3]]),
                           folder=Path(), fabric=fabric)  # fmt: skip


@pytest.mark.parametrize(
    ("table", "area"),
    [
        ({}, 2.0),  # of triangles of 2 m^2 two thirds and one third
        ({"time": 0.01}, 0.5 / 3.0),
        ({"of": "rear"}, 2.0 / 3.0),
        ({"unit": "cm^2"}, 2e4),
    ],
)
def test_the_area_in_contact_is_that_of_pressed_nodes(table, area):
    response = StudyResponse.model_validate({"name": "x", "measure": "contact_area"} | table)
    assert measure(run_of_a_square(), response, Path()) == pytest.approx(area)


def test_a_section_needs_a_plane():
    response = StudyResponse.model_validate({"name": "x", "measure": "section_area", "point": [0.0, 0.0, 0.0]})
    assert [what for what, _, _ in response.contradictions()] == ["measure = 'section_area' without normal"]
