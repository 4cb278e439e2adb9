"""The paper's tables, and those it leaves out, from our runs; the paper's own numbers stand beside ours."""

from __future__ import annotations

import numpy as np

from billow.reproductions.rom_paper.case_results import SEEDS, CaseResults
from billow.reproductions.rom_paper.coupled_tables import rating_by_run, rating_table
from billow.reproductions.rom_paper.published import EPOCHS, MODES, PublishedCase
from billow.reproductions.rom_paper.reductions import FORCE_COMPONENTS, FORCE_MODES
from billow.reproductions.rom_paper.table import Table
from billow.rom.judge.evaluate import BASELINES
from billow.rom.judge.rmse import Summary, accuracy
from billow.rom.learn.snapshots import COMPONENTS

Z = 2


def tables(results: CaseResults) -> list[Table]:
    """All tables of one case, in the order of the report."""
    made = [
        accuracy_table(results),
        against_size(results),
        against_modes(results),
        force_table(results),
        inference_table(results),
        offline_table(results),
        speed_table(results),
    ]
    if results.evaluation.intervals:
        made.append(interval_table(results))
    if results.recipe is not None:
        made.append(recipe_table(results))
    if results.coupled_evaluation is not None:
        made += [rating_table(results), rating_by_run(results)]
    return made


def accuracy_table(results: CaseResults) -> Table:
    """All components at the largest size, beside simple answers."""
    evaluation = results.evaluation
    rows = [
        (axis, name, *_millimetres(evaluation.summary(name, c)), *_parts(results, evaluation.summary(name, c).mean))
        for c, axis in enumerate(COMPONENTS)
        for name in ("surrogate", "truncation", "regression", *BASELINES)
    ]
    return Table(
        f"{results.case.name}-accuracy",
        f"Error on {len(evaluation.test)} unseen runs",
        f"RMSE of paper equation 5 with N_DOE = {results.largest}, K = {evaluation.modes}. Truncation: the best any "
        "coefficients could do. Regression: what wrong coefficients add; in every snapshot the squares of the two add "
        "up to that of the surrogate. The last column is the accuracy as the paper counts it.",
        ("", "answer", "mean [mm]", "p10 [mm]", "p90 [mm]", "max [mm]", _of_length(results), "accuracy [%]"),
        tuple(rows),
    )


def against_size(results: CaseResults) -> Table:
    """More runs: mean RMSE of each component, and what twice as many would bring."""
    rows = []
    for size, made in results.sizes.items():
        for c, axis in enumerate(COMPONENTS):
            summary = _over_seeds(made.plain, c)
            floor = made.plain[0].truncation[-1, :, :, c].mean()
            rows.append((size, made.runs, axis, *_millimetres(summary), 1e3 * floor, _percent(results, summary.mean)))
    told = []
    for c, axis in enumerate(COMPONENTS):
        curve = results.learning_curve(c)
        if curve is not None:
            expected = 1e3 * curve.errors[-1] * 2.0**-curve.rate
            told.append(
                f"{axis} falls as N_DOE^-{curve.rate:.2f}: {2 * results.largest} runs would bring {expected:.2g} mm"
            )
    return Table(
        f"{results.case.name}-learning-curve",
        "Error against the number of training runs",
        f"K = {results.evaluation.modes}, no forces, mean over {len(SEEDS)} seeds. " + "; ".join(told) + ".",
        (
            *("N_DOE", "runs used", "", "mean [mm]", "p10 [mm]", "p90 [mm]", "max [mm]", "truncation [mm]"),
            _of_length(results),
        ),
        tuple(rows),
    )


def against_modes(results: CaseResults) -> Table:
    """z against K for each N_DOE: the numbers behind the paper's Figures 4 and 9."""
    rows = []
    for size, made in results.sizes.items():
        for row, count in enumerate(made.sweep.counts):
            summary = made.sweep.summary(Z, row)
            truncation, regression = (getattr(made.sweep, n)[row, :, :, Z].mean() for n in ("truncation", "regression"))
            true = None if made.sweep_forces is None else 1e3 * made.sweep_forces.summary(Z, row).mean
            cells = (*_millimetres(summary), 1e3 * truncation, 1e3 * regression, _percent(results, summary.mean))
            rows.append((size, count, *cells, *(() if true is None else (true,))))
    further = ("mean with true forces [mm]",) if results.case.forces else ()
    return Table(
        f"{results.case.name}-modes",
        f"z-displacement against modes (Figures {results.case.figures[0]} and {results.case.figures[1]})",
        "One model with the most modes, cut: fewer modes are the first of more.",
        (
            *("N_DOE", "K", "mean [mm]", "p10 [mm]", "p90 [mm]", "max [mm]", "truncation [mm]", "regression [mm]"),
            *(_of_length(results), *further),
        ),
        tuple(rows),
    )


