"""Airbags into which nothing flows: ADIABATIC_GAS_MODEL and SIMPLE_PRESSURE_VOLUME."""

from __future__ import annotations

from billow.decks.airbag_gas import AIR, GAS_CONSTANT, WARM, Airbag, core, put_species
from billow.decks.block import Block
from billow.decks.context import Context
from billow.decks.draft import said

THIN = 1000.0
"""Least pressure [Pa] around a bag."""
SOFT = 1000.0
"""Largest molar heat capacity [J/(mol K)]: a gas that hardly cools."""


def adiabatic(context: Context, block: Block) -> Airbag:
    """p V^gamma stays what it is at the start, p = PE + P0 (manual: P0 is gauge)."""
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    f = context.card(cards, "gas")
    gamma = f["GAMMA"].number
    if not gamma > 1.0:
        raise f["GAMMA"].bad("a gas has more than 1")
    if f["PSF"].number not in (0.0, 1.0):
        report.refused(f["PSF"], "pressures of a case act in full")
    if f["LCID"].whole:
        report.refused(f["LCID"], "a preload has no counterpart: the bag starts at PE + P0")
    inside = context.put("ambient.pressure", f["PE"], "pressure", 101325.0) + context.si(f["P0"], "pressure")
    put_species(context, "gas_1", AIR, gamma / (gamma - 1.0) * GAS_CONSTANT, 0.0, 0.0, f["GAMMA"])
    report.mapped(f["GAMMA"], gamma)
    report.mapped(f["P0"], inside)
    context.tables["gas"]["initial"] = {"gas": {"gas_1": 1.0}, "pressure": said(inside, f["P0"])}
    report.ignored(f["RO"], "pressure depends on volume alone: the density of the gas has no effect")
    return airbag


def pressure_volume(context: Context, block: Block) -> Airbag:
    """Gauge pressure CN BETA V0/V: a gas that hardly cools, and hardly any pressure around it."""
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    f = context.card(cards, "gas")
    for name in ("LCID", "LCIDDR"):
        if f[name].whole:
            report.refused(f[name], "a curve of pressure against volume has no counterpart; CN / volume is used")
    if not f["CN"].number > 0.0:
        raise f["CN"].bad("a pressure against relative volume is a positive number; curves have no counterpart")
    gauge = context.si(f["CN"], "pressure") * (f["BETA"].number or 1.0)
    inside = gauge + THIN
    gamma = SOFT / (SOFT - GAS_CONSTANT)
    put_species(context, "gas_1", AIR, SOFT, 0.0, 0.0, f["CN"])
    context.tables["gas"]["initial"] = {"gas": {"gas_1": 1.0}, "pressure": said(inside, f["CN"])}
    context.tables["ambient"] = {"pressure": said(THIN, f["CN"]), "temperature": said(WARM, f["CN"])}
    how = (
        f"a gas of gamma {gamma:.4f} in surroundings of {THIN / 1e3:g} kPa: at v times the volume of the start, gauge "
        f"pressure is off by {THIN / 1e3:g} kPa (1/v - 1), and by {100 * (gamma - 1):.2f} % of itself per ln v"
    )
    report.approximated(f["CN"], how, inside)
    report.approximated(f["BETA"], how, f["BETA"].number or 1.0)
    return airbag
