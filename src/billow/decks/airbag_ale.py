"""*AIRBAG_ALE and _ADVANCED_ALE as the mesh gas: the lattice gives the size of cells, point sources the ring of jets.

What couples fabric and fluid there (penalties, leakage control) has no counterpart: cells are cut by the fabric.
"""

from __future__ import annotations

import numpy as np

from billow.decks.airbag_gas import (
    Airbag,
    core,
    flow_of,
    put_ambient,
    put_inflator,
    put_species,
    temperature_of,
)
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.tables import NOT_THERE

CELLS = 0.0005, 0.2
"""Range of `gas.cell` [m]."""


def ale(context: Context, block: Block) -> Airbag:
    cards, report = context.cards(block), context.report
    airbag = core(context, cards)
    ambient = context.card(cards, "ambient")
    put_ambient(context, ambient["ATMOSP"], ambient["ATMOST"])
    report.mapped(ambient["GC"], "8.314 J/(mol K)", note="it tells the units")
    for name in ("TNKVOL", "TNKFINP"):
        if ambient[name].number:
            report.approximated(
                ambient[name], "the speed of a jet is what its holes need, choked at most, not a tank's"
            )
    _coupling(context, context.card(cards, "coupling"))
    _vents(context, context.card(cards, "vents"), airbag, ("IVSETID", "IVTYPE", "IBLOCK", "VNTCOF"))
    context.set("gas.model", "mesh", f"{block.place} {block.name}")
    _lattice(context, cards)
    f = context.card(cards, "flow")
    report.ignored(f["HG"], "finite volumes have no hourglass modes")
    if f["SWTIME"].is_blank:
        report.mapped(f["SWTIME"], "never")
    elif f["SWTIME"].number:
        context.put("gas.switch_time", f["SWTIME"], "time")
    else:
        context.set("gas.model", "uniform-pressure", f["SWTIME"])
        report.mapped(f["SWTIME"], "uniform-pressure", "gas.model", "a switch at time 0")
    report.mapped(f["NAIR"], f["NAIR"].whole, "gas.initial")
    air: dict[str, Said] = {}
    for k in range(1, f["NAIR"].whole + 1):
        g = context.card(cards, "air", f"[{k}]")
        _species(context, f"air_{k}", g, ("MWAIR", "AIRA", "AIRB", "AIRC"))
        air[f"air_{k}"] = said(g["INITM"].number, g["INITM"])
        report.mapped(g["INITM"], g["INITM"].number)
    total = sum(plain(air).values())
    if total > 0.0:
        shares = {name: Said(one.value / total, one.source) for name, one in air.items()}
        context.tables.setdefault("gas", {})["initial"] = {"gas": shares, "fractions": "mass"}
    _inflator(context, cards, f, airbag, "LCMF")
    return airbag


def advanced(context: Context, block: Block) -> Airbag:
    """Bags, holes and inflators of *DEFINE_ALEBAG_...; the columns of *AIRBAG_ADVANCED_ALE itself are in no source that
    may be used, so that its fields are refused one by one. Raises InputError E-DCK-006 if no bag is defined."""
    model, report = context.model, context.report
    cards, k = context.cards(block), 0
    while cards.left:
        k += 1
        for one in context.card(cards, "each", f"[{k}]").values():
            if not one.is_blank:
                report.refused(
                    one, "its meaning is not known here: set ambient, gas.initial, gas.cell, gas.switch_time"
                )
    airbag = Airbag(block, np.empty(0, np.int64), None, block.place)
    context.set("gas.model", "mesh", f"{block.place} {block.name}")
    for one in model.all("DEFINE_ALEBAG_BAG"):
        _bag(context, one, airbag)
    if not len(airbag.parts):
        raise NOT_THERE(kind="*DEFINE_ALEBAG_BAG", number=1, who=block.name, place=block.place)
    for one in model.all("DEFINE_ALEBAG_HOLE"):
        _hole(context, context.card(context.cards(one), "hole"), airbag)
    for one in model.all("DEFINE_ALEBAG_INFLATOR"):
        cards = context.cards(one)
        f = context.card(cards, "inflator")
        report.mapped(f["INFID"], f["INFID"].whole, "inflator")
        _inflator(context, cards, f, airbag, "LCIDM")
    return airbag


def _bag(context: Context, block: Block, airbag: Airbag) -> None:
    cards, report = context.cards(block), context.report
    f = context.card(cards, "bag")
    report.mapped(f["BAGID"], f["BAGID"].whole, "bag.parts")
    if f["CVBAG"].text in ("0", "NO"):
        report.refused(f["SID"], "walls inside the bag: name their parts with --part, and set bag.parts yourself")
    else:
        members = _parts(context, f["SID"], f["SIDTYPE"])
        airbag.parts = np.union1d(airbag.parts, members)
        report.mapped(f["SID"], f["SID"].whole, "bag.parts")
        report.mapped(f["SIDTYPE"], f["SIDTYPE"].text, "bag.parts")
        report.mapped(f["CVBAG"], f["CVBAG"].text, "bag.parts")
    _vents(context, f, airbag, ("VSET", "VTYPE", "IBLOCK", "VCOF"))
    _coupling(context, context.card(cards, "coupling"))
    life = context.card(cards, "life", optional=True)
    report.ignored(life["NORM"], "normals are made to point out of the bag")
    for name, beyond in (("START", 0.0), ("END", 1e10)):
        if life[name].number not in (0.0, beyond):
            report.refused(life[name], "gas and fabric of a case feel each other from the start to the end")


