"""*AIRBAG_... as the tables `[gas]`, `[[inflator]]`, `[ambient]`, and what of the bag they decide.

Each gas of a deck has its own mass flow and temperature, so it becomes an inflator of one species. Exits of HYBRID and
WANG_NEFSKE obey the nozzle law (Wang and Nefske, SAE 880654), as do orifices of a case.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.fields import known

NO_CHOICE = InputError.declare(
    "E-DCK-015",
    "the deck has {count} airbags of which none was chosen",
    where="{place}",
    why="they are {listed}; their coupling by *AIRBAG_INTERACTION is not read",
    cause="a model with several cushions",
    remedy="choose one by its number in this list: --airbag 1",
)
NOT_READ = InputError.declare(
    "E-DCK-016",
    "*{keyword} cannot be imported",
    where="{place}",
    cause="an airbag of a kind that Billow does not have",
    remedy="use *AIRBAG_HYBRID or *AIRBAG_PARTICLE; or take the mesh alone, with --base CASE.toml for the rest",
)

GAS_CONSTANT = 8.31446261815324
AIR = 0.0289652
"""Molar mass [kg/mol] of air."""
NITROGEN = 0.0280134
READ = (
    "AIRBAG_HYBRID", "AIRBAG_PARTICLE", "AIRBAG_WANG_NEFSKE", "AIRBAG_SIMPLE_AIRBAG_MODEL",
)  # fmt: skip
WHY_NOT = {
    "AIRBAG_LINEAR_FLUID": "it is filled with a liquid",
    "AIRBAG_ALE": "its gas is a mesh; Billow's gases are uniform pressure and particles",
    "AIRBAG_ADVANCED_ALE": "its gas is a mesh; Billow's gases are uniform pressure and particles",
    "AIRBAG_SIMPLE_PRESSURE_VOLUME": "pressure is a function of volume there, and no gas flows",
    "AIRBAG_ADIABATIC_GAS_MODEL": "its gas is not injected, and a case has an inflator or no gas",
    "AIRBAG_LOAD_CURVE": "pressure is given there, and no gas flows",
    "AIRBAG_HYBRID_CHEMKIN": "its gases are in a data base of its own",
}


@dataclass
class Airbag:
    """What the mesh needs to know of the airbag's cards. parts: ids, or None for segments. vents: parts that are vents.
    orifices: nodes, areas [m^2], vectors and cones of jets by inflator number. option: OPT, how fabric leaks."""

    block: Block
    parts: np.ndarray | None
    segments: tuple[np.ndarray, str] | None
    place: str
    vents: set[int] = field(default_factory=set)
    orifices: dict[int, list[tuple[Field, int, float, int, float]]] = field(default_factory=dict)
    option: int = 0


def choose(blocks: list[Block], wanted: int | None) -> Block | None:
    """The airbag to import, None if the deck has none. Raises InputError E-DCK-015, -016."""
    bags = [b for b in blocks if (known(b.name) in READ or _why_not(b.name)) and "REFERENCE" not in b.name]
    bags = [b for b in bags if b.name not in ("AIRBAG_INTERACTION",)]
    if not bags:
        return None
    listed = "; ".join(f"{k}: *{b.name} at {b.place}" for k, b in enumerate(bags, 1))
    if wanted is None and len(bags) > 1:
        raise NO_CHOICE(count=len(bags), listed=listed, place=bags[0].place)
    if wanted is not None and not 1 <= wanted <= len(bags):
        raise NO_CHOICE(count=len(bags), place=bags[0].place, why=f"there is no {wanted}; {listed}")
    chosen = bags[(wanted or 1) - 1]
    why = _why_not(chosen.name)
    if why:
        raise NOT_READ(keyword=chosen.name, place=chosen.place, why=why)
    return chosen


def _why_not(name: str) -> str | None:
    found = max((k for k in WHY_NOT if name == k or name.startswith(k + "_")), key=len, default=None)
    return WHY_NOT[found] if found else None


def put_airbag(context: Context, block: Block) -> Airbag:
    """The tables of the gas. Raises InputError for fields that cannot be used."""
    return READERS[known(block.name)](context, block)


def _core(context: Context, cards: Cards) -> Airbag:
    f, report = context.card(cards, "core"), context.report
    for name, default in (("VSCA", 1.0), ("PSCA", 1.0), ("VINI", 0.0), ("MWD", 0.0), ("SPSF", 0.0)):
        if f[name].number not in (0.0, default):
            report.refused(f[name], "a case has no such factor; set it to its default in the deck")
    if f["RBID"].whole:
        raise f["RBID"].bad("sensors and user subroutines insert cards that are not read", "set RBID to 0")
    if f["SIDTYP"].whole == 0:
        report.mapped(f["SID"], "segment set")
        found = context.model.segments(f["SID"].whole, f["SID"].shown, f["SID"].place)
        return Airbag(cards.block, None, found, f["SID"].place)
    report.mapped(f["SID"], "part set")
    report.mapped(f["SIDTYP"], "part set")
    parts = context.model.set_of("PART", f["SID"].whole, f["SID"].shown, f["SID"].place)
    return Airbag(cards.block, parts, None, f["SID"].place)


def _exits(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    """Orifices of A23 and AP23, or vents of the parts that they name."""
    report = context.report
    opens = f.get("PVENT") or f.get("PPOP")
    for name, area, discharge, curve, of_pressure in (
        ("exit", "A23", "C23", "LCC23", "LCA23"), ("porosity", "AP23", "CP23", "LCCP23", "LCAP23"),
    ):  # fmt: skip
        given = f[area].number
        if f[of_pressure].whole and given:
            report.ignored(f[of_pressure], f"a {area} that is not zero counts")
        elif f[of_pressure].whole:
            report.refused(f[of_pressure], "area against pressure: make the exit a part, and set its area_factor")
        if not given:
            for one in (f[area], f[discharge]):
                report.ignored(one, f"{area} is 0: nothing leaves here")
            continue
        value: object = 1.0 if f[discharge].is_blank and not f[curve].whole else f[discharge].number
        source = f[discharge]
        if f[discharge].number < 0.0:
            raise f[discharge].bad("a discharge coefficient is not negative")
        if f[curve].whole and f[discharge].number:
            report.ignored(f[curve], f"a {discharge} that is not zero counts")
        elif f[curve].whole:
            value, source = context.curve(f[curve], "time", "-", "a discharge coefficient"), f[curve]
            report.mapped(f[curve], f"curve {f[curve].whole}")
        if isinstance(value, float) and not value:
            report.ignored(f[area], f"{discharge} is 0")
            continue
        if given < 0.0 and name == "porosity":
            report.refused(f[area], f"leakage of part {-int(given)}: write [leakage.parts] of it")
            continue
        report.mapped(f[discharge], value if isinstance(value, float) else "curve")
        if given < 0.0:
            airbag.vents.add(abs(f[area].whole))
            report.mapped(f[area], f"part {abs(f[area].whole)}", "bag.parts")
            context.set("bag.vents.discharge", value, source)
            if opens is not None and opens.number > 0.0:
                context.put("bag.vents.opening_pressure", opens, "pressure")
            continue
        size = context.si(f[area], "area")
        report.mapped(f[area], size)
        context.tables.setdefault("gas", {}).setdefault("orifices", []).append({
            "name": name, "between": ["bag", "ambient"], "area": said(size, f[area]), "discharge": said(value, source),
        })  # fmt: skip
        if opens is not None and opens.number > 0.0 and not report.settled(opens):
            report.refused(opens, "an orifice of a case is always open; make the exit a part, A23 < 0, to let it burst")


def _gas(context: Context, name: str, molar_mass: float, a: float, b: float, c: float, source: Field) -> None:
    """A species of `[gas.species]`."""
    species = context.tables.setdefault("gas", {}).setdefault("species", {})
    terms = {"molar_mass": molar_mass, "a": a, "b": b, "c": c}
    species[name] = {key: said(value, source) for key, value in terms.items() if value or key in ("molar_mass", "a")}


def _inflator(context: Context, name: str, gas: str, flow: Said, temperature: Said) -> None:
    context.tables.setdefault("inflator", []).append(
        {"name": name, "gas": {gas: 1.0}, "mass_flow": flow, "temperature": temperature, "jets": {"count": 0}}
    )


def _flow(context: Context, one: Field, number: str = "") -> Said:
    curve = context.curve(one, "time", "mass flow", "a mass flow")
    value = np.array(curve["value"])
    if (value < 0.0).any():
        context.report.approximated(one, f"curve {one.whole}: a mass flow below zero is taken as 0")
        curve["value"] = np.maximum(value, 0.0).tolist()
    else:
        context.report.mapped(one, f"curve {one.whole}")
    return said(curve, one)


def _temperature(context: Context, one: Field, flow: Said) -> Said:
    """A curve of temperatures; those that no gas has, because none flows then, become the nearest that some has."""
    curve = context.curve(one, "time", "-", "a temperature")
    time, value = np.array(curve["time"]), np.array(curve["value"])
    if np.ptp(value) == 0.0:
        context.report.mapped(one, float(value[0]))
        return said(float(value[0]), one)
    flowing = np.interp(time, flow.value["time"], flow.value["value"], left=0.0, right=0.0) > 0.0
    cold = (value < 200.0) & ~flowing
    if cold.any() and flowing.any():
        value[cold] = np.interp(time[cold], time[~cold], value[~cold])
        curve["value"] = value.tolist()
        context.report.approximated(one, f"curve {one.whole}: {cold.sum()} points without flow, which are below 200 K")
    else:
        context.report.mapped(one, f"curve {one.whole}")
    return said(curve, one)


def _ambient(context: Context, pressure: Field, temperature: Field) -> None:
    context.put("ambient.pressure", pressure, "pressure", 101325.0)
    context.put("ambient.temperature", temperature, "-", 293.0)


def _hybrid(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = _core(context, cards)
    ambient = context.card(cards, "ambient")
    exits = context.card(cards, "exits")
    options = context.card(cards, "options")
    _ambient(context, ambient["ATMOSP"], ambient["ATMOST"])
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
    _exits(context, exits | {"PVENT": options["PVENT"]}, airbag)
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
        _gas(context, name, mass, *heats, f["MW"])
        for one, value in zip(("MW", *"ABC"), (mass, *heats), strict=True):
            report.mapped(f[one], value)
        if f["INITM"].number:
            initial[name] = said(f["INITM"].number, f["INITM"])
            report.mapped(f["INITM"], f["INITM"].number)
        if f["LCIDM"].whole:
            flow = _flow(context, f["LCIDM"])
            _inflator(context, name, name, flow, _temperature(context, f["LCIDT"], flow))
    if initial:
        _initial(context, initial)
    if "JETTING" in block.name and cards.left:
        for card in ("jet", "jet ends"):
            for one in context.card(cards, card, optional=True).values():
                if not one.is_blank:
                    report.refused(one, "uniform pressure with a jet: set inflator.jets and gas.model = corpuscular")
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
    curve = _flow(context, flow)
    if not f["CV"].number:
        mass, a = context.si(f["MW"], "molar mass"), context.si(f["A"], "molar heat")
        b = context.si(f["B"], "molar heat")
        for name, value in (("MW", mass), ("A", a), ("B", b)):
            report.mapped(f[name], value)
        report.mapped(f["GASC"], "8.314 J/(mol K)", "units")
        report.mapped(f["CV"], "0", note="MW, A and B are used")
        _gas(context, "gas_1", mass, a, b, 0.0, f["MW"])
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
        _gas(context, "gas_1", mass, gamma / (gamma - 1.0) * GAS_CONSTANT, 0.0, 0.0, f["CP"])
    if temperature is not None and temperature.whole:
        warm = _temperature(context, temperature, curve)
        report.ignored(f["T"], "the curve of temperatures counts")
    else:
        warm = said(f["T"].number, f["T"])
        report.mapped(f["T"], f["T"].number)
    _inflator(context, "gas_1", "gas_1", heat, warm)
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


def _simple(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = _core(context, cards)
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


def _wang_nefske(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = _core(context, cards)
    f = context.card(cards, "gas")
    exits = context.card(cards, "exits")
    ambient = context.card(cards, "ambient")
    if f["CV"].number == 0.0:
        if cards.left >= 2:
            context.card(cards, "inflator")
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
    _exits(context, exits | {"PPOP": ambient["PPOP"]}, airbag)
    if "JETTING" in block.name:
        report.remarks.append(f"{block.place}: the jet of *{block.name} is not read; uniform pressure has no jet")
    return airbag


def _particle(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    f = context.card(cards, "bag")
    parts, kind = f["SID1"], f["STYPE1"].whole
    report.mapped(parts, "part set" if kind else "part")
    report.mapped(f["STYPE1"], kind)
    members = context.model.set_of("PART", parts.whole, parts.shown, parts.place) if kind else np.array([parts.whole])
    airbag = Airbag(block, members, None, parts.place)
    if f["SID2"].whole:
        report.refused(f["SID2"], "walls inside the bag: name their parts with --part, and set bag.parts yourself")
    if f["FRIC"].number:
        report.refused(f["FRIC"], "particles are reflected diffusely in Billow; friction has no counterpart")
    main = context.card(cards, "particles")
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
            cards.plus()
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
    infos = []
    for k in range(1, counts["NGAS"] + 1):
        g = context.card(cards, "gas", f"[{k}]")
        mass = context.si(g["XM"], "molar mass")
        heats = [context.si(g[one], "molar heat") for one in "ABC"]
        for one, value in zip(("XM", *"ABC"), (mass, *heats), strict=True):
            report.mapped(g[one], value)
        name = f"gas_{k}"
        _gas(context, name, mass, *heats, g["XM"])
        flow = _flow(context, g["LCM"])
        _inflator(context, name, name, flow, _temperature(context, g["LCT"], flow))
        infos.append(g["INFG"].whole or 1)
        report.mapped(g["INFG"], infos[-1])
    for k in range(1, counts["NORIF"] + 1):
        o = context.card(cards, "orifice", f"[{k}]")
        for number, info in enumerate(infos):
            if info == (o["INFO"].whole or 1):
                row = (o["NID"], o["NID"].whole, context.si(o["AN"], "area"), o["VD"].whole, o["CA"].number or 30.0)
                airbag.orifices.setdefault(number, []).append(row)
        for name in ("AN", "CA", "INFO"):
            report.mapped(o[name], context.si(o[name], "area") if name == "AN" else o[name].number)
    blocking = f["BLOCK"].whole % 10
    if blocking:
        context.set("leakage.blockage", True, f["BLOCK"])
        if airbag.vents and blocking not in (2, 4):
            context.set("bag.vents.blockage", True, f["BLOCK"])
        report.mapped(f["BLOCK"], blocking)
    return airbag


def _particle_vent(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    report, one = context.report, f["SID3"]
    if f["STYPE3"].whole == 1:
        airbag.vents |= set(context.model.set_of("PART", one.whole, one.shown, one.place).tolist())
    elif f["STYPE3"].whole == 0:
        airbag.vents.add(one.whole)
    else:
        report.refused(one, "a vent between chambers: set bag.parts yourself")
        return
    report.mapped(one, one.whole)
    report.mapped(f["STYPE3"], f["STYPE3"].whole)
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
    _gas(context, "air_at_start", mass, *heats, f["XMAIR"])
    context.tables.setdefault("gas", {})["initial"] = {"gas": {"air_at_start": 1.0}}
    if f["PAIR"].number:
        context.put("gas.initial.pressure", f["PAIR"], "pressure")
    if f["TAIR"].number:
        context.put("gas.initial.temperature", f["TAIR"], "-")


READERS: dict[str, Callable[[Context, Block], Airbag]] = {
    "AIRBAG_HYBRID": _hybrid,
    "AIRBAG_PARTICLE": _particle,
    "AIRBAG_WANG_NEFSKE": _wang_nefske,
    "AIRBAG_SIMPLE_AIRBAG_MODEL": _simple,
}
