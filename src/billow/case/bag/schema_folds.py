"""The `[[bag.folds]]` tables: how a ready-made bag is folded before it deploys (docs/folding.md)."""

from __future__ import annotations

from itertools import pairwise
from typing import ClassVar, Literal

from pydantic import model_validator

from billow.case.quantity import Strict, chosen_by, quantity, refused

Distance = quantity("m", 1e-3, 10.0)
Gap = quantity("m", 1e-4, 0.05)
MOST_LINES = 100


class FoldTable(Strict):
    """Settings common to all folds. Distances count from the mouth's axis: on the flat bag for the first fold, on the
    present outline for later ones."""

    chooser: ClassVar[str] = "kind"
    across: Literal["x", "y"] = "x"
    """Axis across which the fold lines lie; the lines run along the other one."""
    over: bool = True
    """Whether it is folded above the front panel; false for behind the rear panel."""
    layer_gap: Gap = 0.0008
    """Distance between neighbouring sheets; the two panels of a sheet lie at half the smallest of these."""


class HalfFold(FoldTable):
    """All that lies beyond one line is turned over, sheets that lie on each other together."""

    kind: Literal["half"]
    """half"""
    side: Literal["low", "high"] = "high"
    """Side of the mouth that is turned over."""
    line: quantity("m", 0.0, 10.0) = 0.0
    """Distance of the line; 0 for the middle of the present outline."""


class Leporello(FoldTable):
    """Zigzag from the first line to the rim, each panel above the last."""

    kind: Literal["leporello"]
    """leporello"""
    sides: Literal["both", "low", "high"] = "both"
    """Sides of the mouth that are folded."""
    first_line: Distance = 0.09
    """Distance of the first line."""
    panel: Distance = 0.06
    """Distance between lines; what is left at the rim is half of it to one and a half."""
    lines: tuple[Distance, ...] = ()
    """Distances of all lines, instead of first_line and panel."""

    @model_validator(mode="after")
    def _ascending(self):
        if len(self.lines) > MOST_LINES:
            raise refused(f"lines has {len(self.lines)} entries; at most {MOST_LINES}", "write fewer lines")
        for before, after in pairwise(self.lines):
            if after <= before:
                raise refused(f"lines must increase; {after:g} m follows {before:g} m", "sort the lines")
        return self


class Roll(FoldTable):
    """Rolled up from the rim."""

    kind: Literal["roll"]
    """roll"""
    sides: Literal["both", "low", "high"] = "high"
    """Sides of the mouth that are rolled."""
    turns: quantity("-", 0.25, 50.0) = 2.0
    """How often it is rolled."""
    to: quantity("m", 0.0, 10.0) = 0.0
    """Distance of the line up to which it is rolled, instead of turns; 0 if those decide."""
    core: quantity("m", 1e-3, 0.2) = 0.008
    """Inner radius."""


class Tuck(Strict):
    """The rim is pushed in between the panels, so that four layers lie there. Before all other folds; at most one."""

    chooser: ClassVar[str] = "kind"
    kind: Literal["tuck"]
    """tuck"""
    across: Literal["x", "y"] = "x"
    """Axis along which the rim is pushed in; its creases run along the other one."""
    sides: Literal["both", "low", "high"] = "both"
    """Sides of the mouth that are tucked."""
    depth: Distance = 0.08
    """How far the rim is pushed in, measured on the panels from the rim to the crease."""
    layer_gap: Gap = 0.0008
    """As of the other folds; layers of the tuck lie half as far apart."""


class Relax(Strict):
    """The folded bag comes to rest before it deploys: without gas and damped, between the plates of the case, the flat
    cut comes in. The last table; instead of birth_time."""

    chooser: ClassVar[str] = "kind"
    kind: Literal["relax"]
    """relax"""
    time: quantity("s", 5e-4, 0.1) = 0.005
    """Time over which the flat cut comes in; two fifths of it follow to come to rest."""


FOLDS = {"half": HalfFold, "leporello": Leporello, "roll": Roll, "tuck": Tuck, "relax": Relax}
"""Table of each kind."""

Fold = chosen_by("kind", FOLDS)
