"""*AIRBAG_PARTICLE as the corpuscular gas."""

from __future__ import annotations

import numpy as np

from billow.decks.airbag_gas import (
    AIR,
    Airbag,
    flow_of,
    put_inflator,
    put_species,
    temperature_of,
)
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.cpm_chambers import put_chambers, put_opening, put_source, walls, within
from billow.decks.draft import Said, plain, said


def head(context: Context, block: Block) -> tuple[Cards, dict[str, Field], dict[str, Field]]:
    """The cards of the bag and of particles, with those that options insert; and the cards that are left."""
    options, report = block.name.split("_"), context.report
    cards = Cards(context.model.deck.parameters, block)
    if "MPP" in options:
        for one in context.card(cards, "mpp").values():
            report.ignored(one, "how the work is shared out to processors")
    if "ID" in options:
        cards.text()
    if "TIME" in options:
        _life(context, context.card(cards, "time"))
    bag = context.card(cards, "bag")
    if "SEGMENT" in options:
        for one in context.card(cards, "segment").values():
            report.refused(one, "segments that bound the volume: the parts of SID1 are used")
    main = context.card(cards, "particles")
    if "JET" in options:
        for one in context.card(cards, "jet").values():
            report.refused(one, "the thrust on a node: give it to the body")
    return cards, bag, main


def particle(context: Context, block: Block) -> Airbag:
    options, report = block.name.split("_"), context.report
    cards, f, main = head(context, block)
    parts, kind = f["SID1"], f["STYPE1"].whole
    report.mapped(parts, "part set" if kind else "part")
    report.mapped(f["STYPE1"], kind)
    members = context.model.set_of("PART", parts.whole, parts.shown, parts.place) if kind else np.array([parts.whole])
    airbag = Airbag(block, members, None, parts.place)
    if f["FRIC"].number:
        report.refused(f["FRIC"], "particles are reflected diffusely in Billow; friction has no counterpart")
    context.set("gas.model", "corpuscular", f"{block.place} {block.name}")
    context.set("gas.particles", int(min(max(main["NP"].number or 200_000, 1000), 20_000_000)), main["NP"])
    report.mapped(main["NP"], main["NP"].whole or 200_000)
    report.mapped(main["UNIT"], context.units.name, note="it tells the units")
    patm = main["PATM"]
    if patm.number == 1.0 and context.si(patm, "pressure") < 1e3:
        report.mapped(patm, 101325.0, note="1 atm")
        context.set("ambient.pressure", 101325.0, patm)
    else:
        context.put("ambient.pressure", patm, "pressure", 101325.0)
    context.put("ambient.temperature", main["TATM"], "-", 293.0)
    if 0.0 < main["TSW"].number < 1e10:
        context.put("gas.switch_time", main["TSW"], "time")
    for card in ("tracking", "more tracking"):
        if cards.starts_with(b"+"):
            cards.unsign()
            context.card(cards, card)
    if main["UNIT"].whole == 3:
        context.card(cards, "units")
    gases = context.card(cards, "gases")
    counts = {name: gases[name].whole for name in ("NGAS", "NORIF", "IAIR")}
    for name in ("NGAS", "NORIF"):
        report.mapped(gases[name], counts[name], "inflator")
    inner = f["SID2"].whole if f["STYPE2"].whole == 2 else 0
    for k in range(inner):
        context.card(cards, "inner part", f"[{k + 1}]")
    if gases["CHM"].whole:
        put_chambers(context, airbag, gases["CHM"])
    if f["SID2"].whole:
        walls(context, airbag, f)
    for k in range(f["NPDATA"].whole):
        heat = context.card(cards, "heat", f"[{k + 1}]")
        if heat["HCONV"].number:
            report.refused(heat["HCONV"], "heat transfer of single parts: gas.heat_transfer is that of all fabric")
    for k in range(main["NVENT"].whole):
        _particle_vent(context, context.card(cards, "vent", f"[{k + 1}]"), airbag)
    if counts["IAIR"]:
        _air(context, context.card(cards, "air"))
        report.mapped(gases["IAIR"], counts["IAIR"], "gas.initial")
    else:
        report.approximated(gases["IAIR"], "no air at the start; a case always holds ambient air")
    infos, total = [], context.card(cards, "mole fractions")["LCMASS"] if "MOLEFRACTION" in options else None
    for k in range(1, counts["NGAS"] + 1):
        g = context.card(cards, "gas", f"[{k}]")
        mass = context.si(g["XM"], "molar mass")
        heats = [context.si(g[one], "molar heat") for one in "ABC"]
        for one, value in zip(("XM", *"ABC"), (mass, *heats), strict=True):
            report.mapped(g[one], value)
        name = f"gas_{k}"
        put_species(context, name, mass, *heats, g["XM"])
        if total is None:
            flow = flow_of(context, g["LCM"])
        else:  # a share of moles; masses follow once all gases are known
            flow = said(context.curve(g["LCM"], "time", "-", "a share of moles"), g["LCM"])
            report.approximated(g["LCM"], f"curve {g['LCM'].whole}: LCMASS times its share of mass, exact at points")
        put_inflator(context, name, name, flow, temperature_of(context, g["LCT"], flow))
        infos.append(g["INFG"].whole or 1)
        report.mapped(g["INFG"], infos[-1])
    if total is not None:
        _share_out(context, total)
    for k in range(1, counts["NORIF"] + 1):
        o = context.card(cards, "orifice", f"[{k}]")
        for number, info in enumerate(infos):
            if info == (o["INFO"].whole or 1):
                row = (o["NID"], o["NID"].whole, context.si(o["AN"], "area"), o["VD"].whole, o["CA"].number or 30.0)
                airbag.orifices.setdefault(number, []).append(row)
        for name in ("AN", "CA", "INFO"):
            report.mapped(o[name], context.si(o[name], "area") if name == "AN" else o[name].number)
        if airbag.chambers and o["CHM_ID"].whole:
            put_source(context, airbag, o, infos)
    blocking = f["BLOCK"].whole % 10
    if blocking:
        context.set("leakage.blockage", True, f["BLOCK"])
        if airbag.vents and blocking not in (2, 4):
            context.set("bag.vents.blockage", True, f["BLOCK"])
        report.mapped(f["BLOCK"], blocking)
    return airbag


