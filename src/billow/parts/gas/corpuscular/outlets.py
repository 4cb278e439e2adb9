"""Outlets: how likely a particle is to pass a vent or porous fabric, so that the mass flow is that of the law.

A hole that lets every particle pass would lose gas like a vacuum: nothing comes back from outside. The mass flow of
each passage is therefore the one its law gives for the gas beside it (supply/passages.py, the same objects as for
uniform pressure), and a particle that strikes it passes with probability

    P = min(1, (flow + short / window) / incident mass flow),

with what struck the passage lately, within the window, and what it is short of. That keeps the sum of what leaves at
that of the law: the mean of 1/incident is more than 1/mean, by 1/hits. The gas before it is that of the chamber. Where
a jet presses on the fabric around a vent, by more than the noise of so many hits, its pressure counts instead: that on
the vent itself would not do, because gas that streams out strikes it harder the more it streams, and so would drive
itself.

At most everything passes that strikes a hole. From gas at rest that is p/sqrt(2 pi R T), 0.583 of what a choked hole of
discharge coefficient 1 lets out (air). Real gas streams towards the hole from a few diameters away; particles do so as
far as their mean free path is smaller than the hole. What is still missing is taken from the particles nearest to it.

Molecules that strike a hole have less energy than the enthalpy that outflow takes along, by k T/2 if the gas is at rest
and the less the faster it streams.

Of fabric between two chambers gas strikes both sides; the net flow is then
P (incident from behind - incident from ahead), so P = flow / (incident upstream (1 - p_down/p_up)). An opening is a
hole: whatever reaches it passes. Where the surroundings have the higher pressure, air is drawn in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.mixture import mixture_gamma, mixture_gas_constant
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import OPENING, VENT, Passages, effective_area

NO_PASSAGE = -1

HITS_NOISE = 1.13
"""Relative noise of a pressure from one hit."""

CERTAIN = 5.0
"""Standard deviations above a chamber's pressure at which a vent feels a jet."""


