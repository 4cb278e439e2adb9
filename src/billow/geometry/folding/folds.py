"""The folds: each turns the line of a sheet into that of the sheet folded once more (docs/folding.md).

Coordinates count from the mouth's axis, x across the fold lines, z up from the sheet that carries the mouth. What is
folded lies at x > 0; the other side is the same, mirrored.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from billow.base.errors import InputError
from billow.geometry.folding.curve import FoldCurve, Piece, Spiral, Straight, Turn

NO_ROOM = InputError.declare(
    "E-GEO-041",
    "fold {fold} does not fit",
    where="bag.folds, fold {fold}",
    cause="lines too close to each other, or a stack that is high against the width of a panel",
    remedy="move the lines apart, or reduce bag.folds.layer_gap",
)
NO_FABRIC = InputError.declare(
    "E-GEO-042",
    "fold {fold} has a line where no fabric lies",
    where="bag.folds, fold {fold}",
    why="the line is {line:.4g} m from the mouth's axis, and the fabric reaches {reach:.4g} m on that side",
    cause="a length in another unit, or the wrong side; earlier folds have made the bag shorter",
    remedy="move the line onto the fabric",
)
THROUGH_A_FOLD = InputError.declare(
    "E-GEO-043",
    "fold {fold} would bend what is folded already",
    where="bag.folds, fold {fold}",
    cause="a line at an earlier crease or through a roll, or a leporello or roll of several sheets",
    remedy="move the line, or fold in another order; sheets that lie on each other bend together with kind = 'half'",
)
COARSE_ROLL = InputError.declare(
    "E-GEO-044",
    "fold {fold} rolls too tightly for the mesh",
    where="bag.folds, fold {fold}; bag.element_size",
    why="an element of {size:.3g} m cuts {depth:.3g} mm into a roll of core {core:.3g} m whose laps lie {pitch:.3g} mm "
    "apart, and so through the lap inside",
    cause="a mesh that is coarse against the core of the roll",
    remedy="reduce bag.element_size to {fits:.2g} m, or raise bag.folds.core or bag.folds.layer_gap",
)

LONGEST = 1.5
"""Longest edges of a mesh, in edges."""
ROUNDING = 1e-9
"""Distance [m] from which on two places are two."""

Side = Literal["low", "high"]


@dataclass(frozen=True)
class Fold:
    """across: the axis (0 is x, 1 is y) across which the lines lie. side: of the mouth, that is folded. over: above the
    front panel, else behind the rear one. gap: between neighbouring layers [m]. number: of the user's table, from 1."""

    across: int
    side: Side
    over: bool
    gap: float
    number: int

    def applied(self, curve: FoldCurve, size: float) -> FoldCurve:
        """The line after this fold, in a mesh of edges of about size [m]. Raises InputError E-GEO-041..044."""
        curve = replace(curve, gap=self.gap)
        if self.side == "low":
            return replace(self, side="high").applied(curve.mirrored(), size).mirrored()
        if not self.over:
            return replace(self, over=True).applied(curve.upside_down(), size).upside_down()
        folded = self._upwards(curve, size)
        self._require_open_turns(folded, size)
        return folded

    def _upwards(self, curve: FoldCurve, size: float) -> FoldCurve:
        raise NotImplementedError

    def _require_fabric(self, curve: FoldCurve, line: float) -> None:
        reach = curve.box[1]
        if not line < reach:
            raise NO_FABRIC(fold=self.number, line=line, reach=reach)

    def _require_open_turns(self, curve: FoldCurve, size: float) -> None:
        """Elements cut the corner of a turn. Sheets that turn about the same axis are cut alike; whatever else ends
        within a turn has to end before its elements begin."""
        ends = [(piece.x, *piece.box[2:]) for piece in curve.turns]
        for piece, k in ((curve.pieces[0], 0), (curve.pieces[-1], 1)):
            if isinstance(piece, Straight):
                ends.append((piece.ends[k], piece.z, piece.z))
        for turn in curve.turns:
            for x, low, high in ends:
                inside = turn.z - turn.radius < low and high < turn.z + turn.radius
                if inside and ROUNDING < abs(x - turn.x) < LONGEST * size:
                    why = (
                        f"a turn {2e3 * turn.radius:.3g} mm high closes around a crease or a rim that ends "
                        f"{1e3 * abs(x - turn.x):.3g} mm from it, within an element"
                    )
                    raise THROUGH_A_FOLD(fold=self.number, why=why)

    def _narrow(self, missing: float) -> InputError:
        return NO_ROOM(fold=self.number, why=f"a panel is {1e3 * missing:.3g} mm too narrow for the turns at its ends")

    def _single_sheet(self, curve: FoldCurve, line: float) -> Straight:
        """The last piece, if it alone lies beyond the line [m]."""
        *others, last = curve.pieces
        if not isinstance(last, Straight) or last.direction < 0 or any(piece.box[1] > line for piece in others):
            why = f"several sheets lie beyond its line, {line:.4g} m from the mouth's axis"
            raise THROUGH_A_FOLD(fold=self.number, why=why)
        return last


