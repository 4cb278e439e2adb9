"""Outlets: how likely a particle is to pass a vent or porous fabric, so that the mass flow is that of the law.

A hole that lets every particle pass would lose gas like a vacuum: nothing comes back from outside. The mass flow of
each passage is therefore the one its law gives for the gas beside it (billow.gas.passages, the same objects as for
uniform pressure), and a particle that strikes it passes with probability

    P = min(1, flow / incident mass flow),

both from what struck the passage lately. Of fabric between two chambers gas strikes both sides; the net flow is then
P (incident from behind - incident from ahead), so P = flow / (incident upstream (1 - p_down/p_up)). An opening is a
hole: whatever reaches it passes. Where the surroundings have the higher pressure, air is drawn in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.gas.ambient import Ambient
from billow.gas.exchange import effective_area
from billow.gas.mixture import mixture_cp, mixture_gas_constant
from billow.gas.outflow import conductance
from billow.gas.passages import BURSTS_AT, OPENING, OPENS_AT, VENT, Passages
from billow.geometry.chambers import OUTSIDE

NO_PASSAGE = -1


@dataclass(frozen=True)
class Outlets:
    """Passages as particles meet them. passage: (triangles,) int32, whose each triangle is, or NO_PASSAGE."""

    table: np.ndarray
    passages: Passages
    ambient: Ambient
    passage: np.ndarray

    @classmethod
    def build(cls, table: np.ndarray, passages: Passages, ambient: Ambient, triangles: int) -> Outlets:
        passage = np.full(triangles, NO_PASSAGE, np.int32)
        for k, row in enumerate(passages.rows):
            passage[row.triangles] = k
        return cls(table, passages, ambient, passage)

    def regulate(
        self, pass_probability: np.ndarray, is_open: np.ndarray, areas: np.ndarray, triangle_area: np.ndarray,
        wall_pressure: np.ndarray, mass_flux: np.ndarray, chamber_pressure: np.ndarray, masses: np.ndarray,
        temperature: np.ndarray, time: float, dt: float,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Set pass_probability (triangles,) for the coming step; opens passages in is_open (passages,).

        areas: Passages.measure. triangle_area [m^2] (triangles,). wall_pressure [Pa] and mass_flux [kg/m^2/s],
        (triangles, 2): smoothed, of the gas behind and ahead. Of the chambers: pressure [Pa], temperature [K]
        (chambers,), masses [kg] (chambers, species). Returns mass [kg] to be drawn in and blocked area [m^2], both
        (passages,).
        """
        passages, ambient = self.passages, self.ambient
        plan, numbers, curves = passages.plan, passages.numbers, passages.curves
        drawn, blocked_area = np.zeros(len(plan)), np.zeros(len(plan))
        for k, row in enumerate(passages.rows):
            if row.coefficient == 0.0:  # tight
                continue
            present, blocked = areas[passages.first_chunk[k] : passages.first_chunk[k + 1]].sum(axis=0)
            blocked_area[k] = blocked if row.through_blocked < 1.0 else 0.0
            struck = triangle_area[row.triangles]
            behind = ahead = ambient.pressure
            if row.behind != OUTSIDE:
                behind = chamber_pressure[row.behind]
                if row.kind == VENT:  # a jet that blows into a vent is felt there
                    behind = float(struck @ wall_pressure[row.triangles, 0] / max(struck.sum(), 1e-300))
            if row.ahead != OUTSIDE:
                ahead = chamber_pressure[row.ahead]
            lead = behind - ahead
            if lead >= numbers[k, OPENS_AT] or time + dt >= numbers[k, BURSTS_AT]:
                is_open[k] = True
            if not is_open[k]:
                pass_probability[row.triangles] = 0.0
                continue
            if row.kind == OPENING:
                pass_probability[row.triangles] = 1.0
                continue
            up, upstream, downstream = (row.behind, behind, ahead) if lead >= 0.0 else (row.ahead, ahead, behind)
            gamma, rt = self._upstream_gas(up, masses, temperature)
            area = effective_area(
                plan[k], numbers[k], curves.start, curves.x, curves.y, present, blocked, time, upstream, downstream,
                lead,
            )  # fmt: skip
            flow = area * conductance(row.law, upstream, downstream, gamma, rt) * (upstream - downstream)
            if up == OUTSIDE:
                pass_probability[row.triangles] = 0.0
                drawn[k] = flow * dt
                continue
            incident = float(struck @ mass_flux[row.triangles, 0 if lead >= 0.0 else 1])
            if row.behind != OUTSIDE and row.ahead != OUTSIDE:
                incident *= max(1.0 - downstream / upstream, 1e-6)
            pass_probability[row.triangles] = min(1.0, flow / incident) if incident > 0.0 else 0.0
        return drawn, blocked_area

    def _upstream_gas(self, chamber: int, masses: np.ndarray, temperature: np.ndarray) -> tuple[float, float]:
        """cp/cv [-] and R T [J/kg] of a chamber's gas, or of the air outside."""
        if chamber == OUTSIDE:
            fractions, t = self.ambient.mass_fractions, self.ambient.temperature
        else:
            fractions, t = masses[chamber] / masses[chamber].sum(), temperature[chamber]
        constant, cp = mixture_gas_constant(self.table, fractions), mixture_cp(self.table, fractions, t)
        return cp / (cp - constant), constant * t
