"""A run says where fabric passes through fabric: at its start, at its end, and at every frame if asked."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.geometry.bag_shapes import square_bag
from billow.geometry.crossings import CrossingCount
from billow.results.vtkhdf import FabricWriter
from billow.run.check import describe
from billow.run.simulate import simulate

NAME = "crossings of fabric through fabric"


def bag(path, through):
    """A case without gas of a pillow; through: whether a node of its front starts below its rear."""
    shape = square_bag(0.4, 6, 0.04)
    points, triangles = shape.positions.copy(), shape.surface.triangles.astype(np.int64)
    with FabricWriter(path / "flat.vtkhdf", points, triangles, shape.surface.part, ["front", "rear"]) as file:
        file.append(0.0, points)
    if through:
        points[int(points[:, 2].argmax())] *= [1.0, 1.0, -2.0]
        points[int(points[:, 2].argmin())] += [0.02, 0.013, 0.0]  # not just through an edge
    with FabricWriter(path / "start.vtkhdf", points, triangles, shape.surface.part, ["front", "rear"]) as file:
        file.append(0.0, points)
    return {
        "bag": {
            "shape": "mesh", "start": str(path / "start.vtkhdf"), "reference": str(path / "flat.vtkhdf"),
            "birth_time": 0.01, "parts": [{"name": "front"}, {"name": "rear"}],
        },
        "gas": {"model": "none"}, "obstacles": [],
        "run": {"end_time": 2e-5, "frames": 2, "histories_per_frame": 1},
    }  # fmt: skip


def judged(result):
    return {line["name"]: line for line in result.record["quality"]["criteria"]}


def test_crossings_are_counted_where_they_are(tmp_path):
    case = Case.from_dict(bag(tmp_path, True)).vary({"run.guard_crossings": True})
    result = simulate(case, tmp_path / "run")
    model = build_model(case)
    expected = CrossingCount(model.surface).per_triangle(model.start)
    assert expected.sum() >= 4
    assert result.ledger["crossings_at_start"] == result.ledger["crossings_at_worst"] == expected.sum()
    assert judged(result)[NAME]["verdict"] == "REVIEW"
    with h5py.File(tmp_path / "run" / "fabric.vtkhdf") as file:
        written = file["VTKHDF/CellData/crossings"][: len(expected)]
    assert np.array_equal(written, expected)


def test_no_crossings_pass(tmp_path):
    case = Case.from_dict(bag(tmp_path, False)).vary({"fabric.self_contact": "layers"})
    result = simulate(case, tmp_path / "run")
    assert judged(result)[NAME]["verdict"] == "PASS"
    assert result.ledger["crossings_at_worst"] == 0.0


@pytest.mark.parametrize("through", [True, False])
def test_fabric_that_may_cross_is_counted_and_told_and_not_judged(tmp_path, through):
    result = simulate(Case.from_dict(bag(tmp_path, through)), tmp_path / "run")
    assert NAME not in judged(result)
    assert (result.ledger["crossings_at_end"] > 0.0) is through
    worst = f"fabric passes through fabric in {result.ledger['crossings_at_worst']:.0f} places"
    assert (worst in (tmp_path / "run" / "solver.log").read_text()) is through


@pytest.mark.parametrize("through", [True, False])
def test_crossings_at_the_start_are_told_before_a_run(tmp_path, through):
    case = Case.from_dict(bag(tmp_path, through))
    told = describe(case)
    assert ("crossings 0 of" in told) is not through
    assert ("W-MESH-007" in [concern.code for concern in concerns_of(case, build_model(case))]) is through
