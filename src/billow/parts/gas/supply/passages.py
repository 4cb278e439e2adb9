"""Passages: every way for gas to leave a chamber, to the surroundings or to another chamber, in one flat table.

A vent, a porous part of the fabric, an opening between chambers and an orifice without geometry differ only in their
law of flow, in the area it acts on and in when they are open. The effective area of a passage is

    coefficient * f1(t) * f2(t) * f3(p) * (X0 A0 + X1 A + (p_up/p_down) (X2 A0 + X3 A)) * (1 - b + b through_blocked)

with A0 its flat and A its present area, b the blocked share of it, and (X0, X1, X2, X3) the terms of Anagonye and Wang
(LS-DYNA keyword manual II, MAT_FABRIC, X0 to X3): (1, 0, 0, 0) is the flat area, (0, 1, 0, 0) the present one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.geometry.chambers import OUTSIDE
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.supply.curve import NO_CURVE, Curve, CurveTable

VENT, FABRIC, OPENING = range(3)
"""What a passage is, for the histories: a hole to the surroundings, porous fabric, a hole between two chambers."""

ABSOLUTE, DIFFERENCE = range(2)
"""Which pressure a passage's curve is read at: the absolute one upstream, or behind minus ahead."""

FLAT_AREA, PRESENT_AREA = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)

KIND, LAW, BEHIND, AHEAD, FIRST_CURVE, SECOND_CURVE, PRESSURE_CURVE, PRESSURE_READ = range(8)
"""Columns of `Passages.plan`."""

COEFFICIENT, AREA, X0, X1, X2, X3, THROUGH_BLOCKED, OPENS_AT, BURSTS_AT = range(9)
"""Columns of `Passages.numbers`."""


@dataclass(frozen=True)
class Passage:
    """One way out of a chamber.

    kind: VENT, FABRIC or OPENING. law: one of outflow.py. behind, ahead: index of the chambers it joins, or
    OUTSIDE; flow from behind to ahead counts as positive. triangles: (n,) int64 that make it up; none for an orifice
    without geometry. area: flat area [m^2]. coefficient: in the unit of the law. over_time: up to two factors against
    time [s]. over_pressure: factor against pressure [Pa], read as `pressure_read`. area_terms: X0 to X3.
    through_blocked: share of the flow that remains where contact blocks it; 1 if contact blocks nothing. opens_at:
    pressure behind minus ahead [Pa], and bursts_at: time [s], from which on it is open for good, whichever comes first.
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
        """Whether its present or its blocked area has to be known in every step."""
        needed = self.area_terms[1] != 0.0 or self.area_terms[3] != 0.0 or self.through_blocked < 1.0
        return needed and len(self.triangles) > 0


@dataclass(frozen=True)
class Passages:
    """All passages of a bag, and the arrays that kernels read."""

    rows: tuple[Passage, ...] = ()

    @cached_property
    def plan(self) -> np.ndarray:
        """(passages, 8) int64, columns KIND to PRESSURE_READ."""
        plan = np.full((len(self.rows), 8), NO_CURVE, np.int64)
        curves = 0
        for line, row in zip(plan, self.rows, strict=True):
            line[:4] = row.kind, row.law, row.behind, row.ahead
            for column, _ in self._curves_of(row):
                line[column] = curves
                curves += 1
            line[PRESSURE_READ] = row.pressure_read
        return plan

    @cached_property
    def numbers(self) -> np.ndarray:
        """(passages, 9), columns COEFFICIENT to BURSTS_AT."""
        numbers = [
            (r.coefficient, r.area, *r.area_terms, r.through_blocked, r.opens_at, r.bursts_at) for r in self.rows
        ]
        return np.array(numbers, dtype=np.float64).reshape(-1, 9)

    @cached_property
    def curves(self) -> CurveTable:
        return CurveTable.build([curve for row in self.rows for _, curve in self._curves_of(row)])

    @staticmethod
    def _curves_of(row: Passage) -> list[tuple[int, Curve]]:
        found = list(zip((FIRST_CURVE, SECOND_CURVE), row.over_time, strict=False))
        return found + ([(PRESSURE_CURVE, row.over_pressure)] if row.over_pressure is not None else [])

    @cached_property
    def members(self) -> np.ndarray:
        """Triangles (n,) int64 of all measured passages, one passage after the other."""
        return np.concatenate([np.empty(0, np.int64), *(row.triangles for row in self.rows if row.measured)])

    @cached_property
    def first_chunk(self) -> np.ndarray:
        """(passages + 1,) int64: passage k is made of chunks first_chunk[k] to first_chunk[k + 1]."""
        counts = [-(-len(row.triangles) // CHUNK) if row.measured else 0 for row in self.rows]
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)

    @cached_property
    def chunk_start(self) -> np.ndarray:
        """(chunks + 1,) int64: where each chunk begins in `members`; no chunk belongs to two passages."""
        starts, begin = [], 0
        for row in self.rows:
            if row.measured:
                starts += range(begin, begin + len(row.triangles), CHUNK)
                begin += len(row.triangles)
        return np.array([*starts, begin], dtype=np.int64)

    def measure(self, triangles: np.ndarray, positions: np.ndarray, touched: np.ndarray | None) -> np.ndarray:
        """Present and blocked area [m^2] of each chunk, (chunks, 2).

        positions: [m], (nodes, 3). touched: (nodes,) bool, nodes in contact; each blocks a third of its triangles.
        """
        areas = np.empty((len(self.chunk_start) - 1, 2))
        if len(areas):
            nothing = np.zeros(len(positions), np.bool_) if touched is None else touched
            _measure(len(self.members), triangles, self.members, self.chunk_start, positions, nothing, areas)
        return areas


NO_PASSAGES = Passages()


@kernel
def _measure(n, triangles, members, chunk_start, positions, touched, areas_out):
    for chunk in prange(len(chunk_start) - 1):
        present, blocked = 0.0, 0.0
        for m in range(chunk_start[chunk], chunk_start[chunk + 1]):
            i = members[m]
            a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
            nx, ny, nz = double_area_vector(positions, a, b, c)
            area = 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
            present += area
            blocked += area * (1.0 * touched[a] + touched[b] + touched[c]) / 3.0
        areas_out[chunk, 0] = present
        areas_out[chunk, 1] = blocked
