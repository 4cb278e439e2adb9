"""From the `[gas]`, `[inflator]` and `[ambient]` tables to a gas model.

Inflator, vents, porosity and ambient are the same objects for all models.
"""

from __future__ import annotations

import numpy as np

from billow.case import schema, schema_bag
from billow.gas.gas_model import GasModel
from billow.gas.inflator import Inflator, JetRing
from billow.gas.jets import Jets
from billow.gas.no_gas import NoGas
from billow.gas.species import AIR, find_species, mass_fractions, thermo_table
from billow.gas.uniform_pressure import Ambient, Porosity, UniformPressure, Vents
from billow.geometry.bag_shapes import BagShape


def build_gas(case: schema.Case, shape: BagShape, porous_area: float) -> GasModel:
    """The gas model named in the case; inflator, vents, porosity and ambient are the same objects for all."""
    if case.gas.model == "none":
        return NoGas(case.ambient.pressure, case.ambient.temperature)
    names = tuple(dict.fromkeys([*case.inflator.gas, *AIR]))
    species = [find_species(name, f"inflator.gas.{name}") for name in names]

    def in_order(moles: dict[str, float]) -> np.ndarray:
        fractions = mass_fractions(moles)
        return np.array([fractions.get(name, 0.0) for name in names])

    temperature = case.inflator.temperature
    if isinstance(temperature, float):
        temperature_time, temperature_value = [0.0, 1.0], [temperature, temperature]
    else:
        temperature_time, temperature_value = temperature.time, temperature.value
    ring = JetRing(
        case.inflator.jets.count,
        case.inflator.jets.ring_radius,
        case.inflator.jets.hole_diameter,
        float(np.radians(case.inflator.jets.angle)),
    )
    inflator = Inflator(
        flow_time=np.array(case.inflator.mass_flow.time),
        mass_flow=np.array(case.inflator.mass_flow.value),
        temperature_time=np.array(temperature_time),
        temperature=np.array(temperature_value),
        mass_fractions=in_order(case.inflator.gas),
    )
    mouth = np.unique(shape.surface.triangles[shape.surface.triangles_of("mouth")]).astype(np.int64)
    return UniformPressure(
        table=thermo_table(species),
        species_names=names,
        inflator=inflator,
        ambient=Ambient(case.ambient.pressure, case.ambient.temperature, in_order(AIR)),
        vents=build_vents(case.bag.vents, shape),
        porosity=Porosity(case.fabric.permeability, porous_area),
        jets=Jets(ring, mouth, shape.mouth_axis) if ring.count else None,
    )


def build_vents(vents: schema_bag.Vents, shape: BagShape) -> Vents:
    patches = [shape.surface.triangles_of(f"vent_{k + 1}") for k in range(vents.count)]
    return Vents(
        triangles=shape.surface.triangles[np.concatenate([*patches, np.empty(0, np.int64)]).astype(np.int64)],
        start=np.concatenate([[0], np.cumsum([len(p) for p in patches])]).astype(np.int64),
        discharge=np.full(vents.count, vents.discharge),
        opening=np.full(vents.count, vents.opening_pressure),
    )
