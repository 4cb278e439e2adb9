"""Passages: every way for gas to leave a chamber, to the surroundings or to another chamber, in one flat table.

The effective area of a passage is

    coefficient * f1(t) * f2(t) * f3(p) * (X0 A0 + X1 A + (p_up/p_down) (X2 A0 + X3 A)) * (1 - b + b through_blocked)

where A0 is its flat area, A its present area, b the blocked share of it, and X0 to X3 are the terms of Anagonye and
Wang (docs/theory.md, Vents, leakage and openings).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.geometry.chambers import OUTSIDE
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.supply.curve import NO_CURVE, Curve, CurveTable, curve_value
from billow.parts.gas.supply.outflow import conductance

VENT, FABRIC, OPENING = range(3)
"""Kinds of passages: a hole to the surroundings, porous fabric, a hole between two chambers."""

ABSOLUTE, DIFFERENCE = range(2)
"""Pressure at which a passage's curve is read: the absolute one upstream, or the difference behind minus ahead."""

FLAT_AREA, PRESENT_AREA = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)

KIND, LAW, BEHIND, AHEAD, FIRST_CURVE, SECOND_CURVE, PRESSURE_CURVE, PRESSURE_READ = range(8)
"""Columns of `PassageTable.plan`."""

COEFFICIENT, AREA, X0, X1, X2, X3, THROUGH_BLOCKED, OPENS_AT, BURSTS_AT = range(9)
"""Columns of `PassageTable.numbers`."""


@dataclass(frozen=True)
class Passage:
    """One way out of a chamber.

    kind: VENT, FABRIC or OPENING. law: one of outflow.py. behind, ahead: indices of the chambers it joins, or OUTSIDE;
    flow from behind to ahead is positive. triangles: (n,) int64 that make it up; none for an orifice without geometry.
    area: flat area [m^2]. coefficient: in the unit of the law. over_time: up to two factors against time [s].
    over_pressure: factor against pressure [Pa], read as `pressure_read`. area_terms: X0 to X3. through_blocked: share
    of the flow that remains where contact blocks the passage; 1 if contact has no effect. opens_at: pressure
    difference behind minus ahead [Pa], and bursts_at: time [s]; once either is reached the passage stays open.
    """

    name: str
    kind: int
    law: int
    behind: int
    ahead: int = OUTSIDE
    triangles: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    area: float = 0.0
    coefficient: float = 1.0
    over_time: tuple[Curve, ...] = ()
    over_pressure: Curve | None = None
    pressure_read: int = ABSOLUTE
    area_terms: tuple[float, float, float, float] = FLAT_AREA
    through_blocked: float = 1.0
    opens_at: float = -np.inf
    bursts_at: float = np.inf

    @property
    def measured(self) -> bool:
        """Whether its present or its blocked area is needed in every step."""
        needed = self.area_terms[1] != 0.0 or self.area_terms[3] != 0.0 or self.through_blocked < 1.0
        return needed and len(self.triangles) > 0


class PassageTable(NamedTuple):
    """Passages as kernels take them.

    plan: (passages, 8) int64, columns KIND to PRESSURE_READ. numbers: (passages, 9), columns COEFFICIENT to BURSTS_AT.
    curves: all their curves. first_chunk: (passages + 1,) int64; the areas of passage k are chunks first_chunk[k] to
    first_chunk[k + 1] of `Passages.measure`.
    """

    plan: np.ndarray
    numbers: np.ndarray
    curves: CurveTable
    first_chunk: np.ndarray


