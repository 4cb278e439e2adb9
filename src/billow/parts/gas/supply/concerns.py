"""What is allowed of the supply of a bag but probably not meant; the same for every gas model."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.base.plausible import is_usual
from billow.parts.gas.supply.mixture import mixture_gas_constant
from billow.parts.gas.supply.outflow import PERMEABILITY
from billow.parts.gas.supply.passages import FABRIC, VENT
from billow.parts.gas.supply.supply import Supply
from billow.parts.part import WORKING_PRESSURE, Setting, extent

GAS_COMES_TOO_LATE = Concern.declare(
    "W-GAS-001",
    "only {share:.2g} % of the gas is delivered before the run ends",
    where="inflator.mass_flow, run.end_time",
    why="the curve ends at {curve_end:g} s, the run at {run_end:g} s: times may be in milliseconds",
    cause="times of the curve in another unit, or a run that is too short",
    remedy='write times with units, for example "50 ms"',
)
GAS_COMES_AT_ONCE = Concern.declare(
    "W-GAS-002",
    "all gas comes within {duration:.3g} ms",
    where="inflator.mass_flow",
    why="inflators burn for 20 to 100 ms: times may be in another unit",
    remedy='write times with units, for example "50 ms"',
)
ODD_AMOUNT = Concern.declare(
    "W-GAS-003",
    "{mass:.3g} g of gas for a bag of about {volume:.3g} l",
    where="inflator.mass_flow, size of the bag",
    why="at ambient pressure it fills {bags:.2g} bags: mass may be in grams, or a length in mm",
    remedy='write units, for example value = ["0 g/s", "2000 g/s", "0 g/s"]',
)
LOSES_TOO_MUCH = Concern.declare(
    "W-GAS-004",
    f"the {{loser}} out {{loss:.3g}} kg/s at {1e-3 * WORKING_PRESSURE:g} kPa, the inflator gives {{peak:.3g}}",
    where="{key}",
    why="the bag can never reach a working pressure",
    cause="a permeability or a vent in another unit",
    remedy="reduce {key}, or check the unit of inflator.mass_flow",
)
ODD_OPENING_PRESSURE = Concern.declare(
    "W-GAS-005",
    "the vents open at {pressure:g} Pa",
    where="bag.vents.opening_pressure",
    why="bags work at 5 to 100 kPa above ambient: vents would be open at once or never; the unit may be another",
    remedy='write units, for example opening_pressure = "20 kPa"; 0 for open vents',
)
RING_WIDER_THAN_MOUTH = Concern.declare(
    "W-GAS-006",
    "the jets leave at a radius of {ring:g} m, the mouth has {mouth:.3g} m",
    where="inflator.jets.ring_radius, bag.mouth_radius",
    why="the inflator would not fit through the mouth it is mounted in; particles would begin outside the bag",
    cause="a diameter given as a radius",
    remedy="reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius",
)
PRESSED_FLAT = Concern.declare(
    "W-GAS-007",
    "the bag starts with gas at {pressure:.4g} Pa, the pressure around it is {ambient:.4g} Pa",
    where="gas.initial.pressure",
    why="the surroundings press it together before the inflator can fill it: the run may stop with E-NUM-009 or -003",
    cause="a pressure above the ambient one where the absolute one is meant",
    remedy="leave gas.initial.pressure out, or write the absolute pressure",
)
FIRM = 0.9
"""Part of the ambient pressure below which a bag is pressed together at the start."""


def supply_concerns(supply: Supply, setting: Setting) -> Iterator[Concern]:
    """Amounts, times, sizes and pressures that do not go together."""
    start, ambient = float(np.min(supply.start_gas.pressure)), supply.ambient.pressure
    if start < FIRM * ambient:
        yield PRESSED_FLAT(pressure=start, ambient=ambient)
    inflators = supply.inflators
    if not inflators:
        return
    total = sum(i.cumulative[-1] for i in inflators)
    delivered = sum(i.delivered(setting.end_time) for i in inflators)
    latest = max(i.flow_time[-1] for i in inflators)
    if delivered < 0.5 * total:
        yield GAS_COMES_TOO_LATE(share=100 * delivered / total, curve_end=latest, run_end=setting.end_time)
    longest = max(i.flow_time[-1] - i.flow_time[0] for i in inflators)
    if longest < 0.02 * setting.end_time:
        yield GAS_COMES_AT_ONCE(duration=1e3 * longest)
    heat = sum(
        i.cumulative[-1] * mixture_gas_constant(supply.table, i.mass_fractions) * float(i.temperature.max())
        for i in inflators
    )
    bags = heat / supply.ambient.pressure / setting.inflated_volume
    if not 0.3 <= bags <= 6.0:
        yield ODD_AMOUNT(mass=1e3 * total, volume=1e3 * setting.inflated_volume, bags=bags)
    yield from _losses(supply, heat / total)
    opening = {row.opens_at for row in supply.passages.rows if row.kind == VENT and np.isfinite(row.opens_at)}
    for pressure in sorted(p for p in opening if p != 0.0 and not is_usual("opening pressure", p)):
        yield ODD_OPENING_PRESSURE(pressure=pressure)
    for source in supply.sources:
        if source.jets is None or source.diffuse:
            continue
        mouth, ring = 0.5 * extent(setting.start[source.jets.mouth_nodes]), source.jets.ring
        if ring.ring_radius > mouth:
            yield RING_WIDER_THAN_MOUTH(ring=ring.ring_radius, mouth=mouth)


def _losses(supply: Supply, specific_heat: float) -> Iterator[Concern]:
    """specific_heat: R T of the inflow [J/kg]."""
    peaks = [(float(i.mass_flow.max()), float(i.flow_time[i.mass_flow.argmax()])) for i in supply.inflators]
    peak, time = sum(flow for flow, _ in peaks), max(peaks)[1]
    outside = supply.ambient.pressure
    for kind, name in ((VENT, "vents let"), (FABRIC, "fabric lets")):
        loss = supply.passages.outflow(kind, time, outside + WORKING_PRESSURE, outside, specific_heat)
        laws = {row.law for row in supply.passages.rows if row.kind == FABRIC}
        fabric = "fabric.permeability" if PERMEABILITY in laws else "leakage.pressure_factor"
        if loss > peak:
            yield LOSES_TOO_MUCH(loser=name, loss=loss, peak=peak, key="bag.vents" if kind == VENT else fabric)
