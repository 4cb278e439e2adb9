"""/MONVOL/AIRBAG1: uniform pressure, with gases of /MAT/GAS, injectors of /PROP/INJECT1, vents and porous surfaces.

Holes of Iform 1 obey the isentropic nozzle law, as those of a case. A vent opens when the pressure inside exceeds dPdef
for dtPdef, or at Tstart; with Tstart 0 that is at once (reference guide; OpenRadioss, airbagb1.F).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from billow.decks.airbag_gas import AIR, GAS_CONSTANT, Airbag, put_species
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import plain, said
from billow.decks.radioss.columns import TARGETS, card
from billow.decks.radioss.starter_model import StarterModel, kind_of, words
from billow.decks.report import Report

KEY, COMMUNICATES = "MONVOL/AIRBAG1", "MONVOL/COMMU1"
HOTTEST = 1500.0
"""Temperature [K] up to which terms of a heat capacity beyond T^2 are fitted."""
PREDEFINED = {"N2", "O2", "CO2", "CO", "AR", "HE", "H2", "H2O"}
SPELLED = {"AR": "Ar", "HE": "He"}


def airbag1(context: Context, block: Block) -> Airbag:
    """The tables of the gas. Raises InputError for fields that cannot be used."""
    return _volume(context, block)[0]


def communications(context: Context, block: Block) -> list[dict[str, Field]]:
    """What /MONVOL/COMMU1 says of each bag that it is open to. The cards before are read again, into nothing."""
    unseen = replace(context, tables={"bag": {}, "gas": {}}, report=Report())
    cards = _volume(unseen, block)[1]
    own, found = replace(context, units=context.model.deck.units_of(block)), []
    count = card(own, cards, COMMUNICATES, "bags")["Nbag"]
    context.report.mapped(count, count.whole, "gas.orifices")
    for k in range(1, count.whole + 1):
        f = card(own, cards, COMMUNICATES, "bag", f"[{k}]") | card(own, cards, COMMUNICATES, "area", f"[{k}]")
        found.append(f)
    return found


def _volume(context: Context, block: Block) -> tuple[Airbag, Cards]:
    model: StarterModel = context.model
    context = replace(context, units=model.deck.units_of(block))
    cards, report = model.cards(block), context.report
    f = card(context, cards, KEY, "surface")
    parts, segments = model.surface(f["surf_IDex"].whole, f["surf_IDex"])
    mapped(context, f["surf_IDex"], f"parts {', '.join(map(str, parts.tolist()))}" if len(parts) else "segments")
    if len(segments):
        segments = np.concatenate([model.shells.corners[np.isin(model.shells.part, parts)], segments])
    found = Airbag(block, None if len(segments) else parts, (segments, f["surf_IDex"].place) if len(segments) else None,
                   f["surf_IDex"].place)  # fmt: skip
    if f["Hconv"].number:
        context.put("gas.heat_transfer", f["Hconv"], "heat transfer")
    scales = {name: one.number or 1.0 for name, one in card(context, cards, KEY, "scales").items()}
    _state(context, card(context, cards, KEY, "gas"))
    count = card(context, cards, KEY, "injectors")["Njet"]
    report.mapped(count, count.whole, "inflator")
    for k in range(1, count.whole + 1):
        _injector(context, cards, f"[{k}]")
    holes = card(context, cards, KEY, "holes")
    for name in holes:
        report.mapped(holes[name], holes[name].whole, "bag.vents" if name == "Nvent" else "gas.orifices")
    blocks = any(_closes(model, b) for b in model.find("INTER"))
    for k in range(1, holes["Nvent"].whole + 1):
        _vent(context, cards, f"[{k}]", found, scales, blocks)
    for k in range(1, holes["Nporsurf"].whole + 1):
        _porous(context, cards, f"[{k}]")
    return found, cards


def mapped(context: Context, one: Field, value: object = "", note: str = "") -> None:
    context.report.mapped(one, value, TARGETS.get(one.name, ""), note)


def _closes(model: StarterModel, block: Block) -> bool:
    """Whether an interface closes vents that it touches: Ibag."""
    cards = model.cards(block)
    names = "ids_s surf_IDm Istf Ithe Igap Iedge Ibag"
    return kind_of(block) in ("TYPE7", "TYPE19") and cards.left > 0 and cards.card("sides", names)["Ibag"].text == "1"


def _state(context: Context, f: dict[str, Field]) -> None:
    report = context.report
    context.put("ambient.pressure", f["Pext"], "pressure", 101325.0)
    name = gas(context, f["mat_ID"])
    warm = f["T0"].number or 295.0
    context.tables.setdefault("gas", {})["initial"] = {
        "gas": {name: said(1.0, f["mat_ID"])}, "temperature": said(warm, f["T0"])
    }  # fmt: skip
    mapped(context, f["mat_ID"], name)
    mapped(context, f["T0"], warm)
    context.set("ambient.temperature", min(max(warm, 200.0), 400.0), f["T0"])
    report.ignored(f["Mu"], "the gas has no bulk viscosity; fabric has damping of its own")
    if f["Iequil"].whole:
        report.approximated(f["Iequil"], "the gas at the start fills the volume at time 0, not that of the first jet")
    if f["Ittf"].whole:
        report.refused(f["Ittf"], "times of vents count from 0: add the time of the first injector to them")


def gas(context: Context, one: Field) -> str:
    """Name of a /MAT/GAS as a species of the case. Raises InputError E-DCK-006."""
    model: StarterModel = context.model
    block = model.one(one.whole, one, "MAT", "GAS")
    context = replace(context, units=model.deck.units_of(block))
    kind, name = (*words(block), "", "")[2], f"gas_{one.whole}"
    if name in context.tables.setdefault("gas", {}).get("species", {}):
        return name
    cards = model.cards(block)
    if kind == "PREDEF":
        f = card(context, cards, "MAT/GAS", "name")["Gas"]
        if f.text.upper() == "AIR":
            put_species(context, name, AIR, 29.1, 0.0, 0.0, f)
            context.report.approximated(f, "air of 28.965 g/mol and cp 29.1 J/(mol K)", key="gas.species")
            return name
        if f.text.upper() not in PREDEFINED:
            raise f.bad("a gas that Billow's library lacks", "give its molar mass and heat capacity: /MAT/GAS/MOLE")
        context.report.mapped(f, f.text, "gas", "of Billow's library")
        return SPELLED.get(f.text.upper(), f.text.upper())
    if kind == "CSTA":
        f = card(context, cards, "MAT/GAS", "constant")
        cp, cv = (context.si(f[n], "specific heat") for n in ("Cp", "Cv"))
        if not cp > cv > 0.0:
            raise f["Cp"].bad("a gas has a larger heat at constant pressure than at constant volume")
        mass = GAS_CONSTANT / (cp - cv)
        put_species(context, name, mass, cp * mass, 0.0, 0.0, f["Cp"])
        for n, value in (("Cp", cp), ("Cv", cv)):
            mapped(context, f[n], value, f"gas of {1e3 * mass:.4g} g/mol")
        return name
    f = card(context, cards, "MAT/GAS", "mass") | card(context, cards, "MAT/GAS", "heat")
    if kind == "MASS":
        f |= card(context, cards, "MAT/GAS", "more", optional=True)
    mass = context.si(f["MW"], "molar mass")
    if not mass > 0.0:
        raise f["MW"].bad("a gas has a molar mass")
    names = [n for n in ("Cpa", "Cpb", "Cpc", "Cpd", "Cpe", "Cpf") if n in f]
    dimension, factor = ("specific heat", mass) if kind == "MASS" else ("molar heat", 1.0)
    terms = [factor * context.si(f[n], dimension) for n in names] + [0.0] * (6 - len(names))
    mapped(context, f["MW"], mass)
    if any(terms[3:]):
        t = np.linspace(250.0, HOTTEST, 126)
        cp = terms[0] + t * (terms[1] + t * (terms[2] + t * terms[3])) + terms[4] / t**2 + terms[5] * t**4
        fit = np.polyfit(t, cp, 2)
        off = float(np.abs(np.polyval(fit, t) / cp - 1.0).max())
        terms[:3] = fit[::-1].tolist()
        for n in names:
            how = f"cp as A + B T + C T^2, within {100 * off:.2g} % from 250 to {HOTTEST:g} K"
            context.report.approximated(f[n], how, key="gas.species")
    else:
        for n, value in zip(names, terms, strict=False):
            mapped(context, f[n], value)
    put_species(context, name, mass, *terms[:3], f["MW"])
    return name


def _injector(context: Context, cards: Cards, part: str) -> None:
    """An injector; each of its gases becomes an inflator, because each has a flow and a temperature of its own."""
    model, report = context.model, context.report
    f = card(context, cards, KEY, "injector", part)
    if f["Ijet"].whole:
        for one in (*card(context, cards, KEY, "jet", part).values(), f["Ijet"]):
            if one.number:
                report.refused(one, "pressure of a jet by functions: set inflator.jets, and gas.model if they matter")
    block = model.one(f["inject_ID"].whole, f["inject_ID"], "PROP", "INJECT1")
    mapped(context, f["inject_ID"], f["inject_ID"].whole)
    delay = _delay(context, f["sens_ID"])
    own = replace(context, units=model.deck.units_of(block))
    rows = model.cards(block)
    head = card(own, rows, "PROP/INJECT1", "injector")
    report.mapped(head["N_gases"], head["N_gases"].whole, "inflator")
    slow = head["Ascale_T"].number or 1.0
    for k in range(1, head["N_gases"].whole + 1):
        g = card(own, rows, "PROP/INJECT1", "gas", f"[{k}]")
        name = gas(own, g["Mat_ID"])
        mapped(context, g["Mat_ID"], name)
        flow = _flow(own, g, head["Iflow"], slow)
        warm = own.curve(g["fun_ID_T"], "time", "-", "a temperature")
        values = (np.array(warm["value"]) * (g["Fscale_T"].number or 1.0)).tolist()
        warm = {"time": _stretched(warm["time"], slow), "value": values}
        mapped(context, g["fun_ID_T"], f"function {g['fun_ID_T'].whole}")
        for one in (g["Fscale_M"], g["Fscale_T"], head["Ascale_T"]):
            report.mapped(one, one.number or 1.0, "inflator")
        title = name
        taken = [plain(table)["name"] for table in context.tables.setdefault("inflator", [])]
        while title in taken:
            title += "_again"
        table = {
            "name": title, "gas": {name: 1.0}, "mass_flow": said(flow, g["fun_ID_M"]),
            "temperature": said(warm if np.ptp(values) else values[0], g["fun_ID_T"]), "jets": {"count": 0},
        }  # fmt: skip
        if delay:
            table["delay"] = said(delay, f["sens_ID"])
        context.tables["inflator"].append(table)


def _stretched(times: list[float], slow: float) -> list[float]:
    return times if slow == 1.0 else (slow * np.array(times)).tolist()


def _flow(context: Context, g: dict[str, Field], kind: Field, slow: float) -> dict[str, list[float]]:
    """Mass flow [kg/s]; of a mass against time its slopes, in steps."""
    one, factor = g["fun_ID_M"], g["Fscale_M"].number or 1.0
    if kind.whole == 1:
        curve = context.curve(one, "time", "mass flow", "a mass flow")
        value = factor * np.array(curve["value"])
        mapped(context, one, f"function {one.whole}")
        context.report.mapped(kind, "a mass flow", "inflator.mass_flow")
        if (value < 0.0).any():
            context.report.approximated(one, "a mass flow below zero is taken as 0", key="inflator.mass_flow")
        return {"time": _stretched(curve["time"], slow), "value": np.maximum(value, 0.0).tolist()}
    curve = context.curve(one, "time", "mass", "a mass")
    time, mass = np.array(_stretched(curve["time"], slow)), factor * np.array(curve["value"])
    slopes = np.maximum(np.diff(mass) / np.diff(time), 0.0)
    step = 1e-3 * float(np.diff(time).min())
    how = f"slopes of a mass against time, in steps {step:.2g} s long"
    context.report.approximated(one, how, key="inflator.mass_flow")
    context.report.mapped(kind, "a mass", "inflator.mass_flow")
    times = np.column_stack([time[:-1], time[1:] - step]).ravel()
    return {"time": times.tolist(), "value": np.repeat(slopes, 2).tolist()}


def _delay(context: Context, one: Field) -> float:
    """Time [s] of a sensor; 0 without one."""
    if not one.whole:
        return 0.0
    model: StarterModel = context.model
    block = model.one(one.whole, one, "SENSOR")
    if kind_of(block) != "TIME":
        context.report.refused(one, f"{block.shown} is not read: set inflator.delay")
        return 0.0
    own = replace(context, units=model.deck.units_of(block))
    f = card(own, model.cards(block), "SENSOR/TIME", "sensor")["Tdelay"]
    delay = own.si(f, "time")
    mapped(context, one, delay)
    context.report.mapped(f, delay, "inflator.delay")
    return delay


def _vent(context: Context, cards: Cards, part: str, found: Airbag, scales: dict[str, float], blocks: bool) -> None:
    report, model = context.report, context.model
    f = card(context, cards, KEY, "vent", part) | card(context, cards, KEY, "opening", part)
    factors, blocked = (card(context, cards, KEY, name, part) for name in ("factors", "blocked"))
    if f["Iform"].whole == 2:
        for one in (*card(context, cards, KEY, "velocity", part).values(), f["Iform"]):
            report.refused(one, "a speed of the flow against pressure; holes of a case obey the nozzle law")
    elif f["Iform"].whole not in (0, 1, 4):
        report.refused(f["Iform"], "holes of a case obey the nozzle law")
    else:
        report.mapped(f["Iform"], "nozzle law", note="gas also flows in when the pressure inside is below that outside")
    for one in (*blocked.values(), factors["fct_IDA"], f["Tstop"]):
        if one.number and (one.name.startswith("fct") or one.name == "Tstop"):
            report.refused(one, "a vent of a case has a factor against time or pressure, and stays open: set bag.vents")
    curves = {}
    for name, scale, abscissa, axis in (
        ("fct_IDt", "Fscalet", "Ascalet", "time"), ("fct_IDP", "FscaleP", "AscaleP", "pressure"),
    ):  # fmt: skip
        if factors[name].whole:
            curve = context.curve(factors[name], axis, "-", "a factor on a vent", axis)
            values = (np.array(curve["value"]) * (factors[scale].number or 1.0)).tolist()
            curves[name] = {axis: _stretched(curve[axis], scales[abscissa]), "value": values}
            mapped(context, factors[name], f"function {factors[name].whole}")
            report.mapped(factors[scale], factors[scale].number or 1.0, TARGETS[name])
    if not f["surf_IDv"].whole:
        _hole(context, f, curves, factors)
        return
    parts, segments = model.surface(f["surf_IDv"].whole, f["surf_IDv"])
    if len(segments):
        report.refused(f["surf_IDv"], "a vent of segments: make them a part")
        return
    flow = context.tables.setdefault("bag", {}).get("vents")
    table = _flow_of_vents(context, f, curves, factors, blocks)
    if flow is not None and plain(flow) != plain(table):
        report.refused(f["surf_IDv"], "the vents of a case share one law; that of the first is used")
    found.vents |= set(parts.tolist())
    mapped(context, f["surf_IDv"], f"parts {', '.join(map(str, parts.tolist()))}")
    context.tables["bag"].setdefault("vents", table)


def _flow_of_vents(context: Context, f, curves, factors, blocks: bool) -> dict[str, object]:
    report, share = context.report, f["Avent"].number or 1.0
    table: dict[str, object] = {"discharge": said(min(share, 1.0), f["Avent"])}
    if "fct_IDt" in curves:
        curve = curves["fct_IDt"] | {"value": (min(share, 1.0) * np.array(curves["fct_IDt"]["value"])).tolist()}
        if max(curve["value"]) > 1.0:
            raise factors["fct_IDt"].bad("the area of a vent would be more than that of its part")
        table["discharge"] = said(curve, factors["fct_IDt"])
    if "fct_IDP" in curves:
        table["area_factor"] = said(curves["fct_IDP"], factors["fct_IDP"])
    if share > 1.0:
        if "fct_IDP" in curves:
            raise f["Avent"].bad("more than 1, with a function against pressure: put the factor into the function")
        table["area_factor"] = said(share, f["Avent"])
    mapped(context, f["Avent"], share)
    if f["Tstart"].number and f["Tstart"].number < 1e20:
        table["burst_time"] = said(min(context.si(f["Tstart"], "time"), 10.0), f["Tstart"])
        mapped(context, f["Tstart"], table["burst_time"].value)
    if f["dPdef"].number:
        if f["Tstart"].number:
            table["opening_pressure"] = said(context.si(f["dPdef"], "pressure"), f["dPdef"])
            mapped(context, f["dPdef"], table["opening_pressure"].value)
        else:
            report.ignored(f["dPdef"], "Tstart is 0: the vent is open from the start")
    if f["dtPdef"].number and f["Tstart"].number:
        report.approximated(f["dtPdef"], "the vent opens as soon as dPdef is reached", key="bag.vents.opening_pressure")
    if blocks:
        table["blockage"] = said(True, "INTER Ibag = 1")
        through = min(f["Bvent"].number / share, 1.0)
        table["through_blocked"] = said(through, f["Bvent"])
        mapped(context, f["Bvent"], through)
    else:
        report.ignored(f["Bvent"], "no interface closes vents: Ibag is not 1")
    return table


def _hole(context: Context, f, curves, factors) -> None:
    """A hole of a given area, beside the mesh."""
    report, area = context.report, context.si(f["Avent"], "area")
    mapped(context, f["Avent"], area)
    report.ignored(f["surf_IDv"], "0: Avent is the area")
    if not area:
        return
    for one in (f["dPdef"], f["Tstart"]):
        if one.number:
            report.refused(one, "an orifice of a case is always open; make it a part of the bag to let it burst")
    if "fct_IDP" in curves:
        report.refused(factors["fct_IDP"], "an orifice has a factor against time only; make it a part of the bag")
    _orifice(context, area, curves.get("fct_IDt", 1.0), f["Avent"])


def _orifice(context: Context, area: float, discharge: object, one: Field) -> None:
    orifices = context.tables.setdefault("gas", {}).setdefault("orifices", [])
    orifices.append({
        "name": f"hole_{len(orifices) + 1}", "between": ["bag", "ambient"], "area": said(area, one),
        "discharge": said(discharge, one),
    })  # fmt: skip


def _porous(context: Context, cards: Cards, part: str) -> None:
    """A constant area of leakage becomes an orifice; laws of the fabric are refused."""
    report = context.report
    f = card(context, cards, KEY, "porous", part) | card(context, cards, KEY, "opening", part)
    if f["Iformps"].whole == 0:
        p = card(context, cards, KEY, "porosity", part)
        for name in ("fct_IDcps", "fct_IDaps"):
            if p[name].whole and not p["Cps" if name == "fct_IDcps" else "Areaps"].number:
                report.refused(p[name], "a leakage by functions: write [leakage]")
        area, share = context.si(p["Areaps"], "area"), p["Cps"].number
        if area and share:
            discharge = min(share, 1.0)
            _orifice(context, area * share / discharge, discharge, p["Areaps"])
            mapped(context, p["Areaps"], area)
            mapped(context, p["Cps"], share)
        for name in ("Tstart", "Tstop", "dPdef"):
            if f[name].number:
                report.refused(f[name], "an orifice of a case is always open")
        return
    if f["Iformps"].whole == 2:
        card(context, cards, KEY, "velocity", part)
    for name in ("surf_IDps", "Iformps"):
        report.refused(f[name], "leakage by /LEAK/MAT is not read: write [leakage.parts] of these parts")
