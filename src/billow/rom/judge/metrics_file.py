"""metrics.json: an evaluation as numbers for other programs."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from billow.results.atomic import write_atomically
from billow.rom.judge.baselines import BASELINES
from billow.rom.judge.errors import accuracy
from billow.rom.judge.evaluate import Evaluation
from billow.rom.judge.timing import training_seconds
from billow.rom.surrogate.basis import COMPONENTS

FORMAT = 1


def write_metrics(path: str | Path, evaluation: Evaluation) -> Path:
    """Write an evaluation to `path`, atomically. Keys name the units."""
    path = Path(path)
    write_atomically(path, json.dumps(metrics(evaluation), indent=1, allow_nan=False) + "\n")
    return path


def metrics(evaluation: Evaluation) -> dict:
    """The content of metrics.json."""
    surrogate, timing, coverage = evaluation.surrogate, evaluation.timing, evaluation.coverage
    ranges = zip(surrogate.parameters, coverage.ranges.tolist(), strict=True)
    return {
        "format": FORMAT,
        "title": surrogate.title,
        "recipe": surrogate.recipe,
        "modes": surrogate.modes,
        "nodes": surrogate.nodes,
        "train": list(surrogate.runs),
        "test": list(evaluation.test),
        "missing": evaluation.missing,
        "left_out": evaluation.left_out.why,
        "left_out_leaning": evaluation.left_out.leaning,
        "reference_length_m": evaluation.reference_length,
        "times_s": surrogate.times.tolist(),
        "rmse_m": {name: _by_component(evaluation, name) for name in ("surrogate", *BASELINES)},
        "split_m": {name: _by_component(evaluation, name) for name in ("truncation", "regression")},
        "accuracy": {
            axis: accuracy(evaluation.summary("surrogate", c).mean, evaluation.reference_length)
            for c, axis in enumerate(COMPONENTS)
        },
        "snapshots_rmse_m": {name: _rounded(values) for name, values in evaluation.errors.items()},
        "snapshots_spread_m": None if evaluation.spread is None else _rounded(evaluation.spread),
        "intervals": [
            {
                "level": check.level,
                "covered": dict(zip(COMPONENTS, check.covered.tolist(), strict=True)),
                "covered_by_run": [_six(row) for row in check.by_run.tolist()],
                "half_width_m": dict(zip(COMPONENTS, check.half_width.tolist(), strict=True)),
            }
            for check in evaluation.intervals
        ],
        "learning_curve": [
            {"component": axis, "runs": list(curve.runs), "rmse_m": list(curve.errors), "rate": curve.rate}
            for axis, curve in zip(COMPONENTS, map(evaluation.learning_curve, range(3)), strict=True)
            if curve is not None
        ],
        "sweep": [
            {
                "runs": model.runs,
                "modes": count,
                "rmse_m": {axis: asdict(model.errors.summary(c, row)) for c, axis in enumerate(COMPONENTS)},
                "truncation_m": dict(zip(COMPONENTS, floor.mean(axis=(0, 1)).tolist(), strict=True)),
                "generation_s": model.generation,
                "training_s": model.training,
            }
            for model in evaluation.sweep
            for row, (count, floor) in enumerate(zip(model.errors.counts, model.errors.truncation, strict=True))
        ],
        "energy_kept": [basis.energy_fraction.tolist() for basis in surrogate.bases],
        "singular_values_m": [basis.singular_values.tolist() for basis in surrogate.bases],
        "coverage": {
            "nearest_training_design": coverage.nearest.tolist(),
            "between_training_designs": coverage.between if np.isfinite(coverage.between) else None,
            "part_of_range": {parameter.name: part for parameter, part in ranges},
        },
        "timing_s": _seconds(evaluation),
        "speed_up": timing.speed_up,
        "break_even_evaluations": timing.break_even,
        "ledgers": {
            run: {name: value if np.isfinite(value) else None for name, value in ledger.items()}
            for run, ledger in evaluation.ledgers.items()
        },
        "training": surrogate.training,
    }


def _seconds(evaluation) -> dict:
    timing, asked = evaluation.timing, evaluation.timing.inference
    return {
        "simulation": timing.simulation,
        "generation": timing.generation,
        **training_seconds(evaluation.surrogate),
        "training": timing.training,
        "inference": asked.whole,
        "coefficients": asked.networks,
        "loading": asked.loading,
        "memcpy": asked.copy,
    }


def _by_component(evaluation, name):
    return {axis: asdict(evaluation.summary(name, c)) for c, axis in enumerate(COMPONENTS)}


def _rounded(values):
    # Six digits are beyond what any of these numbers means, and keep the file small.
    return [[_six(time) for time in run] for run in values.tolist()]


def _six(row):
    return [float(f"{value:.6g}") for value in row]
