"""Airbags of uniform pressure: HYBRID, WANG_NEFSKE and SIMPLE_AIRBAG_MODEL."""

from __future__ import annotations

import numpy as np

from billow.decks.airbag_gas import (
    AIR,
    GAS_CONSTANT,
    NITROGEN,
    Airbag,
    core,
    exits_of,
    flow_of,
    put_ambient,
    put_inflator,
    put_jet,
    put_species,
    temperature_of,
)
from billow.decks.block import Block
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said


def hybrid(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    ambient = context.card(cards, "ambient")
    exits = context.card(cards, "exits")
    options = context.card(cards, "options")
    put_ambient(context, ambient["ATMOSP"], ambient["ATMOST"])
    report.ignored(ambient["ATMOSD"], "density follows from pressure and temperature")
    report.mapped(ambient["GC"], "8.314 J/(mol K)", note="it tells the units")
    if ambient["HCONV"].number:
        context.put("gas.heat_transfer", ambient["HCONV"], "heat transfer")
    airbag.option = options["OPT"].whole
    report.mapped(options["OPT"], options["OPT"].whole, "leakage.law", "counts where FVOPT of the fabric is 0")
    if options["LCIDM0"].whole:
        report.refused(options["LCIDM0"], "one mass flow for all gases: give each gas its own LCIDM")
    if options["LCEFR"].whole:
        report.refused(options["LCEFR"], "a curve of exit flow against gauge pressure has no counterpart")
    exits_of(context, exits | {"PVENT": options["PVENT"]}, airbag)
    initial: dict[str, Said] = {}
    count = options["NGAS"].whole
    report.mapped(options["NGAS"], count, "inflator")
    for k in range(1, count + 1):
        f = context.card(cards, "gas", f"[{k}]")
        aspirated = context.card(cards, "aspirated", f"[{k}]", optional=True)
        if aspirated["FMASS"].number:
            report.refused(aspirated["FMASS"], "aspirated air has no counterpart: add it to the mass flow")
        name = f"gas_{k}"
        mass = context.si(f["MW"], "molar mass")
        heats = [context.si(f[one], "molar heat") for one in "ABC"]
        put_species(context, name, mass, *heats, f["MW"])
        for one, value in zip(("MW", *"ABC"), (mass, *heats), strict=True):
            report.mapped(f[one], value)
        if f["INITM"].number:
            initial[name] = said(f["INITM"].number, f["INITM"])
            report.mapped(f["INITM"], f["INITM"].number)
        if f["LCIDM"].whole:
            flow = flow_of(context, f["LCIDM"])
            put_inflator(context, name, name, flow, temperature_of(context, f["LCIDT"], flow))
    if initial:
        _initial(context, initial)
    if options["VNTOPT"].whole and exits["A23"].number < 0.0:
        report.refused(options["VNTOPT"], "the area of a vent is that of its part: set bag.vents.area_factor")
    if "JETTING" in block.name:
        put_jet(context, cards, airbag)
    return airbag


def _initial(context: Context, fractions: dict[str, Said]) -> None:
    """Composition at the start; fractions that nearly sum to 1 are made to."""
    total = sum(plain(fractions).values())
    for name, one in fractions.items():
        fractions[name] = Said(one.value / total, one.source)
    if abs(total - 1.0) > 1e-3:
        context.report.remarks.append(f"INITM sum to {total:.6g}; divided by it")
    context.tables.setdefault("gas", {})["initial"] = {"gas": fractions, "fractions": "mass"}


def _one_gas(context: Context, f: dict[str, Field], flow: Field, temperature: Field | None) -> None:
    """The gas of WANG_NEFSKE and SIMPLE_AIRBAG_MODEL: one, with constant cv and cp, or molar A, B and GASC."""
    report = context.report
    curve = flow_of(context, flow)
    if not f["CV"].number:
        mass, a = context.si(f["MW"], "molar mass"), context.si(f["A"], "molar heat")
        b = context.si(f["B"], "molar heat")
        for name, value in (("MW", mass), ("A", a), ("B", b)):
            report.mapped(f[name], value)
        report.mapped(f["GASC"], "8.314 J/(mol K)", "units")
        report.mapped(f["CV"], "0", note="MW, A and B are used")
        put_species(context, "gas_1", mass, a, b, 0.0, f["MW"])
        heat = curve
    else:
        cv, cp = (context.si(f[name], "specific heat") for name in ("CV", "CP"))
        gamma, gas_constant = cp / cv, cp - cv
        if not gamma > 1.0:
            raise f["CP"].bad(f"CP / CV is {gamma:.4g}; a gas has more than 1")
        mass = GAS_CONSTANT / gas_constant
        if 1.5e-3 <= mass <= 0.3:
            for name, value in (("CV", cv), ("CP", cp)):
                report.mapped(f[name], value, note=f"gas of {1e3 * mass:.4g} g/mol, gamma {gamma:.5g}")
            heat = curve
        else:
            # The gas constant of the deck is none: only the flow of enthalpy and gamma mean something (Trap 4).
            mass = NITROGEN
            ratio = cp / (gamma / (gamma - 1.0) * GAS_CONSTANT / mass)
            heat = Said(
                {"time": curve.value["time"], "value": (ratio * np.array(curve.value["value"])).tolist()}, curve.source
            )
            how = (
                f"CP - CV = {gas_constant:.4g} J/(kg K) is no gas: its flow of enthalpy and its gamma {gamma:.5g} "
                f"are kept, with 28 g/mol and {ratio:.4g} times the mass"
            )
            for name in ("CV", "CP"):
                report.approximated(f[name], how)
            report.approximated(flow, how, f"curve {flow.whole}")
        put_species(context, "gas_1", mass, gamma / (gamma - 1.0) * GAS_CONSTANT, 0.0, 0.0, f["CP"])
    if temperature is not None and temperature.whole:
        warm = temperature_of(context, temperature, curve)
        report.ignored(f["T"], "the curve of temperatures counts")
    else:
        warm = said(f["T"].number, f["T"])
        report.mapped(f["T"], f["T"].number)
    put_inflator(context, "gas_1", "gas_1", heat, warm)
    context.tables.setdefault("gas", {})["initial"] = {"gas": {"gas_1": 1.0}}
    report.remarks.append("the bag holds the inflator's gas at the start, as a deck with one gas says")


def _outside(context: Context, pressure: Field, density: Field, gas_constant: float) -> None:
    """Pressure, and the temperature at which air has the density of the deck."""
    value = context.put("ambient.pressure", pressure, "pressure", 101325.0)
    if not density.number:
        return
    warm = value / (context.si(density, "density") * gas_constant)
    if 200.0 <= warm <= 400.0:
        context.set("ambient.temperature", warm, density)
        context.report.mapped(density, warm, "ambient.temperature", "of air at that pressure and density")
    else:
        context.report.approximated(density, f"air would be at {warm:.4g} K: 293 K is used", 293.0)
        context.set("ambient.temperature", 293.0, density)


def simple(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    f = context.card(cards, "gas")
    f |= context.card(cards, "molar", optional=True)
    if f["LOU"].whole:
        report.refused(f["LOU"], "a curve of exit flow against gauge pressure has no counterpart")
    _one_gas(context, f, f["LCID"], None)
    _outside(context, f["PE"], f["RO"], GAS_CONSTANT / AIR)
    for name in ("MU", "AREA"):
        if f[name].number < 0.0:
            report.refused(f[name], "a curve against pressure has no counterpart: give a number")
    if f["MU"].number > 0.0 and f["AREA"].number > 0.0:
        report.mapped(f["MU"], f["MU"].number)
        report.mapped(f["AREA"], context.si(f["AREA"], "area"))
        context.tables.setdefault("gas", {})["orifices"] = [{
            "name": "exit", "between": ["bag", "ambient"], "area": said(context.si(f["AREA"], "area"), f["AREA"]),
            "discharge": said(f["MU"].number, f["MU"]),
        }]  # fmt: skip
    return airbag


def wang_nefske(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    f = context.card(cards, "gas")
    exits = context.card(cards, "exits")
    ambient = context.card(cards, "ambient")
    molar, options = f["CV"].number == 0.0, block.name.split("_")
    further = molar + ("POP" in options) + 2 * ("JETTING" in options) + ("CM" in options)
    # The card of the inflator is there even if it is blank; some programs leave it out.
    if cards.next_is_blank or cards.left > further:
        for one in context.card(cards, "inflator").values():
            if one.number:
                report.refused(one, "an inflator's tank has no counterpart here: give its mass flow; see billow tank")
    if molar:
        f |= context.card(cards, "molar", optional=True)
    for name in ("TVOL", "LCDT"):
        if f[name].number:
            report.refused(f[name], "an inflator's tank has no counterpart here: give its mass flow; see billow tank")
    if f["IABT"].whole:
        report.refused(f["IABT"], "no counterpart")
    _one_gas(context, f, f["LCMT"], f["LCT"])
    _outside(context, ambient["PE"], ambient["RO"], GAS_CONSTANT / AIR)
    if ambient["GC"].number in (0.0, 1.0):
        report.mapped(ambient["GC"], 1.0, "units", "the units are consistent")
    else:
        report.refused(ambient["GC"], "the gas is not in the units of the model: convert its numbers, and set GC to 1")
    if ambient["LCEFR"].whole:
        report.refused(ambient["LCEFR"], "a curve of exit flow against gauge pressure has no counterpart")
    airbag.option = ambient["OPT"].whole
    report.mapped(ambient["OPT"], ambient["OPT"].whole, "leakage.law", "counts where FVOPT of the fabric is 0")
    exits_of(context, exits | {"PPOP": ambient["PPOP"]}, airbag)
    if ambient["POVER"].number:
        over = context.si(ambient["POVER"], "pressure")
        context.set("gas.initial.pressure", plain(context.tables["ambient"])["pressure"] + over, ambient["POVER"])
        report.mapped(ambient["POVER"], over)
    if ambient["KNKDN"].number:
        report.refused(ambient["KNKDN"], "pressures of a case act in full")
    if "POP" in options:
        _pop(context, context.card(cards, "pop", optional=True), ambient["PPOP"])
    if "MULTIPLE" in options:
        for card in ("many jets", "jet ends"):
            for one in context.card(cards, card, optional=True).values():
                report.refused(one, "a field of many jets has no counterpart: it is left out")
    elif "JETTING" in options:
        put_jet(context, cards, airbag)
    return airbag


def _pop(context: Context, f: dict[str, Field], pressure: Field) -> None:
    """Conditions beside PPOP under which exits open."""
    if f["TDP"].number and pressure.number:
        context.report.refused(
            f["TDP"], "vents open as soon as PPOP is reached: raise PPOP, or set bag.vents.burst_time"
        )
    for name in ("AXP", "AYP", "AZP", "AMAGP", "TDURP", "TDA", "RBIDP"):
        if f[name].number:
            context.report.refused(f[name], "an acceleration that opens vents: set bag.vents.burst_time")
