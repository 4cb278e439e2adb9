"""Beams, springs and seat belts between nodes of the bag as its straps: bars that pull and never push."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from billow.decks.bag_mesh import BagMesh, material_of
from billow.decks.cards import Field, table
from billow.decks.context import Context
from billow.decks.draft import Said, plain
from billow.decks.tables import has_title, shift

ELEMENTS = {
    "ELEMENT_BEAM": [("eid", 8, "i"), ("pid", 8, "i"), ("n1", 8, "i"), ("n2", 8, "i")],
    "ELEMENT_DISCRETE": [("eid", 8, "i"), ("pid", 8, "i"), ("n1", 8, "i"), ("n2", 8, "i"), ("vid", 8, "i"),
                         ("scale", 16, "f"), ("pf", 8, "i"), ("offset", 16, "f")],
    "ELEMENT_SEATBELT": [("eid", 8, "i"), ("pid", 8, "i"), ("n1", 8, "i"), ("n2", 8, "i"), ("sbrid", 8, "i"),
                         ("slack", 16, "f")],
}  # fmt: skip
"""Keyword -> columns that are read."""
NARROWEST, WIDEST = 1e-3, 0.5
"""Widths [m] that a strap of a case may have; its mass goes with it."""


def put_straps(context: Context, bag: BagMesh) -> None:
    """`bag.straps` from the elements whose both ends are nodes of the bag."""
    groups: dict[tuple, list[list[int]]] = defaultdict(list)
    sources: dict[tuple, str] = {}
    left_out = 0
    for keyword, columns in ELEMENTS.items():
        for block in context.model.all(keyword):
            if block.name != keyword:
                continue
            rows = table(context.model.deck.parameters, block, tuple(columns))
            for k in range(len(rows)):
                ends = [_node(bag, int(rows[n][k]) + shift(block, "node")) for n in ("n1", "n2")]
                if min(ends) < 0 or ends[0] == ends[1]:
                    left_out += 1
                    continue
                apart = float(np.linalg.norm(np.subtract(*bag.start.points[ends])))
                # A positive offset of a spring is tension at the start; the slack of a belt is what it lacks of that.
                beyond = 0.0
                if keyword == "ELEMENT_DISCRETE":
                    beyond = -context.units.si(float(rows["offset"][k]), "length")
                elif keyword == "ELEMENT_SEATBELT":
                    beyond = context.units.si(float(rows["slack"][k]), "length")
                length = apart + beyond
                part = int(rows["pid"][k]) + shift(block, "part")
                found = _cloth(context, part, length)
                if found is None:
                    left_out += 1
                    continue
                stiffness, per_length, pushes = found
                stiffness *= float(rows["scale"][k] or 1.0) if keyword == "ELEMENT_DISCRETE" else 1.0
                key = (part, round(stiffness, 9), per_length, beyond, length if beyond < 0.0 else 0.0)
                groups[key].append(ends)
                sources.setdefault(key, f"{rows.place(k)} {keyword}")
                if pushes and len(groups[key]) == 1:
                    context.report.remarks.append(f"part {part}: its elements push too in the deck; a strap only pulls")
    if left_out:
        why = "an end is no node of the bag, or their material no strap"
        context.report.remarks.append(f"{left_out} beams, springs or seat belts left out: {why}")
    if groups:
        context.tables["bag"]["straps"] = [
            _strap(context, key, bars, sources[key]) for key, bars in groups.items()
        ]  # fmt: skip


def _strap(context: Context, key: tuple, bars: list[list[int]], source: str) -> dict[str, object]:
    _, stiffness, per_length, beyond, length = key
    fabric = plain(context.tables["fabric"])
    made: dict[str, object] = {"nodes": Said(bars, source), "stiffness": Said(stiffness * len(bars), source)}
    areal = fabric.get("density", 800.0) * fabric.get("thickness", 3e-4)
    made["width"] = float(np.clip(len(bars) * per_length / areal, NARROWEST, WIDEST))
    if beyond < 0.0:
        return made | {"length": length}
    return made | ({"slack": beyond} if beyond else {})


def _node(bag: BagMesh, number: int) -> int:
    """Mesh node of a node of the deck, -1 if the bag has none."""
    at = int(np.searchsorted(bag.nodes, number))
    return int(bag.index[at]) if at < len(bag.nodes) and bag.nodes[at] == number else -1


def _cloth(context: Context, part: int, length: float) -> tuple[float, float, bool] | None:
    """Tension per strain [N], mass per length [kg/m], and whether it also pushes, of a part's elements of a length [m]
    without tension;
    None if its material is no strap."""
    found = material_of(context.model, part)
    if found is None:
        return None
    name, block = found
    report, cards = context.report, context.cards(block)

    def taken(columns: str) -> dict[str, Field]:
        f = cards.card("strap", columns)
        report.take(f.values())
        report.mapped(f["MID"], f["MID"].whole, "bag.straps")
        return f

    if name in ("MAT_SPRING_ELASTIC", "MAT_S01"):
        f = taken("MID K")
        report.mapped(f["K"], context.si(f["K"], "stiffness"), "bag.straps.stiffness")
        return context.si(f["K"], "stiffness") * length, 0.0, True
    if name in ("MAT_CABLE_DISCRETE_BEAM", "MAT_071", "MAT_71"):
        f = taken("MID RO E LCID F0 TMAXF0 TRAMP IREAD")
        area = _area(context, part, "VOL INER CID CA OFFSET RRCON SRCON TRCON", "CA")
        if f["LCID"].whole or f["F0"].number:
            report.refused(f["LCID"], "a cable by a curve, or with a tension at the start: its modulus is used")
        if f["E"].number < 0.0:
            stiffness = context.units.si(-f["E"].number, "stiffness") * length
        else:
            stiffness = context.si(f["E"], "pressure") * area
        report.mapped(f["E"], stiffness, "bag.straps.stiffness")
        report.mapped(f["RO"], context.si(f["RO"], "density") * area, "bag.straps.width", "the mass of the strap")
        return (stiffness, context.si(f["RO"], "density") * area, False) if stiffness > 0.0 else None
    if name in ("MAT_ELASTIC", "MAT_001", "MAT_1"):
        f = taken("MID RO E PR DA DB K")
        area = _area(context, part, "A RAMPT STRESS", "A")
        stiffness = context.si(f["E"], "pressure") * area
        report.mapped(f["E"], stiffness, "bag.straps.stiffness")
        report.mapped(f["RO"], context.si(f["RO"], "density") * area, "bag.straps.width", "the mass of the strap")
        return (stiffness, context.si(f["RO"], "density") * area, True) if stiffness > 0.0 else None
    if name in ("MAT_SEATBELT", "MAT_B01"):
        f = taken("MID MPUL LLCID ULCID LMIN CSE DAMP E")
        points, *_ = context.points(f["LLCID"], "-", "force")
        rises = np.diff(points[:, 1]) / np.maximum(np.diff(points[:, 0]), 1e-300)
        if not len(rises) or not rises.max() > 0.0:
            return None
        stiffness = float(points[-1, 1] / points[-1, 0])
        spread = float(np.abs(np.interp(points[:, 0], [0.0, points[-1, 0]], [0.0, points[-1, 1]]) - points[:, 1]).max())
        why = f"a straight line to the end of the curve; forces differ by up to {spread:.3g} N"
        report.approximated(f["LLCID"], why, stiffness, "bag.straps.stiffness")
        report.mapped(f["MPUL"], context.si(f["MPUL"], "mass per length"), "bag.straps.width", "the mass of the strap")
        return stiffness, context.si(f["MPUL"], "mass per length"), False
    return None


def _area(context: Context, part: int, columns: str, name: str) -> float:
    """Of the section [m^2] of a part's beams, 0 if it has none."""
    model = context.model
    for block in model.all("SECTION_BEAM"):
        cards = context.cards(block)
        while cards.left >= 2:
            head = cards.card("section", "SECID ELFORM")
            second = cards.card("area", columns)
            if head["SECID"].whole + shift(block, "section") == model.parts[part].section:
                context.report.take(second.values())
                context.report.mapped(second[name], context.si(second[name], "area"), "bag.straps.stiffness")
                return context.si(second[name], "area")
            if has_title(block) and cards.left:
                cards.text()
    return 0.0
