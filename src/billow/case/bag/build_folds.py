"""From the `[[bag.folds]]` tables to the folds of geometry."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.case.bag import schema_folds
from billow.case.bag.schema_folds import MOST_LINES
from billow.geometry.folding.fold_plan import FoldPlan
from billow.geometry.folding.folds import NO_FABRIC, NO_ROOM, Fold, HalfFold, Leporello, Roll
from billow.geometry.folding.tuck import Tuck


def build_plan(
    tables: tuple[schema_folds.Fold, ...], outline: np.ndarray, mouth: tuple[float, float], mouth_radius: float,
    size: float,
) -> FoldPlan:  # fmt: skip
    """As `FoldPlan.of`, which says what it raises."""
    maps = [table for table in tables if table.kind != "relax"]
    half, tuck = 0.25 * min(table.layer_gap for table in maps), None
    if maps[0].kind == "tuck":
        tuck = _tuck(maps[0], half, outline - mouth)
    folds = tuple(
        fold for k, table in enumerate(maps) if table.kind != "tuck" for fold in _folds(table, k + 1, outline, mouth)
    )
    return FoldPlan.of(folds, outline, mouth, mouth_radius, size, half, tuck)


def _tuck(table: schema_folds.Tuck, half: float, outline: np.ndarray) -> Tuck:
    """outline: of the flat bag, from the mouth [m], (2, 2)."""
    across = "xy".index(table.across)
    low, high = (table.depth * (table.sides in ("both", side)) for side in ("low", "high"))
    rims, sides = (tuple(map(float, outline[:, axis])) for axis in (across, 1 - across))
    return Tuck(across, rims, (low, high), half, sides, sides, 1)


def _folds(table: schema_folds.Fold, number: int, outline: np.ndarray, mouth: tuple[float, float]) -> Iterator[Fold]:
    across = "xy".index(table.across)
    common = {"across": across, "over": table.over, "gap": table.layer_gap, "number": number}
    if isinstance(table, schema_folds.HalfFold):
        yield HalfFold(**common, side=table.side, line=table.line or None)
        return
    for side in ("high", "low") if table.sides == "both" else (table.sides,):
        if isinstance(table, schema_folds.Roll):
            yield Roll(**common, side=side, core=table.core, turns=table.turns, line=table.to or None)
        else:
            low, high = outline[:, across] - mouth[across]
            yield Leporello(**common, side=side, lines=_lines(table, number, high if side == "high" else -low))


def _lines(table: schema_folds.Leporello, number: int, rim: float) -> tuple[float, ...]:
    """Of a leporello [m], up to a rim at `rim` [m]."""
    if table.lines:
        return table.lines
    if not table.first_line < rim:
        raise NO_FABRIC(fold=number, line=table.first_line, reach=rim)
    count = max(1, round((rim - table.first_line) / table.panel))
    if count > MOST_LINES:
        raise NO_ROOM(fold=number, why=f"its panels make {count} lines; at most {MOST_LINES} are allowed")
    return tuple(table.first_line + table.panel * k for k in range(count))
