"""What the cards of all airbags share: the bag they name, gases, mass flows, temperatures, and exits.

Each gas of a deck has its own mass flow and temperature, so it becomes an inflator of one species. Exits of HYBRID and
WANG_NEFSKE obey the nozzle law (Wang and Nefske, SAE 880654), as do orifices of a case.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said

GAS_CONSTANT = 8.31446261815324
AIR = 0.0289652
"""Molar mass [kg/mol] of air."""
NITROGEN = 0.0280134
"""Molar mass [kg/mol]."""
NEVER = 10.0
"""Delay [s] of an inflator that does not blow within any run."""
WARM = 293.0
"""Temperature [K] of what does not matter."""


@dataclass
class Airbag:
    """What the mesh needs to know of the airbag's cards. parts: ids, or None for segments. vents: parts that are vents.
    orifices: nodes, areas [m^2], vectors and cones of jets by inflator number. jet: fields of JETTING.
    option: OPT, how fabric leaks. chambers: parts around each, by number; none if it has but one. openings: parts
    through which gas flows from one to another."""

    block: Block
    parts: np.ndarray | None
    segments: tuple[np.ndarray, str] | None
    place: str
    vents: set[int] = field(default_factory=set)
    orifices: dict[int, list[tuple[Field, int, float, int, float]]] = field(default_factory=dict)
    jet: dict[str, Field] = field(default_factory=dict)
    option: int = 0
    chambers: dict[int, np.ndarray] = field(default_factory=dict)
    openings: set[int] = field(default_factory=set)


def core(context: Context, cards: Cards) -> Airbag:
    f, report = context.card(cards, "core"), context.report
    for name, default in (("VSCA", 1.0), ("PSCA", 1.0), ("VINI", 0.0), ("MWD", 0.0), ("SPSF", 0.0)):
        if name in f and f[name].number not in (0.0, default):
            report.refused(f[name], "a case has no such factor; set it to its default in the deck")
    if "RBID" in f and f["RBID"].whole:
        raise f["RBID"].bad("sensors and user subroutines insert cards that are not read", "set RBID to 0")
    if f["SIDTYP"].whole == 0:
        report.mapped(f["SID"], "segment set")
        found = context.model.segments(f["SID"].whole, f["SID"].shown, f["SID"].place)
        return Airbag(cards.block, None, found, f["SID"].place)
    report.mapped(f["SID"], "part set")
    report.mapped(f["SIDTYP"], "part set")
    parts = context.model.set_of("PART", f["SID"].whole, f["SID"].shown, f["SID"].place)
    return Airbag(cards.block, parts, None, f["SID"].place)


def exits_of(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    """Orifices of A23 and AP23, or vents of the parts that they name. With OPT the fabric leaks by its own law, and the
    fields of AP23 count as zero."""
    report = context.report
    opens = f.get("PVENT") or f.get("PPOP")
    fabric_curve = "LCCP23" if "LCCP23" in f else "LCP23"
    for name, area, discharge, curve, of_pressure in (
        ("exit", "A23", "C23", "LCC23", "LCA23"), ("porosity", "AP23", "CP23", fabric_curve, "LCAP23"),
    ):  # fmt: skip
        if name == "porosity" and airbag.option:
            for one in (f[area], f[discharge], f[curve], f[of_pressure]):
                report.ignored(one, f"OPT is {airbag.option}: the fabric leaks by its own law instead")
            continue
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


def put_species(context: Context, name: str, molar_mass: float, a: float, b: float, c: float, source: Field) -> None:
    """A species of `[gas.species]`."""
    species = context.tables.setdefault("gas", {}).setdefault("species", {})
    terms = {"molar_mass": molar_mass, "a": a, "b": b, "c": c}
    species[name] = {key: said(value, source) for key, value in terms.items() if value or key in ("molar_mass", "a")}


def put_inflator(context: Context, name: str, gas: str, flow: Said, temperature: Said) -> None:
    context.tables.setdefault("inflator", []).append(
        {"name": name, "gas": {gas: 1.0}, "mass_flow": flow, "temperature": temperature, "jets": {"count": 0}}
    )


def put_silence(context: Context) -> None:
    """An inflator that blows later than any run lasts, if no card of an airbag has one: a case has one."""
    if context.airbag is None or context.tables.get("inflator"):
        return
    gas = next(iter(plain(context.tables.get("gas", {}).get("initial", {}).get("gas", {}))), "N2")
    flow = Said({"time": [0.0, 0.01], "value": [1e-6, 0.0]}, "nothing flows in")
    put_inflator(context, "none", gas, flow, Said(WARM, flow.source))
    context.tables["inflator"][0]["delay"] = Said(NEVER, flow.source)
    context.report.remarks.append(f"nothing flows in: the inflator of the case has a delay of {NEVER:g} s")


def flow_of(context: Context, one: Field, number: str = "") -> Said:
    curve = context.curve(one, "time", "mass flow", "a mass flow")
    value = np.array(curve["value"])
    if (value < 0.0).any():
        context.report.approximated(one, f"curve {one.whole}: a mass flow below zero is taken as 0")
        curve["value"] = np.maximum(value, 0.0).tolist()
    else:
        context.report.mapped(one, f"curve {one.whole}")
    return said(curve, one)


def temperature_of(context: Context, one: Field, flow: Said) -> Said:
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


def put_jet(context: Context, cards: Cards, airbag: Airbag) -> None:
    """The cards of JETTING, for `jets.put_jets`, and that of CM."""
    airbag.jet = context.card(cards, "jet") | context.card(cards, "jet ends", optional=True)
    for name in ("XSJFP", "YSJFP", "ZSJFP", "PSID", "ANGLE", "NODE1", "NODE2", "NODE3"):
        if airbag.jet[name].number:
            context.report.refused(airbag.jet[name], "one jet, out of the mouth, that hits all it sees")
    if cards.block.name.endswith(("_CM", "_CM_ID")) and cards.left:
        context.report.refused(context.card(cards, "reaction")["NREACT"], "the thrust on a body: give it to the body")


def put_ambient(context: Context, pressure: Field, temperature: Field) -> None:
    context.put("ambient.pressure", pressure, "pressure", 101325.0)
    context.put("ambient.temperature", temperature, "-", 293.0)
