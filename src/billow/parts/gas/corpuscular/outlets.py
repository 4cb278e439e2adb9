"""Outlets: how likely a particle is to pass a vent or porous fabric, and the particles that leave the bag
(docs/theory.md, Outlets, inflow and returned energy)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.flight import Flock
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.mixture import mixture_gamma, mixture_gas_constant, species_enthalpy
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import OPENING, VENT, effective_area
from billow.parts.gas.supply.supply import Supply

NO_PASSAGE = -1

HITS_NOISE = 1.13
"""Relative noise of a pressure from one hit."""

LARGEST_PULL = 0.02
"""Share of a chamber's particles that a vent may take in a gas step, besides those that strike it."""

CERTAIN = 5.0
"""Standard deviations above a chamber's pressure at which a vent feels a jet."""


@dataclass(frozen=True)
class Outlets:
    """Passages as particles meet them. passage: (triangles,) int32, the passage each triangle belongs to, or
    NO_PASSAGE. around: of each vent, the triangles (n,) int64 that touch it; none for other passages."""

    supply: Supply
    passage: np.ndarray
    around: tuple[np.ndarray, ...]

    @classmethod
    def build(cls, supply: Supply, triangles: np.ndarray) -> Outlets:
        """triangles: of the bag, (n, 3)."""
        passage, around = np.full(len(triangles), NO_PASSAGE, np.int32), []
        for k, row in enumerate(supply.passages.rows):
            passage[row.triangles] = k
            touching = np.isin(triangles, triangles[row.triangles]).any(axis=1) & (row.kind == VENT)
            touching[row.triangles] = False
            around.append(np.flatnonzero(touching))
        return cls(supply, passage, tuple(around))

    def regulate(
        self, gas: CorpuscularState, areas: np.ndarray, triangle_area: np.ndarray, particle_mass: np.ndarray,
        window: float, dt: float,
    ) -> None:  # fmt: skip
        """Set the state's pass_probability for the next step of about dt [s]; opens passages, owes the air drawn in,
        and notes what is wanted and blocked.

        areas: Passages.measure. triangle_area [m^2] (triangles,). particle_mass: mean of each chamber [kg] (chambers,).
        The bank of the state is smoothed over a window [s].
        """
        passages, ambient = self.supply.passages, self.supply.ambient
        pass_probability, first_chunk = gas.pass_probability, passages.table.first_chunk
        wall_pressure, mass_flux = gas.bank.pressure, gas.bank.mass_flux
        drawn, blocked_area, gas.wanted = np.zeros((3, len(passages.rows)))
        for k, row in enumerate(passages.rows):
            if row.coefficient == 0.0:  # tight
                continue
            present, blocked = areas[first_chunk[k] : first_chunk[k + 1]].sum(axis=0)
            blocked_area[k] = blocked if row.through_blocked < 1.0 else 0.0
            struck = triangle_area[row.triangles]
            behind = ahead = ambient.pressure
            if row.behind != OUTSIDE:
                behind = gas.pressure[row.behind]
                near = self.around[k]
                hits = window * float(triangle_area[near] @ mass_flux[near, 0]) / particle_mass[row.behind]
                if hits > 1.0:
                    felt = float(triangle_area[near] @ wall_pressure[near, 0]) / float(triangle_area[near].sum())
                    if felt > behind * (1.0 + CERTAIN * HITS_NOISE / math.sqrt(hits)):
                        behind = felt
            if row.ahead != OUTSIDE:
                ahead = gas.pressure[row.ahead]
            lead = behind - ahead
            if lead >= row.opens_at or gas.gas_time + dt >= row.bursts_at:
                gas.is_open[k] = True
            if not gas.is_open[k]:
                pass_probability[row.triangles] = 0.0
                continue
            if row.kind == OPENING:
                pass_probability[row.triangles] = 1.0
                continue
            up, upstream, downstream = (row.behind, behind, ahead) if lead >= 0.0 else (row.ahead, ahead, behind)
            gamma, rt = self._upstream_gas(up, gas)
            area = effective_area(passages.table, k, present, blocked, gas.gas_time, behind, ahead)
            flow = area * conductance(row.law, upstream, downstream, gamma, rt) * (upstream - downstream)
            if up == OUTSIDE:
                pass_probability[row.triangles] = 0.0
                drawn[k] = flow * dt
                continue
            incident = float(struck @ mass_flux[row.triangles, 0 if lead >= 0.0 else 1])
            if row.behind != OUTSIDE and row.ahead != OUTSIDE:
                incident *= max(1.0 - downstream / upstream, 1e-6)
            if OUTSIDE in (row.behind, row.ahead):
                gas.wanted[k] = flow
                flow = max(0.0, flow + gas.short[k] / window)
            pass_probability[row.triangles] = min(1.0, flow / incident) if incident > 0.0 else 0.0
        gas.owed += drawn[:, None] * ambient.mass_fractions
        gas.blocked_area = float(blocked_area.sum())

    def missing_heat(self, gas: CorpuscularState, triangle_area: np.ndarray) -> np.ndarray:
        """Energy that a leaving molecule lacks compared with outflow, in k T of its chamber, (passages,)."""
        missing = np.full(len(self.supply.passages.rows), 0.5)
        for k, row in enumerate(self.supply.passages.rows):
            home, side = (row.behind, 0) if row.behind != OUTSIDE else (row.ahead, 1)
            area = triangle_area[row.triangles]
            flux = float(area @ gas.bank.mass_flux[row.triangles, side])
            if flux > 0.0 and gas.masses[home].any():
                push = 0.5 * float(area @ gas.bank.pressure[row.triangles, side])
                missing[k] = _missing_at(push / flux / math.sqrt(self._upstream_gas(home, gas)[1]))
        return missing

    def _upstream_gas(self, chamber: int, gas: CorpuscularState) -> tuple[float, float]:
        """cp/cv [-] and R T [J/kg] of a chamber's gas, or of the air outside."""
        if chamber == OUTSIDE:
            fractions, t = self.supply.ambient.mass_fractions, self.supply.ambient.temperature
        else:
            fractions, t = gas.masses[chamber] / gas.masses[chamber].sum(), gas.temperature[chamber]
        return mixture_gamma(self.supply.table, fractions, t), mixture_gas_constant(self.supply.table, fractions) * t


