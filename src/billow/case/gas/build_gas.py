"""From the `[gas]`, `[inflator]` and `[ambient]` tables to the gas of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.case import schema
from billow.case.gas import schema_gas
from billow.case.gas.build_passages import build_passages, chamber_of
from billow.case.gas.models import GAS_MODELS, NO_MOUTH
from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import area_vectors
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator, JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.species import AIR, Species, find_species, mass_fractions, thermo_table
from billow.parts.gas.supply.supply import Source, Supply

WIDEST_RING, RING_IN_MOUTH = 0.038, 0.8
"""Radius of a ring of holes [m] that fits, at most, and in radii of the mouth."""

NO_VOLUME = InputError.declare(
    "E-GAS-004",
    "chamber {chamber} encloses no air at the start",
    where="bag, chamber {chamber}",
    why="its volume is {volume:.3g} m^3, and gas without volume has no pressure",
    cause="layers of the start shape that lie on each other",
    remedy="raise bag.initial_gap, or move the layers of the start shape apart",
)


@dataclass(frozen=True)
class GasNames:
    """The species of a case in the order of all its tables, and how fractions are put into that order."""

    names: tuple[str, ...]
    species: tuple[Species, ...]

    @classmethod
    def of(cls, case: schema.Case) -> GasNames:
        """Every species that flows in, is there at the start, or comes from outside. Raises InputError E-GAS-001."""
        own = {name: Species.polynomial(name, s.molar_mass, s.a, s.b, s.c) for name, s in case.gas.species.items()}
        wheres = {name: f"{_key(case, i)}.gas.{name}" for i in case.inflators for name in i.gas}
        wheres |= {name: f"gas.initial.gas.{name}" for name in case.gas.initial.gas if name not in wheres}
        wheres |= {name: "ambient" for name in AIR if name not in wheres}
        return cls(tuple(wheres), tuple(find_species(name, where, own) for name, where in wheres.items()))

    def mass_fractions(self, gas: dict[str, float], of: str = "mole") -> np.ndarray:
        """(species,), from mole or mass fractions by name; they sum to one to rounding."""
        if of == "mole":
            gas = mass_fractions(gas, dict(zip(self.names, self.species, strict=True)))
        fractions = np.array([gas.get(name, 0.0) for name in self.names])
        return fractions / fractions.sum()


def build_gas(case: schema.Case, shape: BagShape) -> GasPart:
    """The gas of a case.

    Raises InputError E-GAS-001 (unknown species), E-GAS-004 (a chamber without volume), E-GAS-006 (jets into a chamber
    without a mouth), those of `build_passages`, and those of the model's builder.
    """
    kind = GAS_MODELS[case.gas.model]
    supply = build_supply(case, shape) if kind.has_supply else None
    model = kind.build(case, shape, supply)
    if kind.is_local and case.gas.switch_time:
        from billow.parts.gas.switching import Switching  # with a second gas, whose kernels no other case needs
        from billow.parts.gas.uniform.uniform_pressure import UniformPressure

        model = Switching(shape.surface, model, UniformPressure(supply), case.gas.switch_time)
    return GasPart(model, shape.surface, np.ascontiguousarray(shape.positions), supply)


def build_supply(case: schema.Case, shape: BagShape) -> Supply:
    """What feeds the gas and where it can go, whatever model it is. Raises as `build_gas`."""
    surface, chambers, ambient, initial = shape.surface, shape.surface.chambers, case.ambient, case.gas.initial
    for name, volume in zip(chambers.names, chambers.volumes(surface.triangles, shape.positions), strict=True):
        if not volume > 0.0:
            raise NO_VOLUME(chamber=name, volume=volume)
    gas, flat = GasNames.of(case), flat_area(shape.reference)
    outer = (chambers.behind != OUTSIDE) & (chambers.ahead == OUTSIDE)
    outer &= np.isin(np.arange(len(flat)), surface.triangles_of_kind("fabric"))
    at_start = Ambient(
        ambient.pressure if initial.pressure == "ambient" else initial.pressure,
        ambient.temperature if initial.temperature == "ambient" else initial.temperature,
        gas.mass_fractions(initial.gas, initial.fractions),
    )
    return Supply(
        table=thermo_table(list(gas.species)),
        species_names=gas.names,
        sources=tuple(build_source(case, inflator, gas, shape) for inflator in case.inflators),
        ambient=Ambient(ambient.pressure, ambient.temperature, gas.mass_fractions(AIR)),
        chambers=chambers,
        passages=build_passages(case, shape),
        initial=InitialGas.like(at_start, chambers.count),
        heat_conductance=case.gas.heat_transfer * np.bincount(chambers.behind[outer], flat[outer], chambers.count),
    )


def build_source(case: schema.Case, inflator: schema_gas.Inflator, gas: GasNames, shape: BagShape) -> Source:
    """An inflator and its jets; a diffuse one blows out of half its mouth, in all directions into the bag."""
    built, jets = build_inflator(case, inflator, gas, shape), inflator.jets
    mouths, chambers = shape.surface.triangles_of_kind("mouth"), shape.surface.chambers
    mouth = mouths[chambers.behind[mouths] == built.chamber]
    if not len(mouth):
        if jets.count:
            raise NO_MOUTH(inflator=inflator.name, chamber=chambers.names[built.chamber])
        return Source(built, None, diffuse=True)
    if jets.count:
        angle, cone, azimuth = (float(np.radians(a)) for a in (jets.angle, jets.cone, jets.azimuth))
        radius = ring_radius(jets, mouth, shape)
        ring = JetRing(jets.count, radius, jets.hole_diameter, angle, cone, azimuth, 2.0 * np.pi * jets.spin)
    else:
        radius = float(np.sqrt(flat_area(shape.reference)[mouths].sum() / np.pi))
        ring = JetRing(1, 0.0, radius, 0.0, cone=0.5 * np.pi)
    return Source(built, mount(ring, mouth, built.chamber, shape), diffuse=not jets.count)


def ring_radius(jets: schema_gas.Jets, mouth: np.ndarray, shape: BagShape) -> float:
    """Of the ring of holes [m]: as it is given, or as it fits into a mouth, triangles (n,)."""
    if jets.ring_radius != "fits":
        return jets.ring_radius
    return min(WIDEST_RING, RING_IN_MOUTH * float(np.sqrt(flat_area(shape.reference)[mouth].sum() / np.pi)))


def build_inflator(case: schema.Case, inflator: schema_gas.Inflator, gas: GasNames, shape: BagShape) -> Inflator:
    """One inflator, its scales and its delay in its curves."""
    given = inflator.temperature
    times, temperatures = ([0.0, 1.0], [given, given]) if isinstance(given, float) else (given.time, given.value)
    names, chamber = shape.surface.chambers.names, inflator.chamber
    if chamber in ("mouth", "first") and chamber not in names:
        mouths = np.unique(shape.surface.chambers.behind[shape.surface.triangles_of_kind("mouth")])
        chamber = names[mouths[0] if chamber == "mouth" and len(mouths) == 1 else 0]
    return Inflator(
        flow_time=inflator.time_scale * np.array(inflator.mass_flow.time) + inflator.delay,
        mass_flow=inflator.scale * np.array(inflator.mass_flow.value),
        temperature_time=inflator.time_scale * np.array(times) + inflator.delay,
        temperature=np.array(temperatures),
        mass_fractions=gas.mass_fractions(inflator.gas, inflator.fractions),
        name=inflator.name,
        chamber=chamber_of(chamber, shape, f"{_key(case, inflator)}.chamber"),
    )


def mount(ring: JetRing, mouth: np.ndarray, chamber: int, shape: BagShape) -> Jets:
    """A ring of jets in the mouth of a chamber, triangles (n,)."""
    surface, chambers = shape.surface, shape.surface.chambers
    inwards = -area_vectors(surface.triangles[mouth], shape.positions).sum(axis=0)
    nodes = np.unique(surface.triangles[mouth]).astype(np.int64)
    axis = inwards / np.linalg.norm(inwards)
    start = shape.positions[nodes]
    zero = shape.azimuths_from
    if zero is None:
        zero = start_of_rim(surface.triangles[mouth], shape.positions, axis)
    if chambers.count == 1 and (chambers.behind == chamber).all():
        return Jets(ring, nodes, axis, zero, mouth_start=start)
    facing = [np.flatnonzero(side == chamber) for side in (chambers.behind, chambers.ahead)]
    reversed_ = np.repeat([False, True], [len(f) for f in facing])
    return Jets(ring, nodes, axis, zero, np.concatenate(facing), reversed_, start)


def start_of_rim(mouth: np.ndarray, positions: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Vector [m] (3,) from the middle of a mouth, triangles (n, 3), to the node of its rim with the lowest number that
    is not on its axis: it belongs to the mesh, and turns and moves with it."""
    edges = np.sort(np.concatenate([mouth[:, [0, 1]], mouth[:, [1, 2]], mouth[:, [2, 0]]]), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    arms = positions[np.unique(edges[uses == 1])] - positions[np.unique(mouth)].mean(axis=0)
    aside = np.linalg.norm(arms - (arms @ axis)[:, None] * axis, axis=1)
    return arms[np.argmax(aside > 0.1 * aside.max())]


def _key(case: schema.Case, inflator: schema_gas.Inflator) -> str:
    """Where in the case an inflator stands."""
    return f"inflator.{inflator.name}" if isinstance(case.inflator, tuple) else "inflator"
