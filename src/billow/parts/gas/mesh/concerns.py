"""What is allowed of a mesh gas but probably not meant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from billow.base.errors import Concern
from billow.geometry.cut_cells import CutCells
from billow.geometry.folding.strips import Strips
from billow.geometry.lattice_clipping import NORMAL
from billow.parts.part import Setting

FEWEST = 12
"""Cells across a bag below which jets and waves mean little."""
LAYERS, MANY = 3.0, 0.05
"""Fabric of a chamber in a cell, in faces of a cell, from which it is more than two panels; and the share of the fabric
in such cells from which on it matters."""
MOST_CELLS = 3e6
"""Cells of an inflated bag that take hours."""

SHARED = Concern.declare(
    "W-GAS-020",
    "{share:.0f} % of the fabric lies in cells that hold more than two layers of a chamber, or of a strip of it",
    where="gas.cell; the start shape",
    why="gas in a cell is one: it goes from layer to layer of a fold at once, where in a bag it goes around the fold",
    cause="a folded bag, or cells much larger than its folds",
    remedy="reduce gas.cell, or take gas.model = corpuscular for what happens before the folds open",
)
UNPARTED = Concern.declare(
    "W-GAS-140",
    "the gas does not see {what}",
    where="bag.folds; gas.model",
    why="gas in a cell is one, unless fold lines with a row of nodes in either panel part the bag into strips",
    cause="a hole on a fold line",
    remedy="move the line or the hole, or take gas.model = corpuscular",
)
FEW_CELLS = Concern.declare(
    "W-GAS-021",
    "only {count:.0f} cells across the bag",
    where="gas.cell",
    why="jets and waves are smeared over much of the bag; its pressure is that of a gas which is nearly uniform",
    remedy="reduce gas.cell to a thirtieth of the bag, or take gas.model = uniform-pressure",
)
MANY_CELLS = Concern.declare(
    "W-GAS-022",
    "the mesh of the gas will have about {count:.3g} cells",
    where="gas.cell",
    why="each costs about a microsecond a step, and there are thousands of steps",
    cause="a cell in another unit, or much finer than the fabric",
    remedy='write a unit, gas.cell = "15 mm", or raise it',
)


def crowded(cuts: Iterable[CutCells]) -> float:
    """Share of the fabric [-] in cells that hold more than two panels of a room; cuts: the cells of each room."""
    shared, whole = 0.0, 0.0
    for cut in cuts:
        area = np.linalg.norm(cut.fragments.rows[:, NORMAL : NORMAL + 3], axis=1)
        in_cell = np.bincount(cut.cell, area, len(cut.key))
        shared += float(in_cell[in_cell > LAYERS].sum())
        whole += float(in_cell.sum())
    return shared / whole


def mesh_concerns(
    cell: float, cuts: tuple[CutCells, ...], strips: Strips | None, setting: Setting
) -> Iterator[Concern]:
    """cell: its edge [m]. cuts: the cells of each room at the start."""
    for what in strips.missing if strips is not None else ():
        yield UNPARTED(what=what)
    share = crowded(cuts)
    if share > MANY:
        yield SHARED(share=100.0 * share)
    if setting.across < FEWEST * cell:
        yield FEW_CELLS(count=setting.across / cell)
    if setting.inflated_volume > MOST_CELLS * cell**3:
        yield MANY_CELLS(count=setting.inflated_volume / cell**3)
