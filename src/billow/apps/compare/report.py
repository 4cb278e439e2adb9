"""A comparison in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from billow.apps.compare.differences import CurveDifference, ShapeDifference, injuries, plain, same_mesh
from billow.apps.compare.side import Side
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


def describe(
    first: Side,
    second: Side,
    curves: Sequence[CurveDifference],
    shapes: Sequence[ShapeDifference],
    units: Sequence[str],
) -> str:
    """Tables for a terminal, 100 columns wide."""
    lines = [f"A  {first.label}", f"B  {second.label}, the reference"]
    lines += [f"{name}: {side.remark}" for name, side in (("A", first), ("B", second)) if side.remark]
    if curves:
        lines += ["", _row("peak (ms)", "A", "B", "A - B", "of B", "ISO/TS 18571")]
        lines += [_row(*_peak(found, units)) for found in curves]
        lines += ["", _row("at the end", "A", "B", "A - B", "of B")]
        lines += [_row(*_end(found, units)) for found in curves]
        lines += [f"{found.name} is not rated: {found.why_not}" for found in curves if found.why_not]
    if found := _injury_rows(injuries(first.curves), injuries(second.curves)):
        lines += ["", _row("injury metrics", "A", "B", "A - B", "of B"), *(_row(*cells) for cells in found)]
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


def table(first: Side, second: Side, curves: Sequence[CurveDifference], units: Sequence[str]) -> dict:
    """Peaks, ends and injury metrics as the head and rows of a table for a page."""
    rows = []
    for found in curves:
        (peak, *of_peak), (end, *of_end) = _peak(found, units), _end(found, units)
        rows += [(f"{peak}, peak (at ms)", *of_peak), (f"{end}, at the end", *of_end)]
    rows += _injury_rows(injuries(first.curves), injuries(second.curves))
    return {
        "head": ["", first.label, second.label, "difference", "", "ISO/TS 18571"],
        "rows": [_filled(r) for r in rows],
    }


def _filled(cells: Sequence[str]) -> list[str]:
    name, *numbers = cells
    return [name.replace("_", " "), *numbers, *[""] * (5 - len(numbers))]


def record(first: Side, second: Side, curves: Sequence[CurveDifference], shapes: Sequence[ShapeDifference]) -> dict:
    """The same as plain JSON, in SI."""
    return {
        "first": str(first.source.path),
        "second": str(second.source.path),
        "curves": [found.record() for found in curves],
        "injury": {
            name: _injury_record(injuries(side.curves)) for name, side in (("first", first), ("second", second))
        },
        "shapes": [asdict(shape) for shape in shapes],
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
    rating = "-" if found.rating is None else f"{found.rating.overall:.3f} {found.rating.grade}"
    return (
        f"{found.name} [{unit}]",
        f"{_number(one / factor)} ({1e3 * at_one:.1f})",
        f"{_number(other / factor)} ({1e3 * at_other:.1f})",
        _number((one - other) / factor),
        _share(one, other),
        rating,
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
