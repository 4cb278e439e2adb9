"""A comparison in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from billow.apps.compare.differences import Comparison, CurveDifference, injuries, plain, same_mesh
from billow.injury.criteria import GRAVITY, Injury
from billow.pictures.shown_units import factor_of, shown_unit

NAME, NUMBER = 34, 11
"""Letters of the columns."""
METRICS = (
    ("HIC15", "-", lambda injury: injury.hic15.value),
    ("HIC36", "-", lambda injury: injury.hic36.value),
    ("3 ms clip", "g", lambda injury: injury.clip / GRAVITY),
    ("peak, CFC 1000", "g", lambda injury: injury.peak / GRAVITY),
)


def describe(comparison: Comparison, units: Sequence[str], letters: str = "AB") -> str:
    """Tables for a terminal, 100 columns wide. letters: what the side and the reference are called in them."""
    first, second, curves, shapes = comparison.side, comparison.reference, comparison.curves, comparison.shapes
    a, b = letters
    lines = [f"{a}  {first.label}", f"{b}  {second.label}, the reference"]
    lines += [f"{name}: {side.remark}" for name, side in ((a, first), (b, second)) if side.remark]
    if curves:
        lines += ["", _row("peak (ms)", a, b, f"{a} - {b}", f"of {b}", "ISO/TS 18571")]
        lines += [_row(*_peak(found, units)) for found in curves]
        lines += ["", _row("at the end", a, b, f"{a} - {b}", f"of {b}")]
        lines += [_row(*_end(found, units)) for found in curves]
        lines += [f"{found.name} is not rated: {found.why_not}" for found in curves if found.why_not]
    if found := _injury_rows(injuries(first.curves), injuries(second.curves)):
        lines += ["", _row("injury metrics", a, b, f"{a} - {b}", f"of {b}"), *(_row(*cells) for cells in found)]
    if shapes:
        worst = max(shapes, key=lambda shape: shape.rms)
        last, largest = shapes[-1], max(shapes, key=lambda shape: shape.largest)
        lines += [
            "",
            f"shapes of {len(shapes)} common times, distance between the same nodes, root mean square:",
            f"  mean over time {1e3 * np.mean([s.rms for s in shapes]):.2f} mm; most {1e3 * worst.rms:.2f} mm at "
            f"{1e3 * worst.time:.1f} ms; last {1e3 * last.rms:.2f} mm at {1e3 * last.time:.1f} ms",
            f"  farthest node {1e3 * largest.largest:.2f} mm at {1e3 * largest.time:.1f} ms",
        ]
    elif first.fabric is not None and second.fabric is not None:
        why = "no frame of one has the time of one of the other" if same_mesh(first, second) else "their meshes differ"
        lines += ["", f"shapes are not compared node by node: {why}"]
    return "\n".join(lines)


def table(comparisons: Sequence[Comparison], units: Sequence[str]) -> dict:
    """Peaks, ends, ratings and injury metrics as the head and rows of a table for a page: a column a side, the
    reference last; beside a value, how far it is from that of the reference."""
    sides = [comparison.side for comparison in comparisons] + [comparisons[-1].reference]
    rows = []
    for name in dict.fromkeys(found.name for comparison in comparisons for found in comparison.curves):
        of = [next((f for f in c.curves if f.name == name), None) for c in comparisons]
        curves = [found and found.first for found in of] + [next(found.second for found in of if found)]
        largest = max(abs(curve.peak[0]) for curve in curves if curve is not None)
        unit = shown_unit(curves[-1].unit, largest, units)
        factor, shown = factor_of(curves[-1].unit, unit), name.replace("_", " ")
        peaks = [None if curve is None else (curve.peak[0] / factor, curve.peak[1]) for curve in curves]
        rows += [
            [f"{shown} [{unit}], peak", *_against([p and p[0] for p in peaks], [p and p[1] for p in peaks])],
            [f"{shown} [{unit}], at the end", *_against([curve and curve.end / factor for curve in curves])],
            [f"{shown}, ISO/TS 18571", *(_rating(found) for found in of), ""],
        ]
    injured = [injuries(side.curves) for side in sides]
    for body in dict.fromkeys(body for found in injured for body in found):
        for title, unit, value in METRICS:
            values = [value(found[body]) if body in found else None for found in injured]
            rows.append([f"{body} {title}" + ("" if unit == "-" else f" [{unit}]"), *_against(values)])
    labels = [side.label for side in sides]
    return {"head": ["", *labels[:-1], f"{labels[-1]}, the reference"], "rows": rows}


def _against(values: Sequence[float | None], times: Sequence[float | None] | None = None) -> list[str]:
    """Cells of values [and their times], each beside its difference from the last."""
    cells = []
    for k, value in enumerate(values):
        cell = "-" if value is None else _number(value)
        if value is not None and times is not None:
            cell += f" at {1e3 * times[k]:.1f} ms"
        if value is not None and values[-1] is not None and k < len(values) - 1:
            share = _share(value, values[-1])
            cell += "" if share == "-" else f" ({share})"
        cells.append(cell)
    return cells


def _rating(found: CurveDifference | None) -> str:
    return "-" if found is None or found.rating is None else f"{found.rating.overall:.3f} {found.rating.grade}"


def record(comparison: Comparison) -> dict:
    """The same as plain JSON, in SI."""
    sides = {"first": comparison.side, "second": comparison.reference}
    return {name: str(side.source.path) for name, side in sides.items()} | {
        "curves": [found.record() for found in comparison.curves],
        "injury": {name: _injury_record(injuries(side.curves)) for name, side in sides.items()},
        "shapes": [asdict(shape) for shape in comparison.shapes],
    }


def _injury_record(found: dict[str, Injury]) -> dict:
    return {body: {title: plain(of(injury)) for title, _, of in METRICS} for body, injury in found.items()}


def _injury_rows(first: dict[str, Injury], second: dict[str, Injury]) -> list[tuple[str, ...]]:
    rows = []
    for body in dict.fromkeys([*first, *second]):
        for title, unit, of in METRICS:
            name = f"{body} {title}" + ("" if unit == "-" else f" [{unit}]")
            one, other = (of(found[body]) if body in found else float("nan") for found in (first, second))
            rows.append((name, _number(one), _number(other), _number(one - other), _share(one, other)))
    return rows


def _peak(found: CurveDifference, units: Sequence[str]) -> tuple[str, ...]:
    unit, factor = _unit(found, units)
    (one, at_one), (other, at_other) = found.first.peak, found.second.peak
    return (
        f"{found.name} [{unit}]",
        f"{_number(one / factor)} ({1e3 * at_one:.1f})",
        f"{_number(other / factor)} ({1e3 * at_other:.1f})",
        _number((one - other) / factor),
        _share(one, other),
        _rating(found),
    )


def _end(found: CurveDifference, units: Sequence[str]) -> tuple[str, ...]:
    unit, factor = _unit(found, units)
    one, other = found.first.end, found.second.end
    numbers = (_number(one / factor), _number(other / factor), _number((one - other) / factor), _share(one, other))
    return (f"{found.name} [{unit}]", *numbers)


def _unit(found: CurveDifference, units: Sequence[str]) -> tuple[str, float]:
    unit = shown_unit(found.first.unit, max(abs(found.first.peak[0]), abs(found.second.peak[0])), units)
    return unit, factor_of(found.first.unit, unit)


def _row(name: str, *cells: str) -> str:
    return f"{name[:NAME]:<{NAME}}" + "".join(f" {cell:>{15 if k < 2 else NUMBER}}" for k, cell in enumerate(cells))


def _number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _share(one: float, other: float) -> str:
    return f"{100.0 * (one - other) / abs(other):+.1f} %" if np.isfinite(one - other) and other else "-"