def force_table(results: CaseResults) -> Table:
    """With and without the forces of the unseen runs: the numbers behind the paper's Figure 7."""
    rows = []
    for size, made in results.sizes.items():
        for c, axis in enumerate(COMPONENTS):
            plain, true = (np.array([f.summary(c).mean for f in fits]) for fits in (made.plain, made.forces))
            gains = 1.0 - true / plain
            scatter = float(gains.std(ddof=1)) if len(gains) > 1 else 0.0
            rows.append((size, axis, 1e3 * plain.mean(), 1e3 * true.mean(), 100 * gains.mean(), 100 * scatter))
    return Table(
        f"{results.case.name}-force-inputs",
        "True contact forces as inputs (Figure 7)",
        f"Mean RMSE over {len(SEEDS)} seeds; K = {results.evaluation.modes}, M = {FORCE_MODES} modes of the force in "
        f"{FORCE_COMPONENTS}. The forces are those the solver found in the very run that is asked for: nobody has them "
        "before it is made. A gain smaller than its scatter between seeds is none.",
        ("N_DOE", "", "without [mm]", "with true forces [mm]", "gain [%]", "scatter of the gain between seeds [%]"),
        tuple(rows),
    )


def inference_table(results: CaseResults) -> Table:
    """The paper's Tables 2 and 4."""
    case, ours = results.case, results.inference
    rows = [("networks of all components (shared)", None, 1e3 * ours.networks)]
    rows += [
        (f"{axis.upper()}-model", 1e3 * paper, 1e3 * mine)
        for axis, paper, mine in zip(COMPONENTS, case.inference, ours.fields, strict=True)
    ]
    rows += [
        ("one deployment, all together", 1e3 * sum(case.inference), 1e3 * ours.whole),
        ("loading the models", 1e3 * case.loading, 1e3 * ours.loading),
        ("copying the answer in memory", None, 1e3 * ours.copy),
        ("one deployment / copying its answer [-]", None, ours.whole / ours.copy),
    ]
    return Table(
        f"{case.name}-table-{case.tables[0]}",
        f"Table {case.tables[0]}: inference",
        f"Processor time, median of many, one thread: {len(results.evaluation.times)} times x "
        f"{results.evaluation.nodes:,} nodes x 3 components; the paper's on its own laptop.",
        ("task", "paper [ms]", "here [ms]"),
        tuple(rows),
    )


def offline_table(results: CaseResults) -> Table:
    """The paper's Tables 3 and 5."""
    case, rows = results.case, []
    for size, made in results.sizes.items():
        networks = made.plain[0].cpu_seconds
        rows.append((size, "here", made.generation, made.pod, networks, made.pod + networks))
        if size in case.offline:
            generation, pod, training = case.offline[size]
            rows.append((size, "paper", generation, pod, training, pod + training))
    return Table(
        f"{case.name}-table-{case.tables[1]}",
        f"Table {case.tables[1]}: offline times",
        f"K = {MODES} in the paper, {results.evaluation.modes} here. Generation here: wall times of the runs added up, "
        "made side by side on a machine that had other work. POD (with more modes, from which all K are cut) and "
        "training: processor time of one core.",
        ("N_DOE", "", "generation [s]", "POD [s]", "training of networks [s]", "POD and training [s]"),
        tuple(rows),
    )


