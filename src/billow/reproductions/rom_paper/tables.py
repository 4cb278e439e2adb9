"""The paper's tables, and those it leaves out, from our runs; next to the paper's own numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from billow.reproductions.rom_paper.case_results import SEEDS, CaseResults
from billow.reproductions.rom_paper.nested_design import FORCE_COMPONENTS, FORCE_MODES
from billow.reproductions.rom_paper.published import EPOCHS, MODES
from billow.rom.coupled.coupled_evaluation import COUPLED, TRUE_CONTACT, TRUE_INPUTS
from billow.rom.coupled.motion_errors import MEAN_MOTION, QUANTITIES
from billow.rom.judge.errors import Summary, accuracy
from billow.rom.judge.timing import break_even
from billow.rom.learn.simple_answers import BASELINES
from billow.rom.surrogate.basis import COMPONENTS, Z

OTHER_ANSWERS = (
    f"{TRUE_INPUTS.capitalize()}: the same model, but its bag is predicted with the nodal contact forces that the "
    "solver found in this very run; the force on the impactor still comes from the learned law. "
    f"{TRUE_CONTACT.capitalize()}: no bag and no law; the impactor moves by the same steps under the contact force "
    "that the solver recorded on it, filtered to CFC 180 like the forces that were learned: what a perfect law would "
    f"reach. {MEAN_MOTION.capitalize()}: that of the training runs, which ignores the design."
)

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """name: of its file; title; caption: how to read it; rows: column -> text or number, None for nothing, at least one
    row, all with the same columns."""

    name: str
    title: str
    caption: str
    rows: Sequence[dict[str, Cell]]

    @property
    def columns(self) -> list[str]:
        return list(self.rows[0])

    @property
    def file(self) -> str:
        return f"tables/{self.name}.csv"

    def csv(self) -> str:
        """As a file for other programs, every number with six digits."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([self.columns, *self._plain()])
        return text.getvalue()

    def record(self) -> dict:
        """For tables.json."""
        return {"title": self.title, "caption": self.caption, "columns": self.columns, "rows": self._plain()}

    def _plain(self) -> list[list]:
        six_digits = [[float(f"{c:.6g}") if isinstance(c, float) else c for c in row.values()] for row in self.rows]
        return [["" if cell is None else cell for cell in row] for row in six_digits]


def parameter_table(results: CaseResults) -> Table:
    """The paper's Table 1, of this study."""
    rows = [{"parameter": p.label, "unit": p.unit, "min": p.low, "max": p.high} for p in results.surrogate.parameters]
    return _table(results, "table-1", "Table 1: design parameters", "", rows)


WITHOUT_CLOCK = "without a clock of designs, which models with forces cannot have"
"""Of models that are compared with others that have forces as inputs; the surrogate of the case has one if it helps."""


def accuracy_table(results: CaseResults) -> Table:
    """All components at the largest size, next to simple answers."""
    evaluation, rows = results.evaluation, []
    for c, axis in enumerate(COMPONENTS):
        for name in ("surrogate", "truncation", "regression", *BASELINES):
            summary = evaluation.summary(name, c)
            reached = {"accuracy [%]": 100.0 * accuracy(summary.mean, results.reference_length)}
            reached |= _of_floor(results, summary, c)
            rows.append({"": axis, "answer": name} | _millimetres(summary) | _of_length(results, summary) | reached)
    caption = (
        f"RMSE of paper equation 5 with N_DOE = {results.largest}, K = {results.surrogate.modes}. Truncation: the best "
        "any coefficients could do. Regression: what wrong coefficients add; in every snapshot the squares of the two "
        "add up to that of the surrogate. Accuracy as the paper counts it."
    )
    return _table(results, "accuracy", f"Error on {len(evaluation.test)} unseen runs", caption, rows)


def against_size(results: CaseResults) -> Table:
    """More runs: mean RMSE of each component, and what twice as many would bring."""
    rows, expected = [], []
    for size, made in results.sizes.items():
        for c, axis in enumerate(COMPONENTS):
            summary = Summary.of(np.concatenate([fit.rmse[-1, :, :, c] for fit in made.plain]))
            floor = {"truncation [mm]": 1e3 * made.plain[0].truncation[-1, :, :, c].mean()}
            known = {"N_DOE": size, "runs used": made.runs, "": axis}
            of_floor = _of_floor(results, summary, c)
            rows.append(known | _millimetres(summary) | floor | _of_length(results, summary) | of_floor)
    for c, axis in enumerate(COMPONENTS):
        curve = results.learning_curve(c)
        if curve is not None:
            more = f"{2 * results.largest} runs would bring {1e3 * curve.doubled:.2g} mm"
            expected.append(f"{axis} falls by {100 * curve.per_doubling:.0f} % with every doubling: {more}")
    caption = f"K = {results.surrogate.modes}, no forces, {WITHOUT_CLOCK}, mean over {len(SEEDS)} seeds. "
    caption += "; ".join(expected) + "."
    return _table(results, "learning-curve", "Error against the number of training runs", caption, rows)


