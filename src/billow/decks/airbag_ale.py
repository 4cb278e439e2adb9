"""*AIRBAG_ALE as the mesh gas: its lattice gives the size of cells, its point sources the ring of jets.

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
    for name, one in context.card(cards, "coupling").items():
        if name == "FRIC" and one.number:
            report.approximated(one, "the gas has no viscosity and fabric no friction for it")
        else:
            report.ignored(one, "the fabric cuts the cells exactly: nothing is coupled by a penalty, and nothing leaks")
    _vents(context, context.card(cards, "vents"), airbag)
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
    if f["LCVEL"].whole:
        report.approximated(f["LCVEL"], "the speed of a jet is what its holes need, choked at most, not a curve")
    for name in ("NAIR", "NGAS", "NORIF"):
        report.mapped(f[name], f[name].whole, "gas.initial" if name == "NAIR" else "inflator")
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
    for k in range(1, f["NGAS"].whole + 1):
        g = context.card(cards, "gas", f"[{k}]")
        _species(context, f"gas_{k}", g, ("MWGAS", "GASA", "GASB", "GASC"))
        flow = flow_of(context, g["LCMF"])
        put_inflator(context, f"gas_{k}", f"gas_{k}", flow, temperature_of(context, f["LCT"], flow))
    for k in range(1, f["NORIF"].whole + 1):
        o = context.card(cards, "orifice", f"[{k}]")
        row = (o["NODEID"], o["NODEID"].whole, context.si(o["ORIFARE"], "area"), o["VECID"].whole, 0.0)
        for number in range(f["NGAS"].whole):
            airbag.orifices.setdefault(number, []).append(row)
        report.mapped(o["ORIFARE"], row[2])
        report.mapped(o["VECID"], row[3])
    return airbag


def _species(context: Context, name: str, f: dict[str, Field], fields: tuple[str, ...]) -> None:
    mass, *heats = (
        context.si(f[one], kind) for one, kind in zip(fields, ("molar mass", *["molar heat"] * 3), strict=True)
    )
    put_species(context, name, mass, *heats, f[fields[0]])
    for one, value in zip(fields, (mass, *heats), strict=True):
        context.report.mapped(f[one], value)


def _vents(context: Context, f: dict[str, Field], airbag: Airbag) -> None:
    report, one, kind = context.report, f["IVSETID"], f["IVTYPE"].whole
    if not one.whole:
        return
    if kind == 2:
        report.refused(one, "vents of segments: make them a part")
        return
    named = context.model.set_of("PART", one.whole, one.shown, one.place) if kind == 0 else [one.whole]
    airbag.vents |= {int(part) for part in named}
    report.mapped(one, one.whole)
    report.mapped(f["IVTYPE"], kind)
    context.set("bag.vents.discharge", f["VNTCOF"].number, f["VNTCOF"])
    if f["VNTCOF"].number:
        report.mapped(f["VNTCOF"], f["VNTCOF"].number)
    else:
        report.refused(f["VNTCOF"], "0 closes the vents: write the coefficient, or bag.vents.discharge")
    if f["IBLOCK"].whole:
        context.set("bag.vents.blockage", True, f["IBLOCK"])
        context.set("leakage.blockage", True, f["IBLOCK"])
        report.mapped(f["IBLOCK"], f["IBLOCK"].whole)


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