def speed_table(results: CaseResults) -> Table:
    """What the surrogate gains over our solver and over the paper's, stated separately."""
    here, paper = results.evaluation.timing.simulation, results.case.solver
    made = results.sizes[results.largest]
    rows = []
    for name, solver, inference in (
        ("our surrogate over our solver", here, results.inference.whole),
        ("our surrogate over the paper's solver", paper, results.inference.whole),
        ("the paper's surrogate over its solver", paper, sum(results.case.inference)),
    ):
        rows.append((name, solver, 1e3 * inference, solver / inference if inference else None))
    point = break_even(made.generation + made.training, here, results.inference.whole)
    told = "never" if point is None else f"from {point} deployments on"
    return Table(
        f"{results.case.name}-speed",
        "Speed-up",
        f"One deployment. Making it counted, {made.runs} training runs included, our surrogate pays {told}.",
        ("", "solver [s]", "surrogate [ms]", "speed-up [-]"),
        tuple(rows),
    )


def interval_table(results: CaseResults) -> Table:
    """Whether intervals hold what they promise."""
    rows = [
        (
            f"{100 * check.level:.0f} %",
            *(cell for c in range(3) for cell in _covered(check, c)),
            100 * check.worst_run[Z],
        )
        for check in results.evaluation.intervals
    ]
    columns = tuple(text for axis in COMPONENTS for text in (f"{axis} inside [%]", f"{axis} half width [mm]"))
    return Table(
        f"{results.case.name}-intervals",
        "Intervals on unseen runs",
        f"Part of the values of {len(results.evaluation.test)} unseen runs inside their intervals and mean half width.",
        ("nominal level", *columns, "worst run, z [%]"),
        tuple(rows),
    )


def recipe_table(results: CaseResults) -> Table:
    """The paper's recipe beside ours, on the same runs."""
    recipe, made = results.recipe, results.sizes[results.largest]
    c = COMPONENTS.index(recipe.component)
    ours, ours_all = made.plain[0].summary(c), made.plain[0].cpu_seconds
    ratios = [mine / theirs for mine, theirs in zip(_millimetres(ours), _millimetres(recipe.summary), strict=True)]
    rows = []
    for name, trained, summary, spent in (
        (
            f"paper: {recipe.networks} networks, {recipe.epochs:,} epochs",
            recipe.component,
            recipe.summary,
            recipe.cpu_seconds,
        ),
        (f"ours: one shared ensemble, {made.plain[0].epochs} epochs", "x, y and z", ours, ours_all),
    ):
        rows.append((name, trained, *_millimetres(summary), _percent(results, summary.mean), spent))
    rows.append(("ours / paper [-]", None, *ratios, None, ours_all / recipe.cpu_seconds))
    short = (
        "" if recipe.epochs >= EPOCHS else f" The paper trains {EPOCHS:,} epochs: this was cut short and says little."
    )
    return Table(
        f"{results.case.name}-recipes",
        "Both recipes side by side",
        f"N_DOE = {results.largest}, K = {results.evaluation.modes}, the same bases, RMSE of {recipe.component}. The "
        f"paper's networks learn {recipe.component} alone; all three components would take them three times as long, "
        f"{3 * recipe.cpu_seconds / ours_all:,.0f} times ours.{short}",
        ("recipe", "trained", "mean [mm]", "p10 [mm]", "p90 [mm]", "max [mm]", _of_length(results), "training [CPU s]"),
        tuple(rows),
    )


def break_even(making: float, simulation: float, inference: float) -> int | None:
    """Fewest deployments for which making [s] and asking a surrogate takes less time than simulating them all."""
    gain = simulation - inference
    return int(np.ceil(making / gain)) if gain > 0.0 else None


def parameter_table(case: PublishedCase, parameters) -> Table:
    """The paper's Table 1, of this study."""
    rows = tuple((p.label, p.unit, p.low, p.high) for p in parameters)
    return Table(f"{case.name}-table-1", "Table 1: design parameters", "", ("parameter", "unit", "min", "max"), rows)


def _millimetres(summary: Summary) -> tuple[float, ...]:
    return tuple(1e3 * getattr(summary, name) for name in ("mean", "p10", "p90", "maximum"))


def _over_seeds(fits, component) -> Summary:
    return Summary.of(np.concatenate([f.rmse[-1, :, :, component] for f in fits]))


def _percent(results, rmse) -> float:
    return 100.0 * rmse / results.reference_length


def _parts(results, rmse) -> tuple[float, float]:
    return _percent(results, rmse), 100.0 * accuracy(rmse, results.reference_length)


def _of_length(results) -> str:
    return f"mean of {results.reference_length:g} m [%]"


def _covered(check, component) -> tuple[float, float]:
    return 100.0 * check.covered[component], 1e3 * check.half_width[component]
