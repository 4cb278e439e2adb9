"""An evaluation as files: report.html with every figure and table inside, and metrics.json for other programs."""

from __future__ import annotations

import base64
import json
from dataclasses import asdict
from importlib import resources
from pathlib import Path

import jinja2
import numpy as np
from markupsafe import Markup

from billow import __version__
from billow.base.errors import IntegrityError
from billow.results.atomic import write_atomically
from billow.results.machine import machine
from billow.rom.judge import figures
from billow.rom.judge.effects import effects
from billow.rom.judge.errors import accuracy
from billow.rom.judge.evaluate import Evaluation
from billow.rom.judge.findings import acceptance, gain, less_or_more, strongest_baseline, verdict, weaknesses
from billow.rom.judge.timing import training_seconds
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.simple_answers import BASELINES
from billow.rom.surrogate.basis import COMPONENTS, Z, by_axis

METRICS_FORMAT = 1
LEDGER_LIMITS = {
    "gas_mass_error": ("mass of the gas, relative", 1e-12),
    "gas_energy_error": ("energy of the gas, relative", 1e-12),
    "energy_residual_of_injected": ("energy of the whole run, of injected", 0.02),
}


def write_report(dataset: Dataset, evaluation: Evaluation, folder: str | Path, explorer: str | None = None) -> Path:
    """Write report.html, metrics.json and figures/*.svg into `folder` and return the path of report.html. The HTML
    holds its figures; it needs no other file and no network. explorer: the page of `billow explore`, to be put into it
    """
    folder = Path(folder)
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    write_atomically(folder / "metrics.json", json.dumps(metrics(evaluation), indent=1, allow_nan=False) + "\n")
    pictures = _draw(dataset, evaluation)
    for name, picture in pictures.items():
        write_atomically(folder / "figures" / f"{name}.svg", picture)
    write_atomically(folder / "report.html", page(evaluation, pictures, explorer))
    return folder / "report.html"


def page(evaluation: Evaluation, pictures: dict[str, bytes], explorer: str | None = None) -> str:
    """The HTML of a report. pictures: name -> SVG; explorer: as `write_report`."""
    typical, worst = evaluation.typical_and_worst()
    own = evaluation.summary("surrogate", Z)
    reached = accuracy(own.mean, evaluation.reference_length)
    best = strongest_baseline(evaluation, Z)
    lead = gain(evaluation, best, Z)
    timing, here = evaluation.timing, machine()
    return render(
        __package__,
        pictures,
        evaluation=evaluation,
        axes=COMPONENTS,
        typical=typical,
        worst=worst,
        acceptance=acceptance(evaluation),
        explorer=explorer,
        effects=effects(evaluation.surrogate),
        verdict=verdict(evaluation),
        weaknesses=weaknesses(evaluation),
        tiles=[
            (f"{own.mean * 1e3:.3g} mm", "mean z RMSE on unseen runs"),
            (less_or_more(lead), f"z RMSE than the strongest simple answer, {best}"),
            (f"{100 * reached:.1f} %", "accuracy in z as the ROM paper counts it"),
            (f"{timing.inference.whole * 1e3:.2g} ms", "for one deployment"),
            *([(f"{timing.speed_up:,.0f} ×", "faster than the solver")] if timing.simulation else []),
        ],
        answers=("surrogate", *BASELINES),
        gain=gain,
        less_or_more=less_or_more,
        worst_first=evaluation.errors["surrogate"][:, :, Z].mean(axis=1).argsort()[::-1].tolist(),
        ledger=_ledger(evaluation),
        machine={n: str(here[n]) for n in ("processor", "cores", "system")} | {"Billow, now": __version__},
    )


def render(room: str, pictures: dict[str, bytes], **content) -> str:
    """A page from the template report.html.j2 of a package, style and figures inside. pictures: name -> SVG."""
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(resources.files(room).joinpath("report.html.j2").read_text("utf-8"))
    style = Markup(resources.files(__package__).joinpath("report.css").read_text("utf-8"))  # ours, not to be escaped
    embedded = {name: base64.b64encode(picture).decode() for name, picture in pictures.items()}
    return page.render(style=style, figures=embedded, **content)