@dataclass(frozen=True)
class HalfFold(Fold):
    """All that lies beyond a line is turned over onto the rest; line: distance [m] from the mouth's axis, None for the
    middle of the present outline.

    Sheets that lie on each other slide: each turns with a radius of its own about one axis, and what lies between two
    turns is shortened alike at both ends, so that every sheet keeps its length.
    """

    line: float | None = None

    def _upwards(self, curve: FoldCurve, size: float) -> FoldCurve:
        low, high, _, _ = curve.box
        line = 0.5 * (low + high) if self.line is None else self.line
        self._require_fabric(curve, line)
        heights = [p.z for p in curve.pieces if isinstance(p, Straight) and p.box[0] < line < p.box[1]]
        beside = self._cut(curve, line)
        still = [part for part in beside if not _is_beyond(part, line)]
        moving = [part for part in beside if _is_beyond(part, line)]
        landing = curve.top(2.0 * line - high, line, still)
        height = 0.5 * (landing + curve.top(line, high, moving)) + curve.radius
        axis = line - 0.5 * np.pi * (height - float(np.mean(heights)))
        return replace(curve, pieces=tuple(self._turned(self._cut(curve, axis), axis, height)))

    def _cut(self, curve: FoldCurve, axis: float) -> list[Piece]:
        """All pieces, straights cut at the axis [m]."""
        parts: list[Piece] = []
        for piece in curve.pieces:
            low, high, _, _ = piece.box
            if not low < axis < high:
                parts.append(piece)
            elif isinstance(piece, Straight):
                there = piece.begin + abs(axis - piece.x)
                parts += [replace(piece, end=there), replace(piece, begin=there, x=axis)]
            else:
                why = f"a crease or a roll lies on its line, {axis:.4g} m from the mouth's axis"
                raise THROUGH_A_FOLD(fold=self.number, why=why)
        return parts

    def _turned(self, parts: list[Piece], axis: float, height: float) -> Iterator[Piece]:
        """The pieces, those beyond the axis turned over about (axis, height) [m]."""
        ways = [(beyond, list(way)) for beyond, way in itertools.groupby(parts, lambda p: _is_beyond(p, axis))]
        for k, (beyond, way) in enumerate(ways):
            yield from self._way(way, axis, height, k > 0, k + 1 < len(ways)) if beyond else way

    def _way(self, way: list[Piece], axis: float, height: float, leaves: bool, returns: bool) -> Iterator[Piece]:
        """A sheet's way beyond the axis, turned over, with the turns where it leaves and returns."""
        first, last = way[0], way[-1]
        leaving, returning = height - first.z if leaves else 0.0, height - last.z if returns else 0.0
        # Of each straight that meets a turn. What is in between moves by it towards the axis.
        taken = np.pi * (leaving + returning) / (leaves + returns)
        for met, piece in ((leaves, first), (returns, last)):
            if met and not isinstance(piece, Straight):
                raise THROUGH_A_FOLD(fold=self.number, why="a crease lies on its line")
            if met and piece.length < taken:
                raise self._narrow(taken - piece.length)
        if leaves:
            yield Turn(first.begin, axis, height, leaving, -0.5 * np.pi, 1)
        for piece in way:
            over = piece.turned_over(axis, height)
            if leaves and piece is first:
                begin = piece.begin + np.pi * leaving
                yield replace(over, begin=begin, end=begin + piece.length - taken)
                continue
            over = over.moved(np.pi * leaving - taken if leaves else 0.0, taken)
            yield replace(over, end=over.end - taken) if returns and piece is last else over
        if returns:
            yield Turn(last.end - np.pi * returning, axis, height, returning, 0.5 * np.pi, -1)


