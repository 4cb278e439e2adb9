"""Whether a folded start is fit to run: one line for each thing that could be wrong with it (docs/folding.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.schema import Case
from billow.geometry.bag_shapes import BagShape
from billow.geometry.crossings import CrossingCount
from billow.geometry.folding.fold_measures import least_distance, shears, yarn_strains
from billow.geometry.folding.fold_plan import FoldPlan, panel_side
from billow.geometry.surface import check_closed
from billow.parts.fabric.birth import strain_energy
from billow.parts.gas.supply.mixture import mixture_gas_constant
from billow.solver.model import Model, start_state

EXACT = 1e-12
"""Distance [m] up to which two places are one: rounding of positions of a metre is a ten-thousandth of it."""
ROW = 1e-9
"""Distance [m] from a fold line up to which a node lies on it."""
CLOSE = 0.9
"""Share of the fabric's thickness that layers may come close to each other."""
EXACT_MAP, MOST, WORST = 0.002, 0.01, 0.02
"""Strain [-] of 99.9 % of the yarns' edges, where the map keeps lengths and elsewhere, and of the worst."""
MOST_SHEAR = math.radians(15.0)
LITTLE = 1e-3
"""Share of the energy of the gas that the start may hold as strain."""


@dataclass(frozen=True)
class Check:
    """One line of the table: measured in `unit`; limit: greatest value that passes, or least if `at_least`."""

    name: str
    measured: float
    limit: float
    unit: str
    at_least: bool = False

    @property
    def passed(self) -> bool:
        return self.measured >= self.limit if self.at_least else self.measured <= self.limit

    def record(self) -> dict:
        """Plain dictionary, for fold.json."""
        return {
            "name": self.name, "measured": self.measured, "limit": self.limit if math.isfinite(self.limit) else None,
            "unit": self.unit, "verdict": "PASS" if self.passed else "FAIL",
        }  # fmt: skip


def fold_checks(case: Case, model: Model) -> list[Check]:
    """The table of a folded case. Raises InputError E-GEO-001.. as `check_closed` for a bag that is not closed."""
    plan, shape = fold_plan(case.bag), build_shape(case.bag)
    check_closed(shape.surface, shape.positions, "bag")
    flat, start = plan.unfolded(shape.positions), replace(shape, positions=model.start)
    thickness, gap = max(m.fabric.thickness for m in model.fabric.membranes), 2.0 * plan.half
    near = least_distance(model.start, flat, panel_side(shape, flat), case.bag.element_size, 1.5 * gap)
    angles = {side: math.radians(getattr(case.bag.warp_angle, side)) for side in ("front", "rear")}
    strains = yarn_strains(start, angles)
    most, worst, most_shear = EXACT_MAP if plan.keeps_lengths else MOST, WORST, MOST_SHEAR
    if case.bag.birth_time:  # the flat cut comes in slowly: what is strained now is released by then
        most = worst = most_shear = math.inf
    return [
        Check("creases without one row of nodes in both panels", _without_row(plan, flat, shape), 0.0, ""),
        Check("crossings of fabric through fabric", CrossingCount(shape.surface).total(model.start), 0.0, ""),
        Check("least distance of layers", 1e3 * near, 1e3 * CLOSE * thickness, "mm", at_least=True),
        Check("strain of yarns, 99.9 % of them up to", 100.0 * np.quantile(strains, 0.999), 100.0 * most, "%"),
        Check("strain of yarns, greatest", 100.0 * strains.max(), 100.0 * worst, "%"),
        Check("shear, greatest", math.degrees(shears(start).max()), math.degrees(most_shear), "deg"),
        Check("edges of the unfolded bag off the cut", _off_the_cut(shape, flat), EXACT, "m"),
        Check("folded again off the start", float(np.abs(plan.folded(flat) - shape.positions).max()), EXACT, "m"),
        Check("volume", 1e3 * shape.surface.volume(model.start), 1e-6, "l", at_least=True),
        *_energy(model),
    ]


def _without_row(plan: FoldPlan, flat: np.ndarray, shape: BagShape) -> float:
    """How many creases have no row of nodes, or another one in the front panel than in the rear one; vents that the
    line goes through aside."""
    side = panel_side(shape, flat)
    missing = 0
    for axis in (0, 1):
        for row in plan.rows(axis):
            on_row = np.abs(flat[:, axis] - row.place) < ROW
            for low, high in plan.vents_on(shape.surface, flat, axis, row.place).values():
                on_row &= (flat[:, 1 - axis] < low) | (flat[:, 1 - axis] > high)
            front, rear = (np.sort(flat[on_row & (side == s), 1 - axis]) for s in (1, -1))
            missing += len(front) == 0 or len(front) != len(rear) or np.abs(front - rear).max() > EXACT
    return float(missing)


def _off_the_cut(shape: BagShape, flat: np.ndarray) -> float:
    """Greatest difference of an edge's length on the unfolded bag and as cut [m]."""
    cloth = shape.surface.triangles_of_kind("fabric")
    corners, cut = flat[shape.surface.triangles[cloth]][:, :, :2], shape.reference[cloth]
    lengths = [np.linalg.norm(c - np.roll(c, 1, axis=1), axis=2) for c in (corners, cut)]
    return float(np.abs(lengths[0] - lengths[1]).max())


def _energy(model: Model) -> list[Check]:
    """Strain energy at the start against m R T of the gas, which it is small of its enthalpy."""
    if model.gas.supply is None:
        return []
    supply, fabric = model.gas.supply, model.fabric
    gas = sum(
        i.cumulative[-1] * mixture_gas_constant(supply.table, i.mass_fractions) * float(i.temperature.max())
        for i in supply.inflators
    )
    membranes = fabric.birth.membranes(fabric.membranes, 0.0) if fabric.birth else fabric.membranes
    held = strain_energy(membranes, model.surface.triangles, model.start, start_state(model).fabric.history)
    return [Check("strain energy at the start", held, LITTLE * gas, "J")]
