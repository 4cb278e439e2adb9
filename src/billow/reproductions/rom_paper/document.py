"""One report and its tables and figures as files."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from billow import __version__
from billow.base.plot_style import STYLE
from billow.reproductions.rom_paper import figures
from billow.reproductions.rom_paper.case_results import CaseResults
from billow.reproductions.rom_paper.jets import JetComparison
from billow.reproductions.rom_paper.table import Table
from billow.reproductions.rom_paper.tables import parameter_table, tables
from billow.results.atomic import write_atomically
from billow.results.machine import machine
from billow.rom.judge.figures import cross_sections
from billow.rom.judge.findings import weaknesses
from billow.rom.judge.metrics_file import metrics
from billow.rom.judge.report import render

Z = 2
DOTS = 180
"""Dots per inch of the PNG files."""

TRUE_FORCES = (
    "The paper's numbers of this case are with the contact forces of the unseen run as inputs, which nobody has before "
    "it is made. Ours are without, unless they are named so."
)


@dataclass(frozen=True)
class Picture:
    """name: of its file; title; caption; draw: makes it; narrow: not over the whole page."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure]
    narrow: bool = False


def write_document(folder: Path, cases: list[CaseResults], jets: JetComparison | None, missing: list[str]) -> Path:
    """Write report.html, README.md, tables.json, metrics-CASE.json, tables/*.csv and figures/*.png into `folder`.

    missing: sentences about what was not asked for or cannot be had. Returns the path of report.html.
    """
    for part in ("tables", "figures"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    sections, pictures, made = [], {}, []
    for results in cases:
        parts = _parts(results)
        sections.append(_section(results, parts))
        made += parts
        record = metrics(results.evaluation) | {
            "paper_case": results.case.name,
            "inference_cpu_s": asdict(results.inference),
        }
        if results.coupled_evaluation is not None:
            record["coupled"] = results.coupled_evaluation.record()
        write_atomically(folder / f"metrics-{results.case.name}.json", json.dumps(record, allow_nan=False) + "\n")
    compared = None
    if jets is not None:
        caption = "Left: over time. Right: along the radius at the moment of the dotted line."
        parts = [Picture("jets", "Effect of the jet direction on the bag's height", caption, jets.figure), jets.table()]
        compared = {"sentences": jets.sentences(), "parts": parts}
        made += parts
    for part in made:
        if isinstance(part, Table):
            write_atomically(folder / "tables" / f"{part.name}.csv", part.csv())
        else:
            pictures[part.name], dots = _drawn(part.draw)
            write_atomically(folder / "figures" / f"{part.name}.png", dots)
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
    case, of, name = results.case, tables(results), results.case.name
    by_name = {table.name.removeprefix(f"{name}-"): table for table in of}
    modes, spread, even, cut = case.figures
    order = results.evaluation.errors["surrogate"][:, :, Z].mean(axis=1).argsort()
    typical, worst = (results.evaluation.test[order[k]] for k in ((len(order) - 1) // 2, -1))
    unseen, length = len(results.evaluation.test), f"{results.reference_length:g} m"

    def picture(key, title, caption, draw, narrow=False):
        return Picture(f"{name}-{key}", title, caption, draw, narrow)

    def sections(run):
        return partial(cross_sections, results.evaluation, results.surrogate, results.dataset, run)

    parts = [
        parameter_table(case, results.evaluation.parameters),
        by_name["accuracy"],
        picture(f"figure-{modes}", f"Figure {modes}: mean z RMSE against modes",
                f"{unseen} unseen runs. Right: as part of the strap of {length}."
                + " Dashed: with the contact forces of the unseen run as inputs." * case.forces,
                partial(figures.error_against_modes, results), narrow=True),
        picture(f"figure-{spread}", f"Figure {spread}: distribution of the z RMSE",
                f"Over {unseen} unseen runs and all times; reference length {length}.",
                partial(figures.distribution, results)),
        by_name["modes"],
        picture("truncation", f"Truncation and regression apart, N_DOE = {results.largest}",
                "Truncation falls with every mode; regression is what the networks add, and it does not.",
                partial(figures.truncation_and_regression, results)),
        picture("figure-7", "Figure 7: true contact forces as inputs",
                "The paper shows this for its free obstacle. The band is between seeds.",
                partial(figures.force_inputs, results)),
        by_name["force-inputs"],
        picture(f"figure-{cut}", f"Figure {cut}: cross-sections of a typical unseen run",
                f"Run {typical}, of median error; N_DOE = {results.largest}, K = {results.evaluation.modes}. Dark: "
                "solver. Green: surrogate, which saw the design alone. Grey: obstacle.", sections(typical)),
        picture(f"figure-{cut}-worst", "The same of the worst unseen run", f"Run {worst}.", sections(worst)),
        by_name[f"table-{case.tables[0]}"],
        by_name[f"table-{case.tables[1]}"],
        by_name["speed"],
        picture(f"figure-{even}", f"Figure {even}: when the surrogate pays",
                "Generation of the training runs and training included; dots mark the break-even points.",
                partial(figures.evaluation_time, results)),
        by_name["learning-curve"],
    ]  # fmt: skip
    if results.learning_curve(Z) is not None:
        draw = partial(figures.learning_curve, results)
        parts.append(picture("learning-curve", "Learning curve", "Dashed: power laws through the points.", draw, True))
    if "intervals" in by_name:
        parts.append(by_name["intervals"])
    if results.recipe is not None:
        caption = f"N_DOE = {results.largest}, unseen runs, the same bases."
        draw = partial(figures.recipes, results)
        parts += [by_name["recipes"], picture("recipes", "Both recipes", caption, draw)]
    if results.coupled_evaluation is not None:
        caption = "Nothing of the deployment is known in advance. Two unseen runs."
        draw = partial(figures.coupled_motion, results)
        shown = picture("coupled", "The coupled model's impactor", caption, draw)
        parts += [by_name["coupled"], shown, by_name["coupled-runs"]]
    return parts


def _section(results: CaseResults, parts) -> dict:
    evaluation, solver = results.evaluation, results.evaluation.timing.simulation
    error = evaluation.summary("surrogate", Z).mean
    tiles = [
        (f"{1e3 * error:.3g} mm", f"mean z RMSE, N_DOE = {results.largest}, K = {evaluation.modes}"),
        (
            f"{100 * error / results.reference_length:.2f} %",
            f"of the strap, {results.reference_length:g} m (paper: 2 %)",
        ),
        (f"{1e3 * results.inference.whole:.2g} ms", "for one deployment"),
        (
            _times(results.case.solver / results.inference.whole),
            f"faster than the paper's {results.case.solver:,.0f} s",
        ),
    ]
    if solver:
        tiles.append((_times(solver / results.inference.whole), f"faster than our solver's {solver:.3g} s"))
    return {
        "heading": results.case.heading,
        "title": evaluation.title,
        "sizes": ", ".join(map(str, results.sizes)),
        "unseen": len(evaluation.test),
        "times": len(evaluation.times),
        "nodes": evaluation.nodes,
        "triangles": evaluation.triangles,
        "remark": TRUE_FORCES if results.case.forces else "",
        "notes": results.notes,
        "tiles": tiles,
        "parts": parts,
        "weaknesses": weaknesses(evaluation),
    }


def _times(factor: float) -> str:
    return f"{factor / 1e6:.2g} million ×" if factor >= 1e6 else f"{factor:,.0f} ×"


def _drawn(draw) -> tuple[bytes, bytes]:
    """As SVG and as PNG."""
    with matplotlib.rc_context(STYLE):
        figure = draw()
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, not again for each file
        vector, dots = io.BytesIO(), io.BytesIO()
        figure.savefig(vector, format="svg", metadata={"Date": None, "Creator": "Billow"})
        figure.savefig(dots, format="png", dpi=DOTS, metadata={"Software": "Billow"})
    return vector.getvalue(), dots.getvalue()


def _readme(sections, missing, made, here) -> str:
    lines = ["# The ROM paper's tables and figures from our own runs", ""]
    lines += ["Written by `billow paper`; `report.html` has everything in one file.", ""]
    lines += [f"- {sentence}" for sentence in missing]
    for section in sections:
        lines += ["", f"## {section['heading']}", ""]
        size = f"{section['times']} times, {section['nodes']:,} nodes"
        lines.append(f"N_DOE {section['sizes']}, {section['unseen']} unseen runs, {size}.")
        lines += [f"- {sentence}" for sentence in section["notes"]]
        lines += [f"- {value}: {label}" for value, label in section["tiles"]]
    lines += ["", "## Files", ""]
    for part in made:
        where = f"tables/{part.name}.csv" if isinstance(part, Table) else f"figures/{part.name}.png"
        lines.append(f"- [{where}]({where}): {part.title}")
    lines += ["", "## Machine", "", *(f"- {name}: {value}" for name, value in here.items()), ""]
    return "\n".join(lines)