@dataclass(frozen=True)
class Outlets:
    """Passages as particles meet them. passage: (triangles,) int32, whose each triangle is, or NO_PASSAGE. around: of
    each passage, the triangles (n,) int64 that touch it, if it is a vent."""

    table: np.ndarray
    passages: Passages
    ambient: Ambient
    passage: np.ndarray
    around: tuple[np.ndarray, ...]

    @classmethod
    def build(cls, table: np.ndarray, passages: Passages, ambient: Ambient, triangles: np.ndarray) -> Outlets:
        """triangles: of the bag, (n, 3)."""
        passage, around = np.full(len(triangles), NO_PASSAGE, np.int32), []
        for k, row in enumerate(passages.rows):
            passage[row.triangles] = k
            touching = np.isin(triangles, triangles[row.triangles]).any(axis=1) & (row.kind == VENT)
            touching[row.triangles] = False
            around.append(np.flatnonzero(touching))
        return cls(table, passages, ambient, passage, tuple(around))

    def regulate(
        self, pass_probability: np.ndarray, is_open: np.ndarray, short: np.ndarray, areas: np.ndarray,
        triangle_area: np.ndarray,
        wall_pressure: np.ndarray, mass_flux: np.ndarray, chamber_pressure: np.ndarray, masses: np.ndarray,
        temperature: np.ndarray, particle_mass: np.ndarray, window: float, time: float, dt: float,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
        """Set pass_probability (triangles,) for the coming step; opens passages in is_open (passages,).

        short: of what the law let out up to now, the mass that has not left yet [kg], or less than none if too much has
        (passages,). areas: Passages.measure. triangle_area [m^2] (triangles,). wall_pressure [Pa] and mass_flux
        [kg/m^2/s], (triangles, 2): smoothed, of the gas behind and ahead, over a window [s]. Of the chambers: pressure
        [Pa], temperature [K], mean mass of a particle [kg] (chambers,), masses [kg] (chambers, species).

        Returns mass [kg] to be drawn in, blocked area [m^2] and mass flow to the surroundings [kg/s], all (passages,).
        """
        passages, ambient = self.passages, self.ambient
        first_chunk = passages.table.first_chunk
        drawn, blocked_area, wanted = np.zeros((3, len(passages.rows)))
        for k, row in enumerate(passages.rows):
            if row.coefficient == 0.0:  # tight
                continue
            present, blocked = areas[first_chunk[k] : first_chunk[k + 1]].sum(axis=0)
            blocked_area[k] = blocked if row.through_blocked < 1.0 else 0.0
            struck = triangle_area[row.triangles]
            behind = ahead = ambient.pressure
            if row.behind != OUTSIDE:
                behind = chamber_pressure[row.behind]
                near = self.around[k]
                hits = window * float(triangle_area[near] @ mass_flux[near, 0]) / particle_mass[row.behind]
                if hits > 1.0:
                    felt = float(triangle_area[near] @ wall_pressure[near, 0]) / float(triangle_area[near].sum())
                    if felt > behind * (1.0 + CERTAIN * HITS_NOISE / np.sqrt(hits)):
                        behind = felt
            if row.ahead != OUTSIDE:
                ahead = chamber_pressure[row.ahead]
            lead = behind - ahead
            if lead >= row.opens_at or time + dt >= row.bursts_at:
                is_open[k] = True
            if not is_open[k]:
                pass_probability[row.triangles] = 0.0
                continue
            if row.kind == OPENING:
                pass_probability[row.triangles] = 1.0
                continue
            up, upstream, downstream = (row.behind, behind, ahead) if lead >= 0.0 else (row.ahead, ahead, behind)
            gamma, rt = self._upstream_gas(up, masses, temperature)
            area = effective_area(passages.table, k, present, blocked, time, behind, ahead)
            flow = area * conductance(row.law, upstream, downstream, gamma, rt) * (upstream - downstream)
            if up == OUTSIDE:
                pass_probability[row.triangles] = 0.0
                drawn[k] = flow * dt
                continue
            incident = float(struck @ mass_flux[row.triangles, 0 if lead >= 0.0 else 1])
            if row.behind != OUTSIDE and row.ahead != OUTSIDE:
                incident *= max(1.0 - downstream / upstream, 1e-6)
            if OUTSIDE in (row.behind, row.ahead):
                wanted[k] = flow
                flow = max(0.0, flow + short[k] / window)
            pass_probability[row.triangles] = min(1.0, flow / incident) if incident > 0.0 else 0.0
        return drawn, blocked_area, wanted

    def missing_heat(
        self, triangle_area: np.ndarray, wall_pressure: np.ndarray, mass_flux: np.ndarray, masses: np.ndarray,
        temperature: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """What a molecule that leaves has less than outflow takes along, in k T of its chamber, (passages,).

        Arguments as `regulate`.
        """
        missing = np.full(len(self.passages.rows), 0.5)
        for k, row in enumerate(self.passages.rows):
            home, side = (row.behind, 0) if row.behind != OUTSIDE else (row.ahead, 1)
            area = triangle_area[row.triangles]
            flux = float(area @ mass_flux[row.triangles, side])
            if flux > 0.0 and masses[home].any():
                push = 0.5 * float(area @ wall_pressure[row.triangles, side])
                missing[k] = _missing_at(push / flux / math.sqrt(self._upstream_gas(home, masses, temperature)[1]))
        return missing

    def _upstream_gas(self, chamber: int, masses: np.ndarray, temperature: np.ndarray) -> tuple[float, float]:
        """cp/cv [-] and R T [J/kg] of a chamber's gas, or of the air outside."""
        if chamber == OUTSIDE:
            fractions, t = self.ambient.mass_fractions, self.ambient.temperature
        else:
            fractions, t = masses[chamber] / masses[chamber].sum(), temperature[chamber]
        return mixture_gamma(self.table, fractions, t), mixture_gas_constant(self.table, fractions) * t


def _missing_at(speed: float) -> float:
    """Missing heat [k T] of a gas whose molecules strike a hole at this mean speed along its normal, over sqrt(R T).

    With phi and Phi the normal density and distribution, gas that drifts at s sqrt(R T) strikes with the moments of v
    over v > 0, m1 = s Phi + phi, m2 = (s^2 + 1) Phi + s phi, m3 = (s^3 + 3 s) Phi + (s^2 + 2) phi (Bird, Molecular Gas
    Dynamics, 1994, section 4.2). Their mean speed is m2/m1, their energy m3/(2 m1) + 1 k T and the store; outflow takes
    5/2 + s^2/2 and the store.
    """
    low, high = 0.0, 10.0
    for _ in range(40):
        drift = 0.5 * (low + high)
        density = math.exp(-0.5 * drift * drift) / math.sqrt(2.0 * math.pi)
        below = 0.5 * math.erfc(-drift / math.sqrt(2.0))
        first = drift * below + density
        second = (drift * drift + 1.0) * below + drift * density
        if second < speed * first:
            low = drift
        else:
            high = drift
    third = (drift**3 + 3.0 * drift) * below + (drift * drift + 2.0) * density
    return 1.5 + 0.5 * drift * drift - 0.5 * third / first
