"""The flat cut of a bag: *AIRBAG_REFERENCE_GEOMETRY by nodes, *AIRBAG_SHELL_REFERENCE_GEOMETRY by elements."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import Block
from billow.decks.cards import Cards, Table, table
from billow.decks.exact_lengths import metres
from billow.decks.report import Report
from billow.decks.tables import REFERENCE, SHELL, WIDE_REFERENCE, Model, corners_of, find, rest, shift
from billow.decks.units import Units
from billow.geometry.mesh_repair import flipped

NO_SURFACE = InputError.declare(
    "E-DCK-012",
    "the bag is no surface with an inside",
    where="{place}",
    cause="parts that do not belong to the bag, such as tethers and inner walls, or elements that are there twice",
    remedy="take the parts out of the bag's set, or name them: --part N=ignore",
)


def reference_of(model: Model, ids, points, own, rows, turned, units: Units, report: Report):
    """Points and cells of the reference, the field of its birth time, and where it stands; Nones without one."""
    by_element = model.all("AIRBAG_SHELL_REFERENCE_GEOMETRY")
    by_node = model.all("AIRBAG_REFERENCE_GEOMETRY")
    birth = None
    if not by_element and not by_node:
        return None, None, ""
    moved, out = points.copy(), own
    for block in by_node:
        cards, skip = Cards(model.deck.parameters, block), 0
        scales, origin = np.ones(3), None
        for option, names in (("ID", "ID SX SY SZ NIDO IOUT"), ("BIRTH", "BIRTH")):
            if option not in block.name.split("_"):
                continue
            card, skip = cards.card(option.lower(), names), skip + 1
            report.take(card.values())
            if option == "BIRTH":
                birth = card["BIRTH"]
                continue
            scales = np.array([card[name].number or 1.0 for name in ("SX", "SY", "SZ")])
            for name in ("SX", "SY", "SZ", "NIDO"):
                report.mapped(card[name], card[name].number, "bag.reference")
            origin = card["NIDO"]
        rows_ = _node_rows(model, rest(block, skip), report)
        texts = np.column_stack([rows_.texts[c] for c in "xyz"])
        given = metres(texts, np.column_stack([rows_[c] for c in "xyz"]), np.ones(len(rows_)), units)
        if (scales != 1.0).any():
            centre = np.zeros(3)
            if origin is not None and origin.whole:
                k = find(np.sort(rows_["nid"]), np.array([origin.whole]), "reference node", origin.shown, origin.place)
                centre = given[np.argsort(rows_["nid"])[k[0]]]
            given = centre + (given - centre) * scales
        at = np.searchsorted(ids, rows_["nid"] + shift(block, "node"))
        mine = (at < len(ids)) & (ids[np.minimum(at, len(ids) - 1)] == rows_["nid"] + shift(block, "node"))
        moved[at[mine]] = given[mine]
        report.remarks.append(f"{block.place}: reference of {mine.sum()} of the bag's {len(ids)} nodes")
    for block in by_element:
        skip = "ID" in block.name.removeprefix("AIRBAG_SHELL_REFERENCE_GEOMETRY").split("_")
        cells = table(model.deck.parameters, rest(block, int(skip)), SHELL)
        moved, out = of_elements(model, block, cells, moved, out, rows, turned, units, report)
    source = (by_element or by_node)[0].place
    return (moved, out), birth, source


def _node_rows(model: Model, block: Block, report: Report) -> Table:
    """Rows of nodes, in columns of 8 and 16 as *NODE has them, or of 10 and 20, which some programs write: those whose
    ids are nodes of the deck. Raises InputError E-DCK-004 or -006 if neither are."""
    problem = None
    for spec in (REFERENCE, WIDE_REFERENCE):
        try:
            rows = table(model.deck.parameters, block, spec, keep=("x", "y", "z"))
            model.nodes.rows(rows["nid"] + shift(block, "node"), f"*{block.name}", block.place)
        except InputError as error:
            problem = problem or error
            continue
        if problem is not None:
            report.remarks.append(f"{block.place}: columns of 10 and 20 characters, by the ids of its nodes")
        return rows
    raise problem


def of_elements(model: Model, block, cells, points, own, rows, turned, units: Units, report: Report):
    """The reference of the shells that *AIRBAG_SHELL_REFERENCE_GEOMETRY names, on nodes of their own."""
    place = block.place
    corners = corners_of(cells)
    order = np.argsort(cells["eid"])
    numbers = np.where(rows >= 0, model.shells.number[rows], -1)
    if not len(order):
        return points, own
    at = np.minimum(np.searchsorted(cells["eid"][order], numbers), len(order) - 1)
    has = (cells["eid"][order][at] == numbers) & (rows >= 0)
    mine = corners[order[at]]
    ids = np.unique(mine[has][mine[has] >= 0])
    found = model.nodes.rows(ids, "a reference shell", place)
    extra = model.nodes.metres(found, units)
    local = np.where(mine >= 0, np.searchsorted(ids, mine) + len(points), -1)
    local = flipped(local, turned)
    for k in np.flatnonzero(has & ((local[:, 3] < 0) != (own[:, 3] < 0))):
        raise NO_SURFACE(
            place=cells.place(int(order[at[k]])),
            why=f"shell {numbers[k]} is a triangle in one of *ELEMENT_SHELL and the reference, a quad in the other",
            remedy="give both the same corners",
        )
    out = np.where(has[:, None], local, own)
    # Virtual triangles take the reference of a shell at each of their nodes.
    of_node = dict(zip(own[has][own[has] >= 0].tolist(), out[has][own[has] >= 0].tolist(), strict=True))
    for k in np.flatnonzero(rows < 0):
        out[k] = [of_node.get(int(node), int(node)) if node >= 0 else -1 for node in own[k]]
    report.remarks.append(f"{place}: reference of {has.sum()} of the bag's {(rows >= 0).sum()} shells")
    return np.concatenate([points, extra]), out
