"""`billow report RUN`: a run's own page, from the verdict at its top to the log at its end."""

from __future__ import annotations

import base64
import math

import jinja2
import numpy as np
from markupsafe import Markup

from billow.base.quality import VERDICTS
from billow.pages.html import page, web_file
from billow.pages.viewer import MODULES, Shown, viewer_data
from billow.pictures.deployment import Deployment
from billow.pictures.highlights import highlights
from billow.pictures.shot import Shot, drawn
from billow.results.result import Result

FRAMES = 5
"""Of the filmstrip."""
BOOKS = {
    "injected_enthalpy_joule": ("enthalpy injected", "J", 1.0),
    "gas_mass_error": ("mass of the gas, error of what came, went and stayed", "-", 1.0),
    "gas_energy_error": ("energy of the gas, error of the same", "-", 1.0),
    "energy_residual_of_injected": ("energy of the whole model, residual of injected", "%", 100.0),
    "energy_residual_of_largest": ("energy of the whole model, residual of its largest", "%", 100.0),
}
"""Of the ledger, those that are told first: title, shown unit, and how many of it one is."""
LONGEST_LOG = 400_000
"""Letters of the log that are shown, from its end."""


def run_report(result: Result) -> str:
    """The page of a run. Errors as those of `Result` and its files."""
    title = result.record.get("title") or result.folder.name
    shown = Shown(title, result.fabric, result, result.histories)
    head, viewer = web_file("viewer.html").split("<main", 1)
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    content = environment.from_string(web_file("report.html.j2")).render(
        head=Markup(head),  # ours, not to be escaped
        viewer=Markup(f"<main{viewer}"),
        acceptance=acceptance(result.record),
        lost=result.record.get("quality", {}).get("verdict") not in (None, "PASS"),
        summary=[*_summary(result), *highlights(result)],
        filmstrip=base64.b64encode(_filmstrip(result)).decode(),
        criteria=sorted(_criteria(result.record), key=lambda c: -VERDICTS.index(c["verdict"])),
        books=_books(result.ledger),
        warnings=result.record.get("warnings", ()),
        assumptions=result.record.get("assumptions", ()),
        log=_log(result),
    )
    return page(f"{title}: report", content, MODULES, viewer_data([shown], title))


def acceptance(record: dict) -> str:
    """Whether a run can be used, in a sentence or two."""
    quality, status = record.get("quality"), record["status"]
    told = {"completed": "The run is complete"}.get(status, f"The run was {status}")
    if record.get("reason"):
        told += f": {record['reason']}"
    if not quality:
        return f"{told}; it carries no verdict."
    failed = [c for c in _criteria(record) if c["verdict"] != "PASS"]
    if not failed:
        return f"{told}, and passes all {len(quality['criteria'])} criteria of quality."
    worst = "fails" if quality["verdict"] == "FAIL" else "asks for a review"
    names = "; ".join(f"{c['name']} is {c['measured']}, try {c['remedy']}" for c in failed[:3])
    more = f"; and {len(failed) - 3} more below" if len(failed) > 3 else ""
    return f"{told}, and {worst}: {names}{more}."


def _criteria(record: dict) -> list[dict]:
    """Criteria with numbers as text."""
    return [
        {**c, "measured": _number(c["measured"], c["unit"]), "passes": _number(c["passes"], c["unit"]),
         "fails": _number(c["fails"], c["unit"]) if c["fails"] is not None else "–"}
        for c in record.get("quality", {}).get("criteria", ())
    ]  # fmt: skip


def _number(value: float | None, unit: str) -> str:
    if value is None or not math.isfinite(value):
        return "not finite"
    return f"{value:.4g}" + ("" if unit == "-" else f" {unit}")


def _summary(result: Result) -> list[tuple[str, str]]:
    record, fabric = result.record, result.fabric
    parts, end = ", ".join(fabric.part_names), record.get("simulated_time", fabric.times[-1])
    processor = f" ({record['processor_seconds']:.3g} s of processor time)" if "processor_seconds" in record else ""
    obstacles = [f"{name} ({'free' if free else 'locked'})" for name, free in result.obstacles.items()]
    return [
        ("simulated time", f"{1e3 * end:.4g} ms, {len(fabric.times)} frames"),
        ("computing time", f"{result.wall_seconds:.3g} s{processor} for {record.get('steps', 0):,} steps"),
        ("mesh", f"{len(fabric.triangles):,} triangles, {len(fabric.reference):,} nodes; parts {parts}"),
        ("obstacles", ", ".join(obstacles) or "none"),
        ("made by", f"Billow {record.get('billow_version', 'of unknown version')}"),
    ]


def _books(ledger: dict) -> list[tuple[str, str]]:
    first = [
        (title, _number(factor * ledger[name], unit)) for name, (title, unit, factor) in BOOKS.items() if name in ledger
    ]
    rest = [(name.replace("_", " "), _number(value, "-")) for name, value in ledger.items() if name not in BOOKS]
    return first + rest


def _filmstrip(result: Result) -> bytes:
    times = np.linspace(result.times[0], result.times[-1], FRAMES).tolist()
    return drawn(Shot.at([Deployment(result.fabric, result)], times), "png")


def _log(result: Result) -> str:
    path = result.folder / "solver.log"
    return path.read_text("utf-8", "replace")[-LONGEST_LOG:] if path.is_file() else ""
