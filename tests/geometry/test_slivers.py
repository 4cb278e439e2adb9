"""A few triangles that set the step of all are named before a run."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_files import pillow, write_vtk

from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.solver.model import start_state
from billow.solver.step_size import stable_dt

PARTS = [{"name": "front", "number": 1}, {"name": "rear", "number": 2}]


def told(path):
    bag = {"shape": "mesh", "start": str(path), "parts": PARTS}
    case = Case.from_dict({"bag": bag, "gas": {"model": "none"}, "obstacles": []})
    model = build_model(case)
    return model, [concern for concern in concerns_of(case, model) if concern.code == "W-MESH-006"]


@pytest.mark.parametrize("distance", [1e-2, 1e-5])
def test_slivers_that_set_the_step_are_named_with_the_step_without_them(tmp_path, distance):
    points, cells, part, *_ = pillow(n=8)
    inside = next(node for node in cells[20] if np.ptp(points[node]) > 0.0)
    corners = [points[node] for node in cells[20] if node != inside]
    points[inside] = corners[0] + distance * (np.mean(corners, axis=0) - corners[0])
    model, (found,) = told(write_vtk(tmp_path / "m.vtk", points, cells, part))
    now, without = (float(text.split()[0]) for text in found.what.split("the step ")[1].split("instead of "))
    state = start_state(model)
    assert now == pytest.approx(1e6 * stable_dt(model, state), rel=0.01)
    points, cells, part, *_ = pillow(n=8)
    even, _ = told(write_vtk(tmp_path / "even.vtk", points, cells, part))
    assert without == pytest.approx(1e6 * stable_dt(even, start_state(even)), rel=0.2)
    worst = int(found.where.split()[1])
    flat = model.start[model.surface.triangles[worst]]
    assert np.linalg.norm(flat[:, None] - flat, axis=2).max() < 0.1
    assert model.fabric.smallest_element == worst


def test_a_mesh_that_is_only_graded_is_no_matter(tmp_path):
    points, cells, part, *_ = pillow(n=8)
    points[:, 0] = np.sinh(12.0 * points[:, 0]) / 12.0
    assert told(write_vtk(tmp_path / "m.vtk", points, cells, part))[1] == []
