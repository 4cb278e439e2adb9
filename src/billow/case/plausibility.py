"""What is allowed but probably not meant: slips of units and settings that defeat each other.

Ranges in the schema refuse the impossible. This file looks at quantities together and warns; warnings are printed
before a run, kept in its record, and turn its verdict to REVIEW.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.case import schema
from billow.case.bag.plausible_mesh import mesh_warnings
from billow.case.fabric.plausible_curves import curve_warnings
from billow.case.obstacles import schema_obstacle
from billow.geometry.shapes import super_ellipsoid
from billow.parts.gas.supply.mixture import mixture_gas_constant
from billow.parts.gas.supply.passages import FABRIC, VENT
from billow.parts.gas.uniform.exchange import outflow
from billow.parts.gas.uniform.uniform_pressure import UniformPressure
from billow.solver.model import Model

MYLAR_VOLUME = 1.21852
"""Volume of two sewn inextensible discs of radius a, in a^3 (Paulsen, Am. Math. Monthly 101, 1994)."""

WORKING_PRESSURE = 20e3
"""Gauge pressure [Pa] at which vents and fabric are judged."""


def warnings(case: schema.Case, model: Model) -> list[Concern]:
    """Everything about a case that looks unintended."""
    return [
        *mesh_warnings(case, model),
        *curve_warnings(model),
        *_fabric(case),
        *_gas(case, model),
        *_obstacles(case, model),
    ]


def _fabric(case: schema.Case) -> Iterator[Concern]:
    fabric = case.fabric
    speed = np.sqrt(max(fabric.young_warp, fabric.young_weft) / fabric.density)
    linear = fabric.law == "linear"
    if linear and not 100.0 <= speed <= 4000.0:
        yield Concern(
            "W-FAB-001",
            f"sound travels at {speed:.3g} m/s in this fabric",
            "fabric.young_warp, fabric.young_weft, fabric.density",
            "woven fabric has 400 to 1,500 m/s: a modulus or the density is probably in another unit",
            'write units, for example young_warp = "0.4 GPa"',
        )
    areal = fabric.density * fabric.thickness
    if not 0.05 <= areal <= 2.0:
        yield Concern(
            "W-FAB-002",
            f"the fabric weighs {1e3 * areal:.3g} g/m^2",
            "fabric.density, fabric.thickness",
            "airbag fabric weighs 150 to 400 g/m^2",
            'write units, for example thickness = "0.3 mm"',
        )
    ratio = max(fabric.young_warp, fabric.young_weft) / min(fabric.young_warp, fabric.young_weft)
    if linear and (ratio > 20.0 or fabric.shear > 2.0 * max(fabric.young_warp, fabric.young_weft)):
        yield Concern(
            "W-FAB-003",
            "the moduli of the fabric do not go together",
            "fabric.young_warp, fabric.young_weft, fabric.shear",
            "warp and weft differ by a small factor, and woven fabric is far softer in shear",
            "check the powers of ten",
        )


def _gas(case: schema.Case, model: Model) -> Iterator[Concern]:
    if not isinstance(model.gas, UniformPressure):
        return
    inflators = model.gas.inflators
    total = sum(i.cumulative[-1] for i in inflators)
    delivered = sum(i.delivered(case.run.end_time) for i in inflators)
    latest = max(i.flow_time[-1] for i in inflators)
    if delivered < 0.5 * total:
        yield Concern(
            "W-GAS-001",
            f"only {100 * delivered / total:.2g} % of the gas is delivered before the run ends",
            "inflator.mass_flow, run.end_time",
            f"the curve ends at {latest:g} s, the run at {case.run.end_time:g} s: times may be in milliseconds",
            'write times with units, for example "50 ms"',
        )
    longest = max(i.flow_time[-1] - i.flow_time[0] for i in inflators)
    if longest < 0.02 * case.run.end_time:
        yield Concern(
            "W-GAS-002",
            f"all gas comes within {1e3 * longest:.3g} ms",
            "inflator.mass_flow",
            "inflators burn for 20 to 100 ms: times may be in another unit",
            'write times with units, for example "50 ms"',
        )
    heat = sum(
        i.cumulative[-1] * mixture_gas_constant(model.gas.table, i.mass_fractions) * float(i.temperature.max())
        for i in inflators
    )
    free_volume = heat / case.ambient.pressure
    bag = inflated_volume(model)
    if not 0.3 <= free_volume / bag <= 6.0:
        yield Concern(
            "W-GAS-003",
            f"{1e3 * total:.3g} g of gas for a bag of about {1e3 * bag:.3g} l",
            f"inflator.mass_flow, {case.bag.size_key}",
            f"at ambient pressure it fills {free_volume / bag:.2g} bags: mass may be in grams, or a length in mm",
            'write units, for example value = ["0 g/s", "2000 g/s", "0 g/s"]',
        )
    yield from _losses(case, model.gas, heat / total)
    opening = case.bag.vents.opening_pressure
    if len(model.surface.triangles_of_kind("vent")) and not (opening == 0.0 or 100.0 <= opening <= 500e3):
        yield Concern(
            "W-GAS-005",
            f"the vents open at {opening:g} Pa",
            "bag.vents.opening_pressure",
            "bags work at 5 to 100 kPa above ambient: vents would be open at once or never; the unit may be another",
            'write units, for example opening_pressure = "20 kPa"; 0 for open vents',
        )
    mouth = 0.5 * extent(model, model.surface.triangles_of_kind("mouth"))
    for jets in (inflator.jets for inflator in case.inflators):
        if jets.count and jets.ring_radius > mouth:
            yield Concern(
                "W-GAS-006",
                f"the jets leave at a radius of {jets.ring_radius:g} m, the mouth has {mouth:.3g} m",
                "inflator.jets.ring_radius, bag.mouth_radius",
                "the inflator would not fit through the mouth it is mounted in",
                "reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius",
            )


def inflated_volume(model: Model) -> float:
    """About the volume [m^3] the bag will have: that of two sewn discs of each chamber's share of the fabric."""
    chambers = model.surface.chambers.count
    radius = np.sqrt(model.contact_area.sum() / chambers / (2.0 * np.pi))
    return float(chambers * MYLAR_VOLUME * radius**3)


