"""A convergence study from the case to its figures: runs, comparison, convergence.csv, summary.toml, PNG."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import tomli_w

from billow.apps.converge.figures import draw_curves, draw_errors, draw_shapes
from billow.apps.converge.measures import Convergence, converge, quantities
from billow.apps.converge.sweep import Sweep, make_runs
from billow.base.errors import NumericalStop
from billow.results.atomic import write_atomically
from billow.results.csv_files import csv_text

TOO_FEW_RUNS = NumericalStop.declare(
    "E-NUM-007",
    "{failed} of {count} runs were stopped; too few are left to compare",
    where="{folder}",
    cause="the case itself is at fault",
    remedy="see postmortem.json there; make the case run through with few particles first",
)


def run_study(
    sweep: Sweep,
    folder: str | Path,
    tolerance: float,
    progress: Callable[[int, int, str], None],
    threads: int | None = None,
) -> list[Convergence]:
    """Make the missing runs, compare, and write the results into `folder`; returns one comparison for each quantity.

    tolerance: acceptable relative deviation of one run [-]. Errors as `make_runs`; NumericalStop E-NUM-007 if so many
    runs were stopped that fewer than two counts have two runs each.
    """
    folder = Path(folder)
    made, failed = make_runs(sweep, folder, progress, threads)
    runs = {count: results for count, results in made.items() if len(results) > 1}
    if len(runs) < 2:
        name, reason = next(iter(failed.items()))
        raise TOO_FEW_RUNS(failed=len(failed), count=len(sweep.names()), folder=folder / "runs" / name, why=reason)
    found = [converge(quantity, tolerance) for quantity in quantities(runs)]
    write_atomically(folder / "convergence.csv", _table(found))
    write_atomically(folder / "summary.toml", tomli_w.dumps(_summary(found, failed, tolerance)))
    write_atomically(folder / "errors.png", draw_errors(found))
    write_atomically(folder / "curves.png", draw_curves(runs))
    write_atomically(folder / "shapes.png", draw_shapes(runs))
    return found


def enough(found: list[Convergence]) -> int | None:
    """Particles that are enough for every quantity, or None."""
    each = [one.enough for one in found]
    return None if None in each else max(each)


def report(found: list[Convergence], tolerance: float) -> str:
    """Result of a study, as lines of text."""
    many = "deviation of one run, few to many particles"
    lines = [f"{'quantity':<34}{many:<46}{'noise':>8}{'exponent':>10}{'enough':>10}"]
    for one in found:
        errors = "".join(f"{100 * e:8.2f} %" for e in one.deviation)
        said = "-" if one.enough is None else f"{one.enough:,}"
        lines.append(f"{one.quantity.name:<34}{errors:<46}{100 * one.noise[-1]:6.2f} %{one.exponent:>10.2f}{said:>10}")
    count = enough(found)
    if count is None:
        largest = found[0].counts[-1]
        lines.append(f"not yet enough: no count below {largest:,} will do for every quantity; add a larger one")
    else:
        at = list(found[0].counts).index(count)
        worst = max(found, key=lambda one: one.noise[at])
        lines.append(
            f"{count:,} particles are enough (to {100 * tolerance:g} %, or within the noise of the largest count)"
            f"; one run is then off by chance by up to {100 * worst.noise[at]:.2g} % ({worst.quantity.name})"
        )
    return "\n".join(lines)


def _table(found: list[Convergence]) -> str:
    rows = [["quantity", "scale", "particles [-]", "runs [-]", "deviation [-]", "shift [-]", "noise [-]"]]
    for one in found:
        for k, count in enumerate(one.counts.tolist()):
            numbers = (float(a[k]) for a in (one.deviation, one.shift, one.noise))
            runs = len(one.quantity.samples[count])
            rows.append([one.quantity.name, one.quantity.scale, count, runs, *numbers])
    return csv_text(rows)


def _summary(found: list[Convergence], failed: dict[str, str], tolerance: float) -> dict:
    count = enough(found)
    summary = {"tolerance": tolerance, "converged": count is not None, "particles": found[0].counts.tolist()}
    if count is not None:
        summary["particles_enough"] = count
    summary["stopped"] = failed
    summary["quantities"] = {
        one.quantity.name: {
            "scale": one.quantity.scale,
            **{name: getattr(one, name).tolist() for name in ("deviation", "shift", "noise")},
            **({} if math.isnan(one.exponent) else {"exponent": one.exponent}),
            **({} if one.enough is None else {"particles_enough": one.enough}),
        }
        for one in found
    }
    return summary
