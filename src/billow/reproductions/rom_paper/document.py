"""One report and its tables and figures as files."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from billow import __version__
from billow.base.plot_style import png, styled
from billow.reproductions.rom_paper import figures, tables
from billow.reproductions.rom_paper.case_results import CaseResults
from billow.reproductions.rom_paper.jets import JetComparison
from billow.reproductions.rom_paper.tables import Table
from billow.results.atomic import write_atomically
from billow.results.machine import machine
from billow.rom.judge.figures import cross_sections, error_against_modes, error_distribution, evaluation_time
from billow.rom.judge.findings import weaknesses
from billow.rom.judge.report import metrics, render
from billow.rom.surrogate.basis import Z

DOTS = 180
"""Dots per inch of the PNG files."""

TRUE_FORCES = (
    "The paper's numbers of this case use the contact forces of the unseen run as inputs, which are not known before "
    "it is made. Ours do not, unless they are named so."
)


@dataclass(frozen=True)
class Picture:
    """name: of its file; title; caption; draw: makes it; narrow: not over the whole page."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure]
    narrow: bool = False

    @property
    def file(self) -> str:
        return f"figures/{self.name}.png"


def write_document(folder: Path, cases: list[CaseResults], jets: JetComparison | None, missing: list[str]) -> Path:
    """Write report.html, README.md, tables.json, metrics-CASE.json, tables/*.csv and figures/*.png into `folder`.

    missing: sentences about what was not requested or is not available. Returns the path of report.html.
    """
    for part in ("tables", "figures"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    sections, pictures, compared = [_section(results) for results in cases], {}, None
    made = [part for section in sections for part in section["parts"]]
    for results in cases:
        record = metrics(results.evaluation) | {"paper_case": results.case.name}
        record["inference_cpu_s"] = asdict(results.inference)
        if results.coupled_evaluation is not None:
            record["coupled"] = results.coupled_evaluation.record()
        write_atomically(folder / f"metrics-{results.case.name}.json", json.dumps(record, allow_nan=False) + "\n")
    if jets is not None:
        caption = "Left: over time. Right: along the radius at the moment of the dotted line."
        shape = Picture("jets", "Effect of the jet direction on the bag's height", caption, jets.figure)
        compared = {"sentences": jets.sentences(), "parts": [shape, jets.table()]}
        made += compared["parts"]
    for part in made:
        if isinstance(part, Table):
            content = part.csv()
        else:
            pictures[part.name], content = _drawn(part.draw)
        write_atomically(folder / part.file, content)
    found = {part.name: part.record() for part in made if isinstance(part, Table)}
    write_atomically(folder / "tables.json", json.dumps(found, indent=1, allow_nan=False) + "\n")
    here = {name: str(value) for name, value in machine().items()} | {"Billow": __version__}
    text = render(
        __package__, pictures, cases=sections, jets=compared, missing=missing, machine=here,
        version=__version__, number=number,
    )  # fmt: skip
    write_atomically(folder / "report.html", text)
    write_atomically(folder / "README.md", _readme(sections, missing, made, here))
    return folder / "report.html"


def number(value: float) -> str:
    """Three digits, without an exponent while it can be avoided."""
    if value != value:
        return "–"
    if abs(value) >= 1000.0:
        return f"{value:,.0f}"
    return f"{value:.3g}" if value == 0.0 or abs(value) >= 1e-3 else f"{value:.1e}"


def _parts(results: CaseResults) -> list[Picture | Table]:
    case, evaluation, by_size = results.case, results.evaluation, results.sizes.items()
    modes, spread, even, cut = case.figures
    typical, worst = evaluation.typical_and_worst()
    making = {size: made.generation + made.training for size, made in by_size}
    sweeps = {size: made.sweep for size, made in by_size}
    true_forces = {size: made.sweep_forces for size, made in by_size} if case.forces else None
    unseen, length = len(evaluation.test), f"{results.reference_length:g} m"

    def picture(key, title, caption, draw, *arguments, narrow=False):
        return Picture(f"{case.name}-{key}", title, caption, partial(draw, *arguments), narrow)

    parts = [
        tables.parameter_table(results),
        tables.accuracy_table(results),
        picture(f"figure-{modes}", f"Figure {modes}: mean z RMSE against modes",
                f"{unseen} unseen runs; models {tables.WITHOUT_CLOCK}. Right: as part of the strap of {length}."
                + " Dashed: with the contact forces of the unseen run as inputs." * case.forces,
                error_against_modes, sweeps, true_forces, results.reference_length, narrow=True),
        picture(f"figure-{spread}", f"Figure {spread}: distribution of the z RMSE",
                f"Over {unseen} unseen runs and all times, of the same models; reference length {length}.",
                error_distribution, sweeps),
        tables.against_modes(results),
        picture("truncation", f"Truncation and regression apart, N_DOE = {results.largest}",
                "Truncation falls with every mode; regression is what the networks add, and it does not.",
                figures.truncation_and_regression, results),
        picture("figure-7", "Figure 7: true contact forces as inputs",
                "The paper shows this for its free obstacle. The band is between seeds.",
                figures.force_inputs, results),
        tables.force_table(results),
        picture(f"figure-{cut}", f"Figure {cut}: cross-sections of a typical unseen run",
                f"Run {typical}, of median error; N_DOE = {results.largest}, K = {results.surrogate.modes}. Dark: "
                "solver. Green: surrogate, which has the design alone. Grey: obstacle.",
                cross_sections, evaluation, results.dataset, typical),
        picture(f"figure-{cut}-worst", "The same of the worst unseen run", f"Run {worst}.",
                cross_sections, evaluation, results.dataset, worst),
        tables.inference_table(results),
        tables.offline_table(results),
        tables.speed_table(results),
        picture(f"figure-{even}", f"Figure {even}: when the surrogate pays",
                "Generation of the training runs and training included; dots mark the break-even points.",
                evaluation_time, making, evaluation.timing.simulation, results.inference.whole, min(making)),
        tables.against_size(results),
    ]  # fmt: skip
    if results.learning_curve(Z) is not None:
        parts.append(picture("learning-curve", "Learning curve", "Dashed: power laws through the points.",
                             figures.learning_curve, results, narrow=True))  # fmt: skip
    if evaluation.intervals:
        parts.append(tables.interval_table(results))
    if results.recipe is not None:
        caption = f"N_DOE = {results.largest}, unseen runs, the same bases."
        parts += [tables.recipe_table(results), picture("recipes", "Both recipes", caption, figures.recipes, results)]
    if results.coupled_evaluation is not None:
        caption = "Nothing of the deployment is known in advance. Two unseen runs."
        shown = picture("coupled", "The coupled model's impactor", caption, figures.coupled_motion, results)
        parts += [tables.rating_table(results), shown, tables.rating_by_run(results)]
    return parts


def _section(results: CaseResults) -> dict:
    surrogate, solver, asked = results.surrogate, results.evaluation.timing.simulation, results.inference.whole
    error, length = results.evaluation.summary("surrogate", Z).mean, results.reference_length
    tiles = [
        (f"{1e3 * error:.3g} mm", f"mean z RMSE, N_DOE = {results.largest}, K = {surrogate.modes}"),
        (f"{100 * error / length:.2f} %", f"of the strap, {length:g} m (paper: 2 %)"),
        (f"{1e3 * asked:.2g} ms", "for one deployment"),
        (_times(results.case.solver / asked), f"faster than the paper's {results.case.solver:,.0f} s"),
    ]
    if solver:
        tiles.append((_times(solver / asked), f"faster than our solver's {solver:.3g} s"))
    return {
        "results": results,
        "sizes": ", ".join(map(str, results.sizes)),
        "remark": TRUE_FORCES if results.case.forces else "",
        "tiles": tiles,
        "parts": _parts(results),
        "weaknesses": weaknesses(results.evaluation),
    }


def _times(factor: float) -> str:
    return f"{factor / 1e6:.2g} million ×" if factor >= 1e6 else f"{factor:,.0f} ×"


def _drawn(draw) -> tuple[bytes, bytes]:
    """As SVG and as PNG."""
    with styled():
        figure = draw()
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, not again for each file
        vector = io.BytesIO()
        figure.savefig(vector, format="svg", metadata={"Date": None, "Creator": "Billow"})
        return vector.getvalue(), png(figure, DOTS)


def _readme(sections, missing, made, here) -> str:
    lines = ["# The ROM paper's tables and figures from our own runs", ""]
    lines += ["Written by `billow paper`; `report.html` has everything in one file.", ""]
    lines += [f"- {sentence}" for sentence in missing]
    for section in sections:
        results, surrogate = section["results"], section["results"].surrogate
        lines += ["", f"## {results.case.heading}", ""]
        size = f"{len(surrogate.times)} times, {surrogate.nodes:,} nodes"
        lines.append(f"N_DOE {section['sizes']}, {len(results.evaluation.test)} unseen runs, {size}.")
        lines += [f"- {sentence}" for sentence in results.notes]
        lines += [f"- {value}: {label}" for value, label in section["tiles"]]
    lines += ["", "## Files", ""]
    lines += [f"- [{part.file}]({part.file}): {part.title}" for part in made]
    lines += ["", "## Machine", "", *(f"- {name}: {value}" for name, value in here.items()), ""]
    return "\n".join(lines)