@dataclass(frozen=True)
class Passages:
    """All passages of a bag."""

    rows: tuple[Passage, ...] = ()

    @cached_property
    def table(self) -> PassageTable:
        plan = np.full((len(self.rows), 8), NO_CURVE, np.int64)
        numbers, curves = np.empty((len(self.rows), 9)), []
        for r, integers, floats in zip(self.rows, plan, numbers, strict=True):
            integers[:4] = r.kind, r.law, r.behind, r.ahead
            integers[PRESSURE_READ] = r.pressure_read
            floats[:] = r.coefficient, r.area, *r.area_terms, r.through_blocked, r.opens_at, r.bursts_at
            for column, curve in zip((FIRST_CURVE, SECOND_CURVE), r.over_time, strict=False):
                integers[column] = len(curves)
                curves.append(curve)
            if r.over_pressure is not None:
                integers[PRESSURE_CURVE] = len(curves)
                curves.append(r.over_pressure)
        chunks = [-(-len(row.triangles) // CHUNK) if row.measured else 0 for row in self.rows]
        return PassageTable(plan, numbers, CurveTable.build(curves), np.cumsum([0, *chunks]).astype(np.int64))

    @cached_property
    def members(self) -> np.ndarray:
        """Triangles (n,) int64 of all measured passages, one passage after the other."""
        return np.concatenate([np.empty(0, np.int64), *(row.triangles for row in self.rows if row.measured)])

    @cached_property
    def chunk_start(self) -> np.ndarray:
        """(chunks + 1,) int64: where each chunk begins in `members`. No chunk belongs to two passages."""
        starts, begin = [], 0
        for row in self.rows:
            if row.measured:
                starts += range(begin, begin + len(row.triangles), CHUNK)
                begin += len(row.triangles)
        return np.array([*starts, begin], dtype=np.int64)

    def measure(self, triangles: np.ndarray, positions: np.ndarray, touched: np.ndarray | None) -> np.ndarray:
        """Present and blocked area [m^2] of each chunk, (chunks, 2).

        positions: [m], (nodes, 3). touched: (shapes, nodes) bool, nodes in contact with a shape; each blocks a third of
        its triangles. None if nothing can be touched.
        """
        areas = np.empty((len(self.chunk_start) - 1, 2))
        if len(areas):
            by = np.zeros((0, len(positions)), np.bool_) if touched is None else touched
            _measure(len(self.members), triangles, self.members, self.chunk_start, positions, by, areas)
        return areas

    def outflow(self, kind: int, time: float, inside: float, outside: float, rt: float, gamma: float = 1.3) -> float:
        """Mass flow [kg/s] to the surroundings through all open passages of a kind, at their flat areas.

        inside, outside: pressures [Pa]; rt: R T of the gas inside [J/kg]; gamma: its cp/cv [-].
        """
        total = 0.0
        for k, row in enumerate(self.rows):
            if row.kind == kind and row.ahead == OUTSIDE:
                area = effective_area(self.table, k, row.area, 0.0, time, inside, outside)
                total += area * conductance(row.law, inside, outside, gamma, rt) * (inside - outside)
        return total


NO_PASSAGES = Passages()


@scalar
def effective_area(passages, k, present, blocked, time, behind, ahead):
    """Area [m^2] of passage k of a PassageTable times its coefficient, by the formula at the top of this file.

    present, blocked: its present area and the blocked part of it [m^2]. behind, ahead: pressures [Pa]. time: [s].
    """
    plan, numbers, curves = passages.plan, passages.numbers, passages.curves
    upstream, downstream = (behind, ahead) if behind >= ahead else (ahead, behind)
    ratio = upstream / downstream
    flat = numbers[k, AREA]
    area = numbers[k, X0] * flat + numbers[k, X1] * present
    area += ratio * (numbers[k, X2] * flat + numbers[k, X3] * present)
    if present > 0.0:
        area *= 1.0 - blocked / present * (1.0 - numbers[k, THROUGH_BLOCKED])
    factor = numbers[k, COEFFICIENT]
    factor *= curve_value(curves, plan[k, FIRST_CURVE], time)
    factor *= curve_value(curves, plan[k, SECOND_CURVE], time)
    at = upstream if plan[k, PRESSURE_READ] == ABSOLUTE else behind - ahead
    return max(area, 0.0) * factor * curve_value(curves, plan[k, PRESSURE_CURVE], at)


@kernel
def _measure(n, triangles, members, chunk_start, positions, touched, areas_out):
    for chunk in prange(len(chunk_start) - 1):
        present, blocked = 0.0, 0.0
        for m in range(chunk_start[chunk], chunk_start[chunk + 1]):
            i = members[m]
            a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
            nx, ny, nz = double_area_vector(positions, a, b, c)
            area = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz)
            present += area
            corners = 0.0
            for k in (a, b, c):
                for shape in range(len(touched)):
                    if touched[shape, k]:
                        corners += 1.0
                        break
            blocked += area * corners / 3.0
        areas_out[chunk, 0] = present
        areas_out[chunk, 1] = blocked
