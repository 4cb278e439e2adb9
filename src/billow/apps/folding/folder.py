"""The folder of `billow fold`: the folded start step by step, its table of checks, and pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from billow.apps.folding.checks import Check, fold_checks
from billow.apps.folding.figures import draw_step
from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.build import build_model
from billow.case.schema import Case
from billow.results.atomic import new_folder, write_atomically
from billow.results.vtkhdf import FabricWriter

NOTHING_FOLDED = InputError.declare(
    "E-GEO-047",
    "the case has no folds",
    where="bag.folds",
    why="there is nothing to fold",
    cause="a bag that is meant to start flat, or the wrong file",
    remedy="add [[bag.folds]] tables; docs/folding.md has an example",
)


def fold_case(case: Case, out: Path) -> list[Check]:
    """Fold the bag of a case into the folder `out`; returns the table of checks.

    Writes start.vtkhdf (the flat bag at time 0, the bag after the k-th fold at time k, relaxed last), fold.md,
    fold.json and a picture of every step. Raises InputError E-GEO-047 without folds, E-GEO-040..049 for folds that
    cannot be, and those of `new_folder`.
    """
    plan = fold_plan(case.bag)
    if plan is None:
        raise NOTHING_FOLDED()
    model, shape = build_model(case), build_shape(case.bag)
    checks = fold_checks(case, model)
    flat = plan.unfolded(shape.positions)
    with new_folder(out) as folder:
        surface = shape.surface
        with FabricWriter(
            folder / "start.vtkhdf", shape.positions, surface.triangles, surface.part, surface.part_names
        ) as file:
            file.append(0.0, flat)
            for number in range(1, len(plan.steps) + 1):
                file.append(float(number), plan.until(number).folded(flat))
            if case.bag.relax:
                file.append(len(plan.steps) + 1.0, model.start)
        for number in range(1, len(plan.steps) + 1):
            write_atomically(folder / f"fold_{number}.png", draw_step(plan.until(number), number))
        size = np.ptp(model.start, axis=0)
        record = {
            "title": case.title, "layers": plan.layers, "packed_size": size.tolist(),
            "triangles": surface.triangle_count, "checks": [check.record() for check in checks],
        }  # fmt: skip
        write_atomically(folder / "fold.json", json.dumps(record, indent=1))
        write_atomically(folder / "fold.md", _table(case.title, plan.layers, size, checks))
    return checks


def _table(title: str, layers: int, size: np.ndarray, checks: list[Check]) -> str:
    rows = [
        f"| {c.name} | {c.measured:.4g} {c.unit} | {_limit(c)} | {'PASS' if c.passed else 'FAIL'} |" for c in checks
    ]
    packed = " x ".join(f"{1e3 * extent:.4g}" for extent in size)
    head = ["| check | measured | limit | verdict |", "|---|---|---|---|"]
    return "\n".join([f"# {title}", "", f"{layers} layers, {packed} mm", "", *head, *rows]) + "\n"


def _limit(check: Check) -> str:
    if not np.isfinite(check.limit):
        return "released over bag.birth_time"
    return f"at {'least' if check.at_least else 'most'} {check.limit:.4g} {check.unit}".rstrip()