def _is_beyond(piece: Piece, axis: float) -> bool:
    return sum(piece.box[:2]) > 2.0 * axis


@dataclass(frozen=True)
class Leporello(Fold):
    """Zigzag: a single sheet turns back and forth at its lines, each panel above the last. lines: distances [m] from
    the mouth's axis, ascending, on the sheet itself."""

    lines: tuple[float, ...] = ()

    def _upwards(self, curve: FoldCurve, size: float) -> FoldCurve:
        for line in self.lines:
            self._require_fabric(curve, line)
        sheet = self._single_sheet(curve, self.lines[0])
        end, begin, x, z, direction = sheet.end, sheet.begin, sheet.x, sheet.z, 1
        offset = sheet.begin - sheet.x  # from x to s, as far as the sheet lies flat
        pieces = list(curve.pieces[:-1])
        for k, line in enumerate(self.lines):
            there = line + offset
            at = x + direction * (there - begin)
            # The next panel lies on all that lies in its way, this panel included: as far as the panel reaches, with
            # the turn at its end, of which the arc is longer than it is deep, and room for the skins.
            if k + 1 < len(self.lines):
                width = self.lines[k + 1] - line - (0.5 * np.pi - 1.0) * curve.radius + 2.0 * curve.half
            else:
                width = end - there
            below = max(curve.top(*sorted((at, at - direction * (width + curve.gap))), pieces), z)
            up = below + curve.pitch
            radius = 0.5 * (up - z)
            start = there - 0.5 * np.pi * radius
            if start < begin:
                raise self._narrow(begin - start)
            panel = Straight(begin, start, x, z, direction)
            turn = Turn(start, panel.ends[1], z + radius, radius, -0.5 * np.pi, direction)
            pieces += [panel, turn]
            begin, x, z, direction = turn.end, panel.ends[1], up, -direction
        if begin > end:
            raise self._narrow(begin - end)
        return replace(curve, pieces=(*pieces, Straight(begin, end, x, z, direction)))


@dataclass(frozen=True)
class Roll(Fold):
    """A single sheet rolled up from its rim. core: radius [m] that is left free inside. turns: how often, or line: its
    distance [m] from the mouth's axis up to which it is rolled; the other is None."""

    core: float = 0.008
    turns: float | None = None
    line: float | None = None

    def _upwards(self, curve: FoldCurve, size: float) -> FoldCurve:
        pitch, inner = curve.pitch, self.core + curve.half
        growth = pitch / (4.0 * np.pi)  # length = inner t + growth t^2 over the angle t
        reach = curve.box[1]
        if self.line is None:
            angle = 2.0 * np.pi * self.turns
            line = reach - (inner * angle + growth * angle**2)
        else:
            line = self.line
            self._require_fabric(curve, line)
            angle = (np.sqrt(inner**2 + 4.0 * growth * (reach - line)) - inner) / (2.0 * growth)
        sheet = self._single_sheet(curve, line)
        start = sheet.begin + line - sheet.x
        if start < sheet.begin:
            why = (
                f"{angle / (2.0 * np.pi):.3g} turns need {1e3 * (sheet.begin - start):.3g} mm more than the flat sheet"
            )
            raise NO_ROOM(fold=self.number, why=why, remedy="reduce bag.folds.turns or bag.folds.core")
        depth = size**2 / (8.0 * self.core)  # of a chord in the innermost lap
        if depth > pitch:
            raise COARSE_ROLL(
                fold=self.number, size=size, depth=1e3 * depth, core=self.core, pitch=1e3 * pitch,
                fits=np.sqrt(8.0 * self.core * pitch),
            )  # fmt: skip
        radius = inner + 2.0 * growth * angle
        if any(piece.box[1] > line - radius for piece in curve.pieces[:-1]) or start - radius < sheet.begin:
            why = f"the roll, {2e3 * radius:.3g} mm thick, would lie on a crease or on what is folded already"
            raise NO_ROOM(fold=self.number, why=why)
        flat = replace(sheet, end=start)
        spiral = Spiral(start, sheet.end, line, sheet.z + radius, radius, pitch, -0.5 * np.pi, 1)
        return replace(curve, pieces=(*curve.pieces[:-1], flat, spiral))
