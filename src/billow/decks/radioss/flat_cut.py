"""The flat cut of a bag: /XREF by the nodes of a part, /EREF by elements."""

from __future__ import annotations

import numpy as np

from billow.decks.cards import Field, table
from billow.decks.exact_lengths import metres
from billow.decks.flat_reference import of_elements
from billow.decks.radioss.starter_model import NODE, StarterModel, number_of, with_fourth
from billow.decks.report import Report
from billow.decks.tables import rest
from billow.decks.units import Units

_TRIANGLE = tuple((name, 10, "i") for name in ("eid", "n1", "n2", "n3"))
_QUAD = (*_TRIANGLE, ("n4", 10, "i"))


def reference_of(model: StarterModel, ids, points, own, rows, turned, units: Units, report: Report):
    """Points and cells of the reference, None for a birth time, and where it stands; Nones without one."""
    by_node = model.find("XREF")
    elements = [(spec, b) for kind, spec in (("SHELL", _QUAD), ("SH3N", _TRIANGLE)) for b in model.find("EREF", kind)]
    if not by_node and not elements:
        return None, None, ""
    moved, out = points.copy(), own.copy()
    part = np.where(rows >= 0, model.shells.part[rows], -1)
    of_node: dict[int, int] = {}
    for block in by_node:
        steps = model.cards(block).optional("steps", "Nitrs")["Nitrs"]
        report.take([steps])
        if steps.number:
            report.approximated(
                steps, "the reference holds from the start; over time: bag.birth_time", key="bag.birth_time"
            )
        cells = table(model.deck.parameters, rest(block, 2), NODE, keep=("x", "y", "z"))
        texts = np.column_stack([cells.texts[c] for c in "xyz"])
        given = metres(
            texts, np.column_stack([cells[c] for c in "xyz"]), np.ones(len(cells)), model.deck.units_of(block)
        )
        # Each part has a flat cut of its own: its corners that are named get points of their own.
        order = np.argsort(cells["nid"], kind="stable")
        known = cells["nid"][order]
        mine = np.flatnonzero(part == number_of(block))
        corners = own[mine]
        wanted = ids[np.maximum(corners, 0)]
        at = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
        named = (known[at] == wanted) & (corners >= 0) if len(known) else np.zeros(corners.shape, bool)
        local = np.where(named, len(moved) + order[at], corners) if len(known) else corners
        out[mine] = local
        of_node |= dict(zip(corners[named].tolist(), local[named].tolist(), strict=True))
        moved = np.concatenate([moved, given])
        report.remarks.append(
            f"{block.place}: reference of {len(np.unique(corners[named]))} nodes of part {number_of(block)}"
        )
    for k in np.flatnonzero(rows < 0):  # virtual triangles take the reference of a shell at each of their nodes
        out[k] = [of_node.get(int(node), int(node)) for node in own[k]]
    for spec, block in elements:
        cells = table(model.deck.parameters, rest(block, 1), spec)
        cells = cells if spec is _QUAD else with_fourth(cells)
        moved, out = of_elements(model, block, cells, moved, out, rows, turned, units, report)
    place = (by_node or [block for _, block in elements])[0].place
    birth: Field | None = None
    return (moved, out), birth, place