def _missing_at(speed: float) -> float:
    """Missing energy [k T] of a gas whose molecules strike a hole at this mean normal speed, in units of sqrt(R T).

    From the moments of the molecules that strike it (docs/theory.md, Outlets, inflow and returned energy).
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


def pull_out(
    gas: CorpuscularState, kinds: ParticleKinds, outlets: Outlets, bag: Bag, flock: Flock, span: float
) -> np.ndarray:
    """Compare what has left with what should have; where too few particles strike a vent, let the nearest ones leave.

    Returns which particles those are, (particles,) bool.
    """
    pulled = np.zeros(len(flock.chamber), np.bool_)
    out = np.flatnonzero(flock.chamber == OUTSIDE)
    where, mass = outlets.passage[flock.exit[out]], kinds.mass[flock.species[out]]
    gas.short += gas.wanted * span - np.bincount(where, mass, len(gas.short))
    gas.short[gas.wanted == 0.0] = 0.0
    for k, row in enumerate(outlets.supply.passages.rows):
        if row.kind != VENT or gas.wanted[k] == 0.0 or gas.pass_probability[row.triangles[0]] < 1.0:
            continue
        home = max(row.behind, row.ahead)  # OUTSIDE is -1
        inside = np.flatnonzero(flock.chamber == home)
        mean = kinds.mass[flock.species[inside]].sum() / max(len(inside), 1)
        number = int(min(gas.short[k] / max(mean, 1e-300), LARGEST_PULL * len(inside)))
        if number <= 0:
            continue
        vent = bag.positions[bag.surface.triangles[row.triangles]].mean(axis=(0, 1))
        away = np.sum((flock.position[inside] - vent) ** 2, axis=1)
        nearest = inside[np.sort(np.argpartition(away, number - 1)[:number])]
        flock.chamber[nearest], flock.exit[nearest], pulled[nearest] = OUTSIDE, row.triangles[0], True
        gas.short[k] -= kinds.mass[flock.species[nearest]].sum()
    return pulled


def take_out(
    gas: CorpuscularState, kinds: ParticleKinds, outlets: Outlets, bag: Bag, flock: Flock, pulled: np.ndarray
) -> None:
    """Book and remove the particles that left the bag."""
    out = np.flatnonzero(flock.chamber == OUTSIDE)
    if not len(out):
        return
    where, species = outlets.passage[flock.exit[out]], flock.species[out]
    mass, velocity = kinds.mass[species], flock.velocity[out]
    np.add.at(gas.left, (where, species), mass)
    energy = 0.5 * mass * np.sum(velocity**2, axis=1) + gas.particles.internal_energy[out]
    # Outflow takes its enthalpy along; the gas that stays pays what the particles lack.
    home = np.array([max(row.behind, row.ahead) for row in outlets.supply.passages.rows])[where]  # OUTSIDE is -1
    area = np.linalg.norm(area_vectors(bag.surface.triangles, bag.positions), axis=1)
    missing = outlets.missing_heat(gas, area)[where]
    enthalpy = np.array([[species_enthalpy(row, t) for row in kinds.table] for t in gas.temperature])
    lacks = np.where(pulled[out], mass * enthalpy[home, species] - energy, missing * kinds.heat * gas.temperature[home])
    debt = np.bincount(home, lacks, len(gas.pool))
    gas.pool -= debt
    gas.enthalpy_out += float(energy.sum() + debt.sum())
    gas.impulse -= mass @ velocity
    gas.particles.keep(flock.chamber != OUTSIDE)