def _life(context: Context, f: dict[str, Field]) -> None:
    """When the airbag is there."""
    if f["BIRTH"].number > 0.0:
        context.report.refused(f["BIRTH"], "a gas that comes later: set inflator.delay")
    if 0.0 < f["DEATH"].number < 1e20:
        context.report.refused(f["DEATH"], "a gas that goes: let the run end then, run.end_time")


def _share_out(context: Context, total: Field) -> None:
    """Mass flows of inflators that hold shares x of moles: m x M / sum(x M), at the points of all curves."""
    whole = context.curve(total, "time", "mass flow", "a mass flow")
    context.report.mapped(total, f"curve {total.whole}")
    inflators, species = context.tables["inflator"], context.tables["gas"]["species"]
    time = np.unique(np.concatenate([whole["time"], *(one["mass_flow"].value["time"] for one in inflators)]))
    moles = np.array([
        np.interp(time, one["mass_flow"].value["time"], one["mass_flow"].value["value"])
        * plain(species[one["name"]])["molar_mass"]
        for one in inflators
    ])  # fmt: skip
    sums = moles.sum(axis=0)
    flow = np.interp(time, whole["time"], whole["value"], left=0.0, right=0.0)
    for one, mole in zip(inflators, moles, strict=True):
        value = flow * np.divide(mole, sums, out=np.zeros_like(mole), where=sums > 0.0)
        one["mass_flow"] = Said({"time": time.tolist(), "value": value.tolist()}, one["mass_flow"].source)


UNIT_SYSTEMS = {"0": "kg-mm-ms", "1": "kg-m-s", "2": "t-mm-s"}
"""What UNIT says."""


def _particle_vent(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    report, one = context.report, f["SID3"]
    if f["STYPE3"].whole:
        parts = set(context.model.set_of("PART", one.whole, one.shown, one.place).tolist())
    else:
        parts = {one.whole}
    report.mapped(one, one.whole)
    report.mapped(f["STYPE3"], f["STYPE3"].whole)
    inner = within(airbag) & parts
    if inner:
        put_opening(context, f, airbag, inner)
        parts -= inner
    if not parts:
        return
    airbag.vents |= parts
    value: object = f["C23"].number if not f["C23"].is_blank else 1.0
    source = f["C23"]
    if f["LCTC23"].whole:
        value, source = context.curve(f["LCTC23"], "time", "-", "a discharge coefficient"), f["LCTC23"]
        report.mapped(source, f"curve {source.whole}")
    if f["LCPC23"].whole:
        report.refused(f["LCPC23"], "a discharge against pressure: set bag.vents.area_factor yourself")
    vents = context.tables.get("bag", {}).get("vents", {})
    if "discharge" in vents and vents["discharge"].value != value:
        report.refused(f["C23"], "the vents of a case share one discharge coefficient; that of the first is used")
        return
    context.set("bag.vents.discharge", value, source)
    report.mapped(f["C23"], value if isinstance(value, float) else "curve", "bag.vents.discharge")
    if f["PPOP"].number:
        context.put("bag.vents.opening_pressure", f["PPOP"], "pressure")


def _air(context: Context, f: dict[str, Field]) -> None:
    mass = context.si(f["XMAIR"], "molar mass") or AIR
    heats = [context.si(f[name], "molar heat") for name in ("AAIR", "BAIR", "CAIR")]
    if not heats[0]:
        raise f["AAIR"].bad("a gas has a heat capacity")
    for name, value in zip(("XMAIR", "AAIR", "BAIR", "CAIR"), (mass, *heats), strict=True):
        context.report.mapped(f[name], value)
    put_species(context, "air_at_start", mass, *heats, f["XMAIR"])
    context.tables.setdefault("gas", {})["initial"] = {"gas": {"air_at_start": 1.0}}
    if f["PAIR"].number:
        context.put("gas.initial.pressure", f["PAIR"], "pressure")
    if f["TAIR"].number:
        context.put("gas.initial.temperature", f["TAIR"], "-")
