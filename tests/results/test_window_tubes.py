"""Numbers of the paper's window bag: area, girth and roundness of its tubes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.case.schema import Case
from billow.cli.main import app
from billow.geometry.shapes.pose import quaternion_about, rotation_matrix
from billow.reproductions.gas_paper.window_tubes import HALF_WAY, tubes_across
from billow.run.simulate import simulate

EXAMPLES = Path(__file__).parents[2] / "examples"


def prism(x: float, radius: float, corners: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles, outwards, of the side of a prism along y."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    ring = np.column_stack([x + radius * np.cos(angle), np.zeros(corners), radius * np.sin(angle)])
    ends = [ring + np.array([0.0, HALF_WAY + y, 0.0]) for y in (-0.1, 0.07)]
    a, b = np.arange(corners), np.roll(np.arange(corners), -1)
    return np.concatenate(ends), np.concatenate(
        [np.column_stack([a, a + corners, b]), np.column_stack([b, a + corners, b + corners])]
    )


def test_a_prism_has_the_area_and_girth_of_its_polygon_wherever_it_lies():
    corners, points, triangles, tubes = 12, [], [], []
    for k, (x, radius) in enumerate([(-3.0, 0.1), (0.05, 0.2), (2.0, 0.05)]):
        one, cells = prism(x, radius, corners)
        triangles.append(cells + sum(map(len, points)))
        points.append(one)
        tubes += [k] * len(cells)
    points, triangles = np.concatenate(points), np.concatenate(triangles)
    turn = rotation_matrix(quaternion_about(np.array([0.6, 0.0, 0.8]), 1.1))
    area, girth = tubes_across(points, points @ turn.T, triangles, np.array(tubes))
    radius = np.array([0.1, 0.2, 0.05])
    assert area == pytest.approx(0.5 * corners * radius**2 * np.sin(2.0 * np.pi / corners))
    assert girth == pytest.approx(2.0 * corners * radius * np.sin(np.pi / corners))
    flat = points * [1.0, 1.0, 0.0]
    assert tubes_across(points, flat, triangles, np.array(tubes))[0] == pytest.approx(0.0, abs=1e-15)


def test_the_command_draws_a_column_for_each_gas(tmp_path):
    """Runs by uniform pressure and on a mesh, of the paper's window bag with half its tubes."""
    case = Case.load(EXAMPLES / "paper" / "window_tubes_up.toml").vary(
        {
            "bag.element_size": 0.018, "bag.length": 0.7, "bag.tubes": 4, "bag.mouth_tube": 2, "run.end_time": 2e-4,
            "run.frames": 1,
        }
    )  # fmt: skip
    told = []
    for name, change in (("up", {}), ("mesh", {"gas.model": "mesh", "gas.cell": 0.04})):
        simulate(case.vary(change), tmp_path / name)
        told += ["--tubes", str(tmp_path / name)]
    done = CliRunner().invoke(app, ["paper", *told, "--out", str(tmp_path / "page")])
    assert done.exit_code == 0, done.output
    numbers = json.loads((tmp_path / "page/tubes.json").read_text())
    assert list(numbers) == ["1: uniform pressure", "2: mesh, 40 mm"]
    assert (tmp_path / "page/tubes_sections.png").stat().st_size > 10_000