def _hole(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    """What watches a hole: gas that has passed it counts as outside."""
    report, kind = context.report, f["INT/EXT"].text
    if kind in ("1", "INT"):
        report.refused(f["SID"], "a hole between chambers: set bag.parts yourself")
        return
    airbag.vents |= set(_parts(context, f["SID"], f["SIDTYPE"]).tolist())
    for name in ("HOLEID", "SID", "SIDTYPE", "INT/EXT"):
        report.mapped(f[name], f[name].text, "bag.parts")
    for name in ("NQUAD", "XOFF", "XCLEN", "NFOLD"):
        report.ignored(f[name], "gas is counted where it crosses the vent")


def _parts(context: Context, one: Field, kind: Field) -> np.ndarray:
    """Ids of a part, or of a set of them."""
    if kind.text in ("1", "PART"):
        return np.array([one.whole], np.int64)
    return context.model.set_of("PART", one.whole, one.shown, one.place)


def _coupling(context: Context, f: dict[str, Field]) -> None:
    for name, one in f.items():
        if name == "FRIC" and one.number:
            context.report.approximated(one, "the gas has no viscosity and fabric no friction for it")
        else:
            how = "the fabric cuts the cells exactly: nothing is coupled by a penalty, and nothing leaks"
            context.report.ignored(one, how)


def _inflator(context: Context, cards: Cards, f: dict[str, Field], airbag: Airbag, flow_name: str) -> None:
    """The gases and point sources that follow a card with NGAS, NORIF, LCVEL and LCT."""
    report, first = context.report, len(context.tables.get("inflator", []))
    if f["LCVEL"].whole:
        report.approximated(f["LCVEL"], "the speed of a jet is what its holes need, choked at most, not a curve")
    for name in ("NGAS", "NORIF"):
        report.mapped(f[name], f[name].whole, "inflator")
    for k in range(1, f["NGAS"].whole + 1):
        g, name = context.card(cards, "gas", f"[{k}]"), f"gas_{first + k}"
        _species(context, name, g, ("MWGAS", "GASA", "GASB", "GASC"))
        flow = flow_of(context, g[flow_name])
        put_inflator(context, name, name, flow, temperature_of(context, f["LCT"], flow))
    for k in range(1, f["NORIF"].whole + 1):
        o = context.card(cards, "orifice", f"[{k}]")
        row = (o["NODEID"], o["NODEID"].whole, context.si(o["ORIFARE"], "area"), o["VECID"].whole, 0.0)
        for number in range(f["NGAS"].whole):
            airbag.orifices.setdefault(first + number, []).append(row)
        report.mapped(o["ORIFARE"], row[2])
        report.mapped(o["VECID"], row[3])


def _species(context: Context, name: str, f: dict[str, Field], fields: tuple[str, ...]) -> None:
    mass, *heats = (
        context.si(f[one], kind) for one, kind in zip(fields, ("molar mass", *["molar heat"] * 3), strict=True)
    )
    put_species(context, name, mass, *heats, f[fields[0]])
    for one, value in zip(fields, (mass, *heats), strict=True):
        context.report.mapped(f[one], value)


def _vents(context: Context, f: dict[str, Field], airbag: Airbag, names: tuple[str, str, str, str]) -> None:
    """names: of the fields that say which set, of which kind, whether contact blocks, and the coefficient."""
    report = context.report
    one, kind, blocked, coefficient = (f[name] for name in names)
    if not one.whole:
        return
    if kind.text in ("2", "SEGSET"):
        report.refused(one, "vents of segments: make them a part")
        return
    airbag.vents |= set(_parts(context, one, kind).tolist())
    report.mapped(one, one.whole, "bag.parts")
    report.mapped(kind, kind.text, "bag.parts")
    context.set("bag.vents.discharge", coefficient.number, coefficient)
    if coefficient.number:
        report.mapped(coefficient, coefficient.number, "bag.vents.discharge")
    else:
        report.refused(coefficient, "0 closes the vents: write the coefficient, or bag.vents.discharge")
    if blocked.whole:
        context.set("bag.vents.blockage", True, blocked)
        context.set("leakage.blockage", True, blocked)
        report.mapped(blocked, blocked.whole, "bag.vents.blockage")


def _lattice(context: Context, cards: Cards) -> None:
    """`gas.cell`: the cube root of the mean volume of the lattice's cells."""
    f, report = context.card(cards, "lattice"), context.report
    for name in ("MOVERN", "ZOOM"):
        if f[name].number:
            report.ignored(f[name], "the lattice of a case stands still, and grows where the bag does")
    counts = [f[name] for name in ("NX/IDA", "NY/IDG", "NZ")]
    if not f["NZ"].whole:
        for one in counts:
            report.approximated(one, "the mesh of fluid parts is not read: set gas.cell", key="gas.cell")
        return
    corners = context.card(cards, "origin") | context.card(cards, "corners")
    points = np.array([[context.si(corners[f"{x}{k}"], "length") for x in "XYZ"] for k in range(4)])
    volume = abs(float(np.linalg.det(points[1:] - points[0])))
    number = int(np.prod([max(one.whole, 1) for one in counts]))
    cell = (volume / number) ** (1.0 / 3.0)
    if not CELLS[0] <= cell <= CELLS[1]:
        raise f["NZ"].bad(
            f"its cells would have edges of {cell:.3g} m; from {CELLS[0]:g} to {CELLS[1]:g} m is possible"
        )
    context.set("gas.cell", cell, f["NZ"])
    edges = np.linalg.norm(points[1:] - points[0], axis=1) / [max(one.whole, 1) for one in counts]
    how = f"cubes of the same volume; edges are {', '.join(f'{1e3 * e:.4g}' for e in edges)} mm in the deck"
    for one in counts:
        report.approximated(one, how, cell, "gas.cell")
    for one in corners.values():
        report.ignored(one, "the lattice of a case lies around the bag")
