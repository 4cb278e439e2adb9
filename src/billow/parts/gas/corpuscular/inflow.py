"""Particles that come in: newborns from the inflators, and air drawn in through passages."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.corpuscular.drawn_in import draw_in
from billow.parts.gas.corpuscular.injection import Injector, Nozzles
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.random_numbers import stream, uniform
from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.mixture import mixture_enthalpy

FAINTEST = 1e-6
"""Pressure [Pa] a jet blows against, at least: into a vacuum it is choked."""

BIRTH_TIME = 0x4249_5254
"""Names the random numbers that say when in a step a particle is born."""


def coming(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> float:
    """Particles that inflators blow, and passages draw in, up to `time` [s]."""
    return float(((pending(setup, gas, kinds, time) + gas.owed.sum(axis=0)) / kinds.mass).sum())


def pending(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> np.ndarray:
    """Delivered by inflators up to `time` [s], but no particle yet [kg], (species,)."""
    waiting = np.zeros(len(kinds.mass))
    for source, delivery in zip(setup.sources, gas.deliveries, strict=True):
        inflator = source.inflator
        waiting += inflator.delivered(time) * inflator.mass_fractions - delivery.mass(kinds)
    return waiting


def blow(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag, span: float) -> np.ndarray | None:
    """Newborn particles from the inflators; returns at which fraction of the step each particle starts to fly."""
    first = gas.particles.count
    ready = injectors(setup, kinds, gas.positions)
    for source, injector, delivery in zip(setup.sources, ready, gas.deliveries, strict=True):
        mouth, one = source.jets.mouth_nodes, gas.particles.count
        offered = delivery.offered
        start, end = gas.positions[mouth].mean(axis=0), bag.positions[mouth].mean(axis=0)
        birth = injector.blow(
            delivery, gas.particles, gas.gas_time, span, start, (end - start) / span,
            max(float(gas.pressure[source.inflator.chamber]), FAINTEST), 0.0, setup.seed,
        )  # fmt: skip
        gas.enthalpy_in += delivery.offered - offered + birth.carried_energy
        gas.impulse += birth.impulse
        when = _birth_times(gas, one, setup.seed)
        gas.particles.position[one : gas.particles.count] += when[:, None] * (end - start)
    if gas.particles.count == first:
        return None
    return np.concatenate([np.zeros(first), _birth_times(gas, first, setup.seed)])


def injectors(setup: Setup, kinds: ParticleKinds, positions: np.ndarray) -> list[Injector]:
    """Of each source, as its mouth lies now; positions: [m], (nodes, 3)."""
    made = []
    for source in setup.sources:
        holes, frames, (axis, _, _) = source.jets.nozzles(positions)
        ring = source.jets.ring
        centre = positions[source.jets.mouth_nodes].mean(axis=0)
        nozzles = Nozzles(
            holes - centre, frames[:, 0], np.full(ring.count, source.inflator.chamber, np.int32),
            0.5 * ring.hole_diameter, ring.cone, axis, ring.spin,
        )  # fmt: skip
        made.append(Injector(kinds, source.inflator, nozzles))
    return made


def _birth_times(gas: CorpuscularState, first: int, seed: int) -> np.ndarray:
    """Fractions of the step at which the particles from `first` on are born, (newborns,)."""
    times = np.empty(gas.particles.count - first)
    _draw_uniform(gas.particles.identity[first : gas.particles.count], seed + BIRTH_TIME, times)
    return times


def draw_air_in(setup: Setup, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag) -> None:
    """Air from outside, where that has the higher pressure."""
    ambient = setup.ambient
    for k, row in enumerate(setup.passages.rows):
        number = np.floor(gas.owed[k] / kinds.mass).astype(np.int64)
        if not number.any():
            continue
        mass = number * kinds.mass
        chamber, inward = (row.behind, -1.0) if row.ahead == OUTSIDE else (row.ahead, 1.0)
        energy, impulse = draw_in(
            gas.particles, kinds, number, ambient.temperature, chamber, bag.surface.triangles[row.triangles],
            bag.positions, inward, setup.seed,
        )  # fmt: skip
        enthalpy = mixture_enthalpy(setup.table, mass, ambient.temperature)
        gas.owed[k] -= mass
        gas.drawn += mass
        gas.enthalpy_in += enthalpy
        gas.pool[chamber] += enthalpy - energy
        gas.impulse += impulse


@scalar
def _draw_uniform(identity, seed, drawn_out):
    for p in range(len(identity)):
        drawn_out[p] = uniform(stream(seed, 0, identity[p]), 0)
