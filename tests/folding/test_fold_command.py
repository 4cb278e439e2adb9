"""`billow fold`: its folder, its table of checks, what `billow check` says; each check can fail."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.apps.folding.checks import fold_checks
from billow.apps.folding.folder import fold_case
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.build import build_model
from billow.case.schema import Case
from billow.cli.main import app
from billow.geometry.folding.fold_measures import least_distance, shears, yarn_strains
from billow.geometry.mesh_file import read_mesh
from billow.run.check import describe

LEPORELLO = {"kind": "leporello", "first_line": 0.12, "panel": 0.06}
BOTH_WAYS = [{**LEPORELLO, "lines": [0.12, 0.235]}, {**LEPORELLO, "lines": [0.12, 0.235], "across": "y"}]


def case(*folds, fabric=None, **settings):
    table = {"shape": "square", "element_size": 0.02, **settings, "folds": list(folds)}
    return Case.from_dict({"bag": table, "fabric": fabric or {}, "gas": {"model": "none"}, "obstacles": []})


def failed(folded):
    return [check.name for check in fold_checks(folded, build_model(folded)) if not check.passed]


def test_the_folder_holds_every_step_and_the_table(tmp_path):
    folded = case(*BOTH_WAYS, birth_time=0.004)
    checks = fold_case(folded, tmp_path / "folded")
    assert all(check.passed for check in checks)
    record = json.loads((tmp_path / "folded" / "fold.json").read_text())
    assert record["layers"] == 18
    assert len(record["checks"]) == len(checks)
    assert "released over bag.birth_time" in (tmp_path / "folded" / "fold.md").read_text()
    shape, plan = build_shape(folded.bag), fold_plan(folded.bag)
    for step, positions in enumerate((plan.unfolded(shape.positions), None, shape.positions)):
        mesh = read_mesh(tmp_path / "folded" / "start.vtkhdf", frame=step)
        np.testing.assert_array_equal(mesh.cells[:, :3], shape.surface.triangles)
        if positions is not None:
            np.testing.assert_allclose(mesh.points, positions, atol=1e-7)
    assert (tmp_path / "folded" / "fold_2.png").stat().st_size > 1000


def test_exit_code_is_that_of_the_table(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(case(LEPORELLO).to_toml())
    done = CliRunner().invoke(app, ["fold", str(path), "--out", str(tmp_path / "one")])
    assert done.exit_code == 0, done.output
    assert "8 layers, 239.7 x 600 x 4 mm" in done.output
    path.write_text(case(*BOTH_WAYS).to_toml())
    done = CliRunner().invoke(app, ["fold", str(path), "--out", str(tmp_path / "two")])
    assert done.exit_code == 1
    assert "FAILED strain of yarns, greatest" in done.output


def test_check_tells_layers_size_and_strain():
    told = describe(case(LEPORELLO))
    assert "8 layers, 239.7 x 600 x 4 mm; edges stretched by 0.005 % at most" in told
    assert "crossings 0 of fabric" in told


def test_two_directions_fail_without_a_birth_ramp():
    assert failed(case(*BOTH_WAYS)) == ["strain of yarns, 99.9 % of them up to", "strain of yarns, greatest"]
    assert failed(case(*BOTH_WAYS, birth_time=0.004)) == []


def test_thick_fabric_fails():
    assert failed(case(LEPORELLO, fabric={"thickness": 0.5e-3})) == ["least distance of layers"]


def test_a_shape_that_is_not_what_the_plan_made_fails(monkeypatch):
    folded = case(LEPORELLO)
    model, shape = build_model(folded), build_shape(folded.bag)
    moved = shape.positions.copy()
    moved[shape.surface.triangles[100, 0]] += [0.0, 1e-6, 0.0]
    monkeypatch.setattr("billow.apps.folding.checks.build_shape", lambda bag: replace(shape, positions=moved))
    assert "edges of the unfolded bag off the cut" in [c.name for c in fold_checks(folded, model) if not c.passed]


def test_a_mesh_without_rows_fails(monkeypatch):
    folded = case({**LEPORELLO, "first_line": 0.127})
    rows = fold_plan(folded.bag).rows(0)
    cleared = build_shape.__globals__["_ready_made"].cache_clear
    cleared()
    with monkeypatch.context() as patch:
        patch.setattr("billow.geometry.folding.fold_plan.FoldPlan.rows", lambda plan, across: ())
        model, shape = build_model(folded), build_shape(folded.bag)
    cleared()
    monkeypatch.setattr("billow.apps.folding.checks.build_shape", lambda bag: shape)
    checks = {check.name: check for check in fold_checks(folded, model)}
    assert checks["creases without one row of nodes in both panels"].measured == len(rows)
    assert not checks["crossings of fabric through fabric"].passed


def test_measures_of_a_stretched_and_sheared_sheet():
    """Pulled by 3 % along x and sheared by 0.1 along y: strains sqrt(1 + g^2) - 1 and 3 %, angle atan(g)."""
    flat = build_shape(case(LEPORELLO).bag)
    plan = fold_plan(case(LEPORELLO).bag)
    sheet = plan.unfolded(flat.positions)
    sheet[:, 2] = 0.0
    x, y = sheet[:, 0].copy(), sheet[:, 1].copy()
    sheet[:, 0] = 1.03 * x + 0.1 * y
    pulled = replace(flat, positions=sheet)
    strains = yarn_strains(pulled, {})
    np.testing.assert_allclose(np.unique(np.round(strains, 10)), [math.hypot(1.0, 0.1) - 1.0, 0.03], atol=1e-9)
    np.testing.assert_allclose(shears(pulled), math.atan(0.1), rtol=1e-9)


def test_yarn_strains_know_the_angle_of_the_cut():
    angles = {"front": 30.0, "rear": 30.0}
    turned = build_shape(case(LEPORELLO, warp_angle=angles).bag)
    strains = yarn_strains(turned, {side: math.radians(angle) for side, angle in angles.items()})
    plain = yarn_strains(build_shape(case(LEPORELLO).bag), {})
    np.testing.assert_allclose(np.sort(strains), np.sort(plain), atol=1e-12)


def test_least_distance_counts_other_layers_only():
    flat = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    folded = np.array([[0.0, 0.0, 0.0], [1e-4, 0.0, 0.0], [0.0, 0.0, 3e-4], [0.0, 0.0, -4e-4]])
    side = np.array([1.0, 1.0, 1.0, -1.0])
    assert least_distance(folded, flat, side, 0.01, 1e-3) == pytest.approx(3e-4)
    assert least_distance(folded[:2], flat[:2], side[:2], 0.01, 1e-3) == 1e-3
