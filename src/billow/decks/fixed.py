"""Which nodes of the bag stand still: by *NODE.TC, *BOUNDARY_SPC, and because they belong to a rigid part."""

from __future__ import annotations

import numpy as np

from billow.decks.bag_mesh import BagMesh, material_of
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.motions import Motions

WAYS = ("DOFX", "DOFY", "DOFZ")


def put_fixed(context: Context, bag: BagMesh, motions: Motions) -> set[int]:
    """`bag.fixed_nodes`; the rigid parts that share nodes with the bag, which are no obstacles."""
    held = set(bag.held)
    sources = ["NODE.TC"] if held else []
    for block in context.model.all("BOUNDARY_SPC"):
        if block.name.startswith("BOUNDARY_SPC_SYMMETRY"):
            continue
        cards = context.cards(block)
        while cards.left:
            f = context.card(cards, "spc")
            ids = _nodes(context, f["NID"], "SET" in block.name)
            mine = _of_bag(bag, ids)
            if not len(mine):
                for one in f.values():
                    context.report.ignored(one, "none of these nodes belongs to the bag")
            elif all(f[way].whole for way in WAYS):
                held |= set(mine.tolist())
                sources.append(f["NID"].place)
                for one in (f["NID"], *(f[way] for way in WAYS)):
                    context.report.mapped(one, f"{len(mine)} nodes", "bag.fixed_nodes")
            else:
                for way in WAYS:
                    if f[way].whole:
                        context.report.refused(f[way], "a node of a case is fixed in all directions, or free")
    still = _still(context, bag, motions)
    held |= still
    sources += ["BOUNDARY_PRESCRIBED_MOTION"] if still else []
    attached = set()
    for part, ids in _rigid_parts(context, bag):
        mine = _of_bag(bag, ids)
        if len(mine):
            attached.add(part)
            held |= set(mine.tolist())
            sources.append(f"part {part}")
            context.report.remarks.append(
                f"{len(mine)} nodes of the bag belong to the rigid part {part}: they are fixed"
            )
    if held:
        context.set("bag.fixed_nodes", sorted(held), ", ".join(dict.fromkeys(sources)))
    return attached


def _still(context: Context, bag: BagMesh, motions: Motions) -> set[int]:
    """Mesh nodes of the bag that curves of zeros hold in all directions."""
    found: dict[int, set[int]] = {}
    rows = []
    for ids, motion in motions.nodes:
        mine = _of_bag(bag, ids)
        if motion.is_nothing and len(mine):
            rows.append(motion.f["TYPEID"])
            for node in mine.tolist():
                found.setdefault(node, set()).update(np.flatnonzero(np.abs(motion.axis) > 0.5).tolist())
    still = {node for node, axes in found.items() if len(axes) == 3}
    for one in rows:
        if len(still) == len(found):
            context.report.mapped(one, f"{len(still)} nodes stand still", "bag.fixed_nodes")
        else:
            context.report.refused(one, "a node of a case is fixed in all directions, or free")
    return still


def _nodes(context: Context, one: Field, is_set: bool) -> np.ndarray:
    return context.model.set_of("NODE", one.whole, one.shown, one.place) if is_set else np.array([one.whole])


def _of_bag(bag: BagMesh, ids: np.ndarray) -> np.ndarray:
    """Mesh nodes of those ids that are nodes of the bag."""
    mine = bag.index[np.isin(bag.nodes, ids)]
    return np.unique(mine[mine >= 0])


def _rigid_parts(context: Context, bag: BagMesh):
    """Number and node ids of rigid parts that do not belong to the bag, with *CONSTRAINED_EXTRA_NODES."""
    model = context.model
    shells = model.shells
    rigid = {}
    for part in np.unique(shells.part).tolist():
        material = None if part in bag.parts else material_of(model, part)
        if material is not None and material[0] == "MAT_RIGID":
            corners = shells.corners[shells.part == part]
            rigid[part] = np.unique(corners[corners >= 0])
    for block in model.all("CONSTRAINED_EXTRA_NODES"):
        cards = context.cards(block)
        while cards.left:
            f = context.card(cards, "extra")
            context.report.mapped(f["PID"], f["PID"].whole, "bag.fixed_nodes")
            context.report.mapped(f["NID"], f["NID"].whole, "bag.fixed_nodes")
            rigid[f["PID"].whole] = np.union1d(
                rigid.get(f["PID"].whole, np.empty(0, np.int64)), _nodes(context, f["NID"], "SET" in block.name)
            )
    return rigid.items()