def against_modes(results: CaseResults) -> Table:
    """z against K for each N_DOE: the numbers behind the paper's Figures 4 and 9."""
    rows = []
    for size, made in results.sizes.items():
        for row, count in enumerate(made.sweep.counts):
            summary = made.sweep.summary(Z, row)
            names = ("truncation", "regression")
            parts = {f"{name} [mm]": 1e3 * getattr(made.sweep, name)[row, :, :, Z].mean() for name in names}
            cells = {"N_DOE": size, "K": count} | _millimetres(summary) | parts | _of_length(results, summary)
            cells |= _of_floor(results, summary, Z)
            if made.sweep_forces is not None:
                cells["mean with true forces [mm]"] = 1e3 * made.sweep_forces.summary(Z, row).mean
            rows.append(cells)
    title = f"z-displacement against modes (Figures {results.case.figures[0]} and {results.case.figures[1]})"
    caption = f"One model with the most modes, cut, {WITHOUT_CLOCK}: fewer modes are the first of more."
    return _table(results, "modes", title, caption, rows)


def force_table(results: CaseResults) -> Table:
    """With and without the forces of the unseen runs: the numbers behind the paper's Figure 7."""
    rows = []
    for size, made in results.sizes.items():
        for c, axis in enumerate(COMPONENTS):
            plain, true = (np.array([f.summary(c).mean for f in fits]) for fits in (made.plain, made.forces))
            gains = 100.0 * (1.0 - true / plain)
            cells = {"N_DOE": size, "": axis, "without [mm]": 1e3 * plain.mean()}
            cells |= {"with true forces [mm]": 1e3 * true.mean(), "gain [%]": gains.mean()}
            rows.append(cells | {"scatter of the gain between seeds [%]": gains.std(ddof=1)})
    caption = (
        f"Mean RMSE over {len(SEEDS)} seeds; K = {results.surrogate.modes}, M = {FORCE_MODES} modes of the force in "
        f"{FORCE_COMPONENTS}; both {WITHOUT_CLOCK}. The forces are those of the unseen run itself, which are not known "
        "before it is made. A gain smaller than its scatter between seeds is none."
    )
    return _table(results, "force-inputs", "True contact forces as inputs (Figure 7)", caption, rows)


def inference_table(results: CaseResults) -> Table:
    """The paper's Tables 2 and 4."""
    case, ours = results.case, results.inference
    fields = zip(COMPONENTS, case.inference, ours.fields, strict=True)
    tasks = [
        ("networks of all components (shared)", None, ours.networks),
        *((f"{axis.upper()}-model", paper, mine) for axis, paper, mine in fields),
        ("one deployment, all together", sum(case.inference), ours.whole),
        ("loading the models", case.loading, ours.loading),
        ("copying the answer in memory", None, ours.copy),
    ]
    rows = [
        {"task": task, "paper [ms]": None if paper is None else 1e3 * paper, "here [ms]": 1e3 * here}
        for task, paper, here in tasks
    ]
    ratio = "one deployment / copying its answer [-]"
    rows.append({"task": ratio, "paper [ms]": None, "here [ms]": ours.whole / ours.copy})
    caption = (
        f"Processor time, median of many, one thread: {len(results.surrogate.times)} times x "
        f"{results.surrogate.nodes:,} nodes x 3 components; the paper's on its own laptop."
    )
    return _table(results, f"table-{case.tables[0]}", f"Table {case.tables[0]}: inference", caption, rows)


def offline_table(results: CaseResults) -> Table:
    """The paper's Tables 3 and 5."""
    case, rows = results.case, []
    for size, made in results.sizes.items():
        seconds = {"here": (made.generation, made.pod, made.plain[0].cpu_seconds)}
        if size in case.offline:
            seconds["paper"] = case.offline[size]
        for whose, (generation, pod, networks) in seconds.items():
            cells = {"N_DOE": size, "": whose, "generation [s]": generation, "POD [s]": pod}
            rows.append(cells | {"training of networks [s]": networks, "POD and training [s]": pod + networks})
    caption = (
        f"K = {MODES} in the paper, {results.surrogate.modes} here. Generation here: processor times of the runs added "
        "up. POD (with more modes, from which all K are cut) and training: processor time of one core."
    )
    return _table(results, f"table-{case.tables[1]}", f"Table {case.tables[1]}: offline times", caption, rows)


def speed_table(results: CaseResults) -> Table:
    """What the surrogate gains over our solver and over the paper's, stated separately."""
    here, paper, asked = results.evaluation.timing.simulation, results.case.solver, results.inference.whole
    made = results.sizes[results.largest]
    pairs = {
        "our surrogate over our solver": (here, asked),
        "our surrogate over the paper's solver": (paper, asked),
        "the paper's surrogate over its solver": (paper, sum(results.case.inference)),
    }
    rows = [
        {"": name, "solver [s]": solver, "surrogate [ms]": 1e3 * inference, "speed-up [-]": solver / inference}
        for name, (solver, inference) in pairs.items()
    ]
    point = break_even(made.generation + made.training, here, asked)
    pays = "never pays" if point is None else f"pays from {point} deployments on"
    caption = f"One deployment. Making it counted, {made.runs} training runs included, our surrogate {pays}."
    return _table(results, "speed", "Speed-up", caption, rows)