def extent(model: Model, triangles: np.ndarray) -> float:
    """Largest horizontal size [m] of some triangles at the start; zero if there are none."""
    nodes = model.start[model.surface.triangles[triangles].ravel(), :2]
    return float(np.ptp(nodes, axis=0).max()) if len(nodes) else 0.0


def _losses(case: schema.Case, gas: UniformPressure, specific_heat: float) -> Iterator[Concern]:
    """specific_heat: R T of the inflow [J/kg]."""
    peaks = [(float(i.mass_flow.max()), float(i.flow_time[i.mass_flow.argmax()])) for i in gas.inflators]
    peak, time = sum(flow for flow, _ in peaks), max(peaks)[1]
    inside = gas.ambient.pressure + WORKING_PRESSURE
    vents, leak = (
        outflow(gas.passages, kind, time, inside, gas.ambient.pressure, specific_heat) for kind in (VENT, FABRIC)
    )
    fabric = "fabric.permeability" if case.leakage.law == "permeability" else "leakage.pressure_factor"
    for name, loss, key in (("vents let", vents, "bag.vents"), ("fabric lets", leak, fabric)):
        if loss > peak:
            yield Concern(
                "W-GAS-004",
                f"the {name} out {loss:.3g} kg/s at {1e-3 * WORKING_PRESSURE:g} kPa, the inflator gives {peak:.3g}",
                key,
                "the bag can never reach a working pressure",
                f"reduce {key}, or check the unit of inflator.mass_flow",
            )


def _obstacles(case: schema.Case, model: Model) -> Iterator[Concern]:
    across = extent(model, np.arange(model.surface.triangle_count))
    for obstacle in case.obstacles:
        if not isinstance(obstacle, schema_obstacle.SuperEllipsoid):
            continue
        key = f"obstacles.{obstacle.name}"
        if obstacle.clearance > 0.7 * across:
            yield Concern(
                "W-OBS-001",
                f"{obstacle.name} is {obstacle.clearance:g} m away from a bag of {across:.3g} m",
                f"{key}.clearance",
                "the bag will not reach it",
                "reduce the clearance, or remove the obstacle",
            )
        radii = np.array([obstacle.radii] * 3 if isinstance(obstacle.radii, float) else obstacle.radii)
        density = obstacle.mass / super_ellipsoid.volume(radii, obstacle.degree)
        if not obstacle.locked and not 5.0 <= density <= 20e3:
            yield Concern(
                "W-OBS-002",
                f"{obstacle.name} has a mean density of {density:.3g} kg/m^3",
                f"{key}.mass, {key}.radii",
                "heads and impactors lie between 50 and 8,000: mass or radii may be in another unit",
                'write units, for example mass = "4500 g"',
            )
        if obstacle.slope < 200.0:
            yield Concern(
                "W-OBS-003",
                f"{obstacle.name} yields {WORKING_PRESSURE * 1e-4 / obstacle.slope * 1e3:.3g} mm at 20 kPa",
                f"{key}.slope",
                "it is softer than the bag: the slope may be in N/mm",
                'write units, for example slope = "100 N/mm"',
            )
