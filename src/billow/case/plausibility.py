"""What is allowed but probably not meant: slips of units and settings that defeat each other.

Ranges in the schema refuse the impossible. This file looks at quantities together and warns; warnings are printed
before a run, kept in its record, and turn its verdict to REVIEW.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from billow.case import schema, schema_obstacle
from billow.dynamics.guards import worst_stretch
from billow.dynamics.model import Model
from billow.gas.mixture import mixture_gas_constant
from billow.gas.outflow import orifice_flux, porous_flux
from billow.gas.uniform_pressure import UniformPressure
from billow.geometry import super_ellipsoid

MYLAR_VOLUME = 1.21852
"""Volume of two sewn inextensible discs of radius a, in a^3 (Paulsen, Am. Math. Monthly 101, 1994)."""

START_STRAIN = 0.05
"""Strain of fabric or straps at the start from which on it cannot be meant."""

WORKING_PRESSURE = 20e3
"""Gauge pressure [Pa] at which vents and fabric are judged."""


@dataclass(frozen=True)
class Warning:
    """One finding: a stable code, what is odd, where, why it matters, and what to try."""

    code: str
    what: str
    where: str
    why: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.code} warning: {self.what}\n  where: {self.where}\n  why:   {self.why}\n  try:   {self.remedy}"


def warnings(case: schema.Case, model: Model) -> list[Warning]:
    """Everything about a case that looks unintended."""
    return [*_mesh(case, model), *_fabric(case), *_gas(case, model), *_obstacles(case)]


def _mesh(case: schema.Case, model: Model) -> Iterator[Warning]:
    if case.bag.element_size > case.bag.diameter / 10.0:
        yield Warning(
            "W-MESH-001",
            f"only {case.bag.diameter / case.bag.element_size:.0f} elements across the bag",
            "bag.element_size",
            "shape and volume will be off by several percent",
            "use at most a twentieth of the diameter",
        )
    for membrane in model.membranes:
        element, stretch = worst_stretch(membrane, model, model.start)
        if stretch > 1.0 + START_STRAIN:
            triangle = int(membrane.elements[element])
            part = model.surface.part_names[model.surface.part[triangle]]
            yield Warning(
                "W-MESH-002",
                f"the fabric starts stretched by {100 * (stretch - 1.0):.3g} %",
                f"triangle {triangle}, part {part}; bag.initial_gap",
                "it would snap back at the first step: the start shape is not the shape the fabric was cut in",
                "use a bag.initial_gap of a few millimetres",
            )
    ends = model.start[model.straps.bars]
    distance = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    taut = distance / model.straps.length - 1.0
    if len(taut) and taut.max() > START_STRAIN:
        bar = int(taut.argmax())
        yield Warning(
            "W-MESH-003",
            f"a strap of {model.straps.length[bar]:g} m starts {distance[bar]:.3g} m long",
            f"bag.straps.length, strap {model.straps.strap[bar]}",
            "it would snap back at the first step",
            "lengthen bag.straps.length, or bring bag.straps.stitch_radius closer to bag.mouth_radius",
        )


def _fabric(case: schema.Case) -> Iterator[Warning]:
    fabric = case.fabric
    speed = np.sqrt(max(fabric.young_warp, fabric.young_weft) / fabric.density)
    if not 100.0 <= speed <= 4000.0:
        yield Warning(
            "W-FAB-001",
            f"sound travels at {speed:.3g} m/s in this fabric",
            "fabric.young_warp, fabric.young_weft, fabric.density",
            "woven fabric has 400 to 1,500 m/s: a modulus or the density is probably in another unit",
            'write units, for example young_warp = "0.4 GPa"',
        )
    areal = fabric.density * fabric.thickness
    if not 0.05 <= areal <= 2.0:
        yield Warning(
            "W-FAB-002",
            f"the fabric weighs {1e3 * areal:.3g} g/m^2",
            "fabric.density, fabric.thickness",
            "airbag fabric weighs 150 to 400 g/m^2",
            'write units, for example thickness = "0.3 mm"',
        )
    ratio = max(fabric.young_warp, fabric.young_weft) / min(fabric.young_warp, fabric.young_weft)
    if ratio > 20.0 or fabric.shear > 2.0 * max(fabric.young_warp, fabric.young_weft):
        yield Warning(
            "W-FAB-003",
            "the moduli of the fabric do not go together",
            "fabric.young_warp, fabric.young_weft, fabric.shear",
            "warp and weft differ by a small factor, and woven fabric is far softer in shear",
            "check the powers of ten",
        )


def _gas(case: schema.Case, model: Model) -> Iterator[Warning]:
    if not isinstance(model.gas, UniformPressure):
        return
    inflator = model.gas.inflator
    total, delivered = inflator.cumulative[-1], inflator.delivered(case.run.end_time)
    if delivered < 0.5 * total:
        yield Warning(
            "W-GAS-001",
            f"only {100 * delivered / total:.2g} % of the gas is delivered before the run ends",
            "inflator.mass_flow, run.end_time",
            f"the curve ends at {inflator.flow_time[-1]:g} s, the run at {case.run.end_time:g} s: "
            "times may be in milliseconds",
            'write times with units, for example "50 ms"',
        )
    if inflator.flow_time[-1] < 0.02 * case.run.end_time:
        yield Warning(
            "W-GAS-002",
            f"all gas comes within {1e3 * inflator.flow_time[-1]:.3g} ms",
            "inflator.mass_flow",
            "inflators burn for 20 to 100 ms: times may be in another unit",
            'write times with units, for example "50 ms"',
        )
    specific = mixture_gas_constant(model.gas.table, inflator.mass_fractions)
    hottest = float(inflator.temperature.max())
    free_volume = total * specific * hottest / case.ambient.pressure
    bag = MYLAR_VOLUME * (0.5 * case.bag.diameter) ** 3
    if not 0.3 <= free_volume / bag <= 6.0:
        yield Warning(
            "W-GAS-003",
            f"{1e3 * total:.3g} g of gas for a bag of about {1e3 * bag:.3g} l",
            "inflator.mass_flow, bag.diameter",
            f"at ambient pressure it fills {free_volume / bag:.2g} bags: mass may be in grams, or a length in mm",
            'write units, for example value = ["0 g/s", "2000 g/s", "0 g/s"]',
        )
    yield from _losses(case, model.gas, specific, hottest)
    opening = case.bag.vents.opening_pressure
    if case.bag.vents.count and not (opening == 0.0 or 100.0 <= opening <= 500e3):
        yield Warning(
            "W-GAS-005",
            f"the vents open at {opening:g} Pa",
            "bag.vents.opening_pressure",
            "bags work at 5 to 100 kPa above ambient: vents would be open at once or never; the unit may be another",
            'write units, for example opening_pressure = "20 kPa"; 0 for open vents',
        )
    jets = case.inflator.jets
    if jets.count and jets.ring_radius > case.bag.mouth_radius:
        yield Warning(
            "W-GAS-006",
            f"the jets leave at a radius of {jets.ring_radius:g} m, the mouth has {case.bag.mouth_radius:g} m",
            "inflator.jets.ring_radius, bag.mouth_radius",
            "the inflator would not fit through the mouth it is mounted in",
            "reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius",
        )


def _losses(case: schema.Case, gas: UniformPressure, specific: float, temperature: float) -> Iterator[Warning]:
    peak = float(gas.inflator.mass_flow.max())
    inside = case.ambient.pressure + WORKING_PRESSURE
    density = inside / (specific * temperature)
    flux = orifice_flux(inside, case.ambient.pressure, 1.3, specific * temperature)
    vents = case.bag.vents.count * case.bag.vents.discharge * 0.25 * np.pi * case.bag.vents.diameter**2 * flux
    leak = gas.porosity.area * porous_flux(WORKING_PRESSURE, density, gas.porosity.permeability, 1.0, 500.0)
    for name, loss, key in (("vents let", vents, "bag.vents"), ("fabric lets", leak, "fabric.permeability")):
        if loss > peak:
            yield Warning(
                "W-GAS-004",
                f"the {name} out {loss:.3g} kg/s at {1e-3 * WORKING_PRESSURE:g} kPa, the inflator gives {peak:.3g}",
                key,
                "the bag can never reach a working pressure",
                f"reduce {key}, or check the unit of inflator.mass_flow",
            )


def _obstacles(case: schema.Case) -> Iterator[Warning]:
    for obstacle in case.obstacles:
        if not isinstance(obstacle, schema_obstacle.SuperEllipsoid):
            continue
        key = f"obstacles.{obstacle.name}"
        if obstacle.clearance > 0.7 * case.bag.diameter:
            yield Warning(
                "W-OBS-001",
                f"{obstacle.name} is {obstacle.clearance:g} m away from a bag of {case.bag.diameter:g} m",
                f"{key}.clearance",
                "the bag will not reach it",
                "reduce the clearance, or remove the obstacle",
            )
        radii = np.array([obstacle.radii] * 3 if isinstance(obstacle.radii, float) else obstacle.radii)
        density = obstacle.mass / super_ellipsoid.volume(radii, obstacle.degree)
        if not obstacle.locked and not 5.0 <= density <= 20e3:
            yield Warning(
                "W-OBS-002",
                f"{obstacle.name} has a mean density of {density:.3g} kg/m^3",
                f"{key}.mass, {key}.radii",
                "heads and impactors lie between 50 and 8,000: mass or radii may be in another unit",
                'write units, for example mass = "4500 g"',
            )
        if obstacle.slope < 200.0:
            yield Warning(
                "W-OBS-003",
                f"{obstacle.name} yields {WORKING_PRESSURE * 1e-4 / obstacle.slope * 1e3:.3g} mm at 20 kPa",
                f"{key}.slope",
                "it is softer than the bag: the slope may be in N/mm",
                'write units, for example slope = "100 N/mm"',
            )
