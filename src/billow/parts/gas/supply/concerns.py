"""What is allowed of the supply of a bag but probably not meant; the same for every gas model."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.parts.gas.supply.mixture import mixture_gas_constant
from billow.parts.gas.supply.outflow import PERMEABILITY
from billow.parts.gas.supply.passages import FABRIC, VENT
from billow.parts.gas.supply.supply import Supply
from billow.parts.part import WORKING_PRESSURE, Setting, extent


def supply_concerns(supply: Supply, setting: Setting) -> Iterator[Concern]:
    """Amounts, times, sizes and pressures that do not go together."""
    inflators = supply.inflators
    if not inflators:
        return
    total = sum(i.cumulative[-1] for i in inflators)
    delivered = sum(i.delivered(setting.end_time) for i in inflators)
    latest = max(i.flow_time[-1] for i in inflators)
    if delivered < 0.5 * total:
        yield Concern(
            "W-GAS-001",
            f"only {100 * delivered / total:.2g} % of the gas is delivered before the run ends",
            "inflator.mass_flow, run.end_time",
            f"the curve ends at {latest:g} s, the run at {setting.end_time:g} s: times may be in milliseconds",
            'write times with units, for example "50 ms"',
        )
    longest = max(i.flow_time[-1] - i.flow_time[0] for i in inflators)
    if longest < 0.02 * setting.end_time:
        yield Concern(
            "W-GAS-002",
            f"all gas comes within {1e3 * longest:.3g} ms",
            "inflator.mass_flow",
            "inflators burn for 20 to 100 ms: times may be in another unit",
            'write times with units, for example "50 ms"',
        )
    heat = sum(
        i.cumulative[-1] * mixture_gas_constant(supply.table, i.mass_fractions) * float(i.temperature.max())
        for i in inflators
    )
    bags = heat / supply.ambient.pressure / setting.inflated_volume
    if not 0.3 <= bags <= 6.0:
        yield Concern(
            "W-GAS-003",
            f"{1e3 * total:.3g} g of gas for a bag of about {1e3 * setting.inflated_volume:.3g} l",
            "inflator.mass_flow, size of the bag",
            f"at ambient pressure it fills {bags:.2g} bags: mass may be in grams, or a length in mm",
            'write units, for example value = ["0 g/s", "2000 g/s", "0 g/s"]',
        )
    yield from _losses(supply, heat / total)
    opening = {row.opens_at for row in supply.passages.rows if row.kind == VENT and np.isfinite(row.opens_at)}
    for pressure in sorted(p for p in opening if not (p == 0.0 or 100.0 <= p <= 500e3)):
        yield Concern(
            "W-GAS-005",
            f"the vents open at {pressure:g} Pa",
            "bag.vents.opening_pressure",
            "bags work at 5 to 100 kPa above ambient: vents would be open at once or never; the unit may be another",
            'write units, for example opening_pressure = "20 kPa"; 0 for open vents',
        )
    for source in supply.sources:
        if source.jets is None or source.diffuse:
            continue
        mouth, ring = 0.5 * extent(setting.start[source.jets.mouth_nodes]), source.jets.ring
        if ring.ring_radius > mouth:
            yield Concern(
                "W-GAS-006",
                f"the jets leave at a radius of {ring.ring_radius:g} m, the mouth has {mouth:.3g} m",
                "inflator.jets.ring_radius, bag.mouth_radius",
                "the inflator would not fit through the mouth it is mounted in",
                "reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius",
            )


def _losses(supply: Supply, specific_heat: float) -> Iterator[Concern]:
    """specific_heat: R T of the inflow [J/kg]."""
    peaks = [(float(i.mass_flow.max()), float(i.flow_time[i.mass_flow.argmax()])) for i in supply.inflators]
    peak, time = sum(flow for flow, _ in peaks), max(peaks)[1]
    outside = supply.ambient.pressure
    for kind, name in ((VENT, "vents let"), (FABRIC, "fabric lets")):
        loss = supply.passages.outflow(kind, time, outside + WORKING_PRESSURE, outside, specific_heat)
        laws = {row.law for row in supply.passages.rows if row.kind == FABRIC}
        fabric = "fabric.permeability" if PERMEABILITY in laws else "leakage.pressure_factor"
        key = "bag.vents" if kind == VENT else fabric
        if loss > peak:
            yield Concern(
                "W-GAS-004",
                f"the {name} out {loss:.3g} kg/s at {1e-3 * WORKING_PRESSURE:g} kPa, the inflator gives {peak:.3g}",
                key,
                "the bag can never reach a working pressure",
                f"reduce {key}, or check the unit of inflator.mass_flow",
            )