def _draw(dataset, evaluation) -> dict[str, bytes]:
    typical, worst = evaluation.typical_and_worst()
    calls = {
        "sections-typical": (figures.cross_sections, evaluation, dataset, typical),
        "sections-worst": (figures.cross_sections, evaluation, dataset, worst),
        "error-against-time": (figures.error_against_time, evaluation),
        "singular-values": (figures.singular_values, evaluation),
    }
    if found := effects(evaluation.surrogate):
        calls["effects"] = figures.heights, found
    if curves := _pressures(dataset, (*evaluation.surrogate.runs, *evaluation.test)):
        calls["pressures"] = figures.pressures, curves, evaluation.test
    timing, trained = evaluation.timing, len(evaluation.surrogate.runs)
    if timing.simulation:  # unknown for runs of other solvers
        making = {m.runs: m.generation + m.training for m in evaluation.sweep}
        making[trained] = timing.generation + timing.training
        calls["evaluation-time"] = figures.evaluation_time, making, timing.simulation, timing.inference.whole, trained
    if evaluation.sweep:
        sweeps = {model.runs: model.errors for model in evaluation.sweep}
        calls["error-against-modes"] = figures.error_against_modes, sweeps, None, evaluation.reference_length
        calls["error-distribution"] = figures.error_distribution, sweeps
    return {name: figures.draw(*call) for name, call in calls.items()}


def _pressures(dataset, runs) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Times [s] and pressure [Pa] of the runs that recorded it; those of other programs may have no histories."""
    found = {}
    for run in runs:
        try:
            history = dataset.result(run).histories
        except (AttributeError, IntegrityError):
            continue
        if (pressure := history.find("", "pressure")) is not None:
            found[run] = history.time, pressure
    return found


def _ledger(evaluation) -> list[dict]:
    rows = []
    for key, (label, limit) in LEDGER_LIMITS.items():
        values = {run: abs(ledger[key]) for run, ledger in evaluation.ledgers.items() if key in ledger}
        values = {run: value if np.isfinite(value) else np.inf for run, value in values.items()}
        if values:
            run = max(values, key=values.get)
            row = {"label": label, "worst": values[run], "run": run, "limit": limit, "of": len(values)}
            rows.append(row | {"kept": sum(value <= limit for value in values.values())})
    return rows


def metrics(evaluation: Evaluation) -> dict:
    """The content of metrics.json; keys name the units."""
    surrogate, timing, coverage = evaluation.surrogate, evaluation.timing, evaluation.coverage
    length = evaluation.reference_length
    ranges = zip(surrogate.parameters, coverage.ranges.tolist(), strict=True)
    return {
        "format": METRICS_FORMAT,
        "title": surrogate.title,
        "recipe": surrogate.recipe,
        "modes": surrogate.modes,
        "nodes": surrogate.nodes,
        "train": list(surrogate.runs),
        "test": list(evaluation.test),
        "judgement": evaluation.judgement.record(),
        "floor": None
        if evaluation.floor is None
        else {
            "changes": evaluation.floor.changes,
            "runs": list(evaluation.floor.runs),
            "rmse_m": by_axis(evaluation.floor.means),
            "error_over_floor": dict(zip(COMPONENTS, map(evaluation.over_floor, range(3)), strict=True)),
        },
        "test_left_out": evaluation.unseen.left_out,
        "test_reviewed": evaluation.unseen.reviewed,
        "missing": evaluation.missing,
        "left_out": evaluation.left_out.why,
        "left_out_leaning": evaluation.left_out.leaning,
        "reference_length_m": length,
        "times_s": surrogate.times.tolist(),
        "rmse_m": {name: _by_component(evaluation, name) for name in ("surrogate", *BASELINES)},
        "split_m": {name: _by_component(evaluation, name) for name in ("truncation", "regression")},
        "accuracy": {
            axis: accuracy(evaluation.summary("surrogate", c).mean, length) for c, axis in enumerate(COMPONENTS)
        },
        "snapshots_rmse_m": {name: _rounded(values.tolist()) for name, values in evaluation.errors.items()},
        "snapshots_spread_m": None if evaluation.spread is None else _rounded(evaluation.spread.tolist()),
        "intervals": [
            {
                "level": check.level,
                "covered": by_axis(check.covered),
                "covered_by_run": _rounded(check.by_run.tolist()),
                "half_width_m": by_axis(check.half_width),
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
                "truncation_m": by_axis(floor.mean(axis=(0, 1))),
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
        "timing_s": {
            "simulation": timing.simulation,
            "generation": timing.generation,
            **training_seconds(surrogate),
            "training": timing.training,
            "inference": timing.inference.whole,
            "coefficients": timing.inference.networks,
            "loading": timing.inference.loading,
            "memcpy": timing.inference.copy,
        },
        "speed_up": timing.speed_up,
        "break_even_evaluations": timing.break_even,
        "ledgers": {
            run: {name: value if np.isfinite(value) else None for name, value in ledger.items()}
            for run, ledger in evaluation.ledgers.items()
        },
        "training": surrogate.training,
    }


def _by_component(evaluation, name):
    return {axis: asdict(evaluation.summary(name, c)) for c, axis in enumerate(COMPONENTS)}


def _rounded(values):
    """Lists of numbers with six digits: beyond what any of them means, and the file stays small."""
    return list(map(_rounded, values)) if isinstance(values, list) else float(f"{values:.6g}")