def interval_table(results: CaseResults) -> Table:
    """How many unseen values the intervals cover."""
    rows = []
    for check in results.evaluation.intervals:
        cells = {"nominal level": f"{100 * check.level:.0f} %"}
        for c, axis in enumerate(COMPONENTS):
            cells[f"{axis} inside [%]"] = 100.0 * check.covered[c]
            cells[f"{axis} half width [mm]"] = 1e3 * check.half_width[c]
        rows.append(cells | {"worst run, z [%]": 100.0 * check.worst_run[Z]})
    unseen = len(results.evaluation.test)
    caption = f"Part of the values of {unseen} unseen runs inside their intervals and mean half width."
    return _table(results, "intervals", "Intervals on unseen runs", caption, rows)


def recipe_table(results: CaseResults) -> Table:
    """The paper's recipe next to ours, on the same runs."""
    paper, ours = results.recipe, results.sizes[results.largest].plain[0]
    summary = ours.summary(COMPONENTS.index(paper.component))
    fits = {
        f"paper: {paper.networks} networks, {paper.epochs:,} epochs": (paper.component, paper.summary, paper),
        f"ours: one shared ensemble, {ours.surrogate.training['epochs']} epochs": ("x, y and z", summary, ours),
    }
    rows = []
    for name, (trained, errors, fit) in fits.items():
        cells = {"recipe": name, "trained": trained} | _millimetres(errors) | _of_length(results, errors)
        rows.append(cells | {"training [CPU s]": fit.cpu_seconds})
    theirs, mine = rows
    ratios = {column: mine[column] / theirs[column] for column in (*_millimetres(summary), "training [CPU s]")}
    rows.append(dict.fromkeys(mine) | {"recipe": "ours / paper [-]"} | ratios)
    short = f" The paper trains {EPOCHS:,} epochs: this training was cut short." * (paper.epochs < EPOCHS)
    caption = (
        f"N_DOE = {results.largest}, K = {results.surrogate.modes}, the same bases, RMSE of {paper.component}. The "
        f"paper's networks learn {paper.component} alone; all three components would take them three times as long, "
        f"{3 * paper.cpu_seconds / ours.cpu_seconds:,.0f} times ours.{short}"
    )
    return _table(results, "recipes", "Both recipes side by side", caption, rows)


def rating_table(results: CaseResults) -> Table:
    """The coupled model's impactor against the solver's, next to answers that use more or less."""
    found, rows = results.coupled_evaluation, []
    for quantity in QUANTITIES:
        cells = {"": quantity}
        for answer in found.ratings:
            named = "" if answer == COUPLED else f"{answer}: "
            cells[f"{named}median"] = found.median(quantity, answer)
            cells[f"{named}worst"] = found.worst(quantity, answer)
        rows.append(cells)
    caption = (
        f"ISO/TS 18571 rating against the solver, {len(found.runs)} unseen runs, along z. First pair: the coupled "
        f"model, to which nothing of the deployment is known in advance. {OTHER_ANSWERS}"
    )
    return _table(results, "coupled", "The coupled model's impactor", caption, rows)


def rating_by_run(results: CaseResults) -> Table:
    """The rating of the impactor's acceleration, run by run."""
    found = results.coupled_evaluation
    scores = {
        f"{quantity.removeprefix('acceleration ')}: {answer}": found.overall(quantity, answer).tolist()
        for quantity in QUANTITIES
        if quantity.startswith("acceleration")
        for answer in found.ratings
    }
    rows = [{"run": run} | {name: of[k] for name, of in scores.items()} for k, run in enumerate(found.runs)]
    caption = f"ISO/TS 18571 rating against the solver, along z. {OTHER_ANSWERS}"
    return _table(results, "coupled-runs", "The impactor's acceleration, run by run", caption, rows)


def _table(results: CaseResults, name: str, title: str, caption: str, rows) -> Table:
    return Table(f"{results.case.name}-{name}", title, caption, rows)


def _millimetres(summary: Summary) -> dict[str, float]:
    names = {"mean": "mean", "p10": "p10", "p90": "p90", "max": "maximum"}
    return {f"{column} [mm]": 1e3 * getattr(summary, name) for column, name in names.items()}


def _of_floor(results: CaseResults, summary: Summary, component: int) -> dict[str, Cell]:
    """Mean error over what no model can be below, if that was measured (`billow floor`)."""
    if (floor := results.evaluation.floor) is None:
        return {}
    least = float(floor.means[component])
    return {"mean over floor [-]": summary.mean / least if least else None}


def _of_length(results: CaseResults, summary: Summary) -> dict[str, float]:
    return {f"mean of {results.reference_length:g} m [%]": 100.0 * summary.mean / results.reference_length}
