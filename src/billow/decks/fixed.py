"""Which nodes of the bag stand still or are moved: by *NODE.TC, *BOUNDARY_SPC and *BOUNDARY_PRESCRIBED_MOTION, and
because they belong to a rigid part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from billow.decks.bag_mesh import BagMesh, material_of
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import plain
from billow.decks.held_nodes import put_held, put_moved
from billow.decks.motions import Motions, course_table, motion_table, require_no_death
from billow.decks.obstacles import rigid_of


@dataclass(frozen=True)
class RigidPart:
    """number: of the part or the body. called: for messages. ids: of its nodes. title and place in the deck. main: id
    of the node that stands for all, if there is one."""

    number: int
    called: str
    ids: np.ndarray
    title: str
    place: str
    main: int = 0


WAYS = ("DOFX", "DOFY", "DOFZ")


def put_fixed(context: Context, bag: BagMesh, motions: Motions) -> set[int]:
    """`bag.fixed_nodes` and `[[nodes]]`; the rigid parts that share nodes with the bag, which are no obstacles."""
    held = bag.held.copy()
    sources = ["NODE.TC"] if held.any() else []
    for block in context.model.all("BOUNDARY_SPC"):
        if not block.name.startswith("BOUNDARY_SPC_SYMMETRY"):
            sources += _constraints(context, bag, block, held)
    rigid = [RigidPart(part, f"part {part}", ids, *_told(context, part)) for part, ids in _rigid_parts(context, bag)]
    return settle(context, bag, motions, held, sources, rigid, _rigid_of)


def _told(context: Context, part: int) -> tuple[str, str]:
    """Title and place of a part."""
    told = context.model.parts.get(part)
    return (told.title, told.place) if told else ("", f"{context.model.deck.path.name}:1")


def _rigid_of(context: Context, part: RigidPart) -> dict[str, Any] | None:
    material = material_of(context.model, part.number)
    return rigid_of(context, material[1]) if material and material[0] == "MAT_RIGID" else None


def settle(
    context: Context, bag: BagMesh, motions: Motions, held: np.ndarray, sources: list[str], rigid: list[RigidPart],
    constraint_of: Callable[[Context, RigidPart], dict[str, Any] | None],
) -> set[int]:  # fmt: skip
    """What holds and moves nodes of the bag, beside what held says already, (nodes, 3) bool; the numbers of those rigid
    parts that share nodes with it. sources: of held. constraint_of: as `rigid_of`, for a part that moves."""
    sources = sources + _still(context, bag, motions, held)
    attached, driven = set(), []
    for part in rigid:
        mine = bag.mesh_nodes(part.ids)
        if not len(mine):
            continue
        attached.add(part.number)
        found = motions.of_part(part.number, part.ids)
        motion = motion_table(context, found, context.end, constraint_of(context, part)) if found else None
        what = f"{len(mine)} nodes of the bag belong to the rigid {part.called}"
        if motion is None:
            held[mine] = True
            sources.append(part.called)
            context.report.remarks.append(f"{what}: they are fixed")
        else:
            driven.append((part, mine, motion, what))
    put_held(context, held, sources)
    for part, mine, motion, what in driven:
        why = put_moved(context, bag, mine, held, motion, part.title or part.called, part.place)
        if not why:
            context.report.remarks.append(f"{what}: they move with it")
            continue
        one = Field("PART", "motion", part.called, part.place)
        context.report.take([one])
        context.report.refused(one, f"{what}, which moves: {why}")
        already = plain(context.tables["bag"]).get("fixed_nodes", [])
        context.set("bag.fixed_nodes", sorted({*already, *mine.tolist()}), part.place)
    _moved(context, bag, motions, held)
    return attached


def _constraints(context: Context, bag: BagMesh, block: Block, held: np.ndarray) -> list[str]:
    """Set in held what *BOUNDARY_SPC holds; where it says so."""
    report, sources = context.report, []
    cards, end = Cards(context.model.deck.parameters, block), context.end
    while cards.left:
        if "_ID" in block.name:
            cards.text()
            if not cards.left:
                break
        f = context.card(cards, "spc")
        life = context.card(cards, "life", optional=True) if "BIRTH_DEATH" in block.name else {}
        mine = bag.mesh_nodes(_nodes(context, f["NID"], "SET" in block.name))
        begin, death = (context.si(life[n], "time") if life else 0.0 for n in ("BIRTH", "DEATH"))
        if not len(mine):
            for one in (*f.values(), *life.values()):
                report.ignored(one, "none of these nodes belongs to the bag")
        elif f["CID"].whole:
            report.refused(f["CID"], "directions of a local system: hold the nodes along x, y or z of the deck")
        elif begin > 0.0 or 0.0 < death < end:
            report.refused(f["NID"], "held for a part of the run only: nodes of a case are held or not")
        else:
            ways = np.array([f[way].whole != 0 for way in WAYS])
            held[mine] |= ways
            sources.append(f["NID"].place)
            key = "bag.fixed_nodes" if ways.all() else "nodes.motion.directions"
            for one in (f["NID"], *(f[way] for way, is_held in zip(WAYS, ways, strict=True) if is_held)):
                report.mapped(one, f"{len(mine)} nodes", key)
            for name in ("DOFRX", "DOFRY", "DOFRZ"):
                report.ignored(f[name], "fabric has no rotations at its nodes")
    return sources


def _still(context: Context, bag: BagMesh, motions: Motions, held: np.ndarray) -> list[str]:
    """Set in held what curves of zeros hold; where they say so."""
    sources = []
    for ids, motion in motions.nodes:
        mine, axis = bag.mesh_nodes(ids), np.abs(motion.axis)
        if not motion.is_nothing or not len(mine):
            continue
        if axis.max() < 1.0 - 1e-9 and not motion.is_alone:
            context.report.refused(motion.f["DOF"], "held along a line that is no axis: give DOF 1, 2 or 3")
            continue
        ways = (axis > 0.5) | motion.is_alone
        held[mine] |= ways
        sources.append(motion.f["TYPEID"].place)
        key = "bag.fixed_nodes" if ways.all() else "nodes.motion.directions"
        context.report.mapped(motion.f["TYPEID"], f"{len(mine)} nodes stand still", key)
    return sources


def _moved(context: Context, bag: BagMesh, motions: Motions, held: np.ndarray) -> None:
    """Groups of nodes that cards of their own move."""
    report, taken = context.report, np.zeros((len(held), 3, 3))
    for ids, motion in motions.nodes:
        mine, one = bag.mesh_nodes(ids), motion.f["TYPEID"]
        if motion.is_nothing or not len(mine) or report.settled(one):
            continue
        require_no_death(context, motion.f, context.end)
        table = course_table(context, motion, motion.axis, context.end, "nodes")
        if table is None:
            continue
        own = np.eye(3) if motion.is_alone else np.outer(motion.axis, motion.axis)
        if np.abs(taken[mine] @ own).max() > 1e-9:
            report.refused(one, "another card moves some of these nodes along the same line")
            continue
        table["across"] = "held" if motion.is_alone else "free"
        why = put_moved(context, bag, mine, held, table, "moved", one.place)
        if why:
            report.refused(one, f"a motion of {len(mine)} nodes of the bag: {why}")
            continue
        taken[mine] += own
        report.mapped(one, f"{len(mine)} nodes", "nodes.numbers")
        report.mapped(motion.f["DOF"], str(motion.axis.round(6).tolist()), "nodes.motion.direction")
        if not report.settled(motion.f["LCID"]):
            report.mapped(motion.f["LCID"], f"{len(motion.points)} points", f"nodes.motion.{motion.kind}")


def _nodes(context: Context, one: Field, is_set: bool) -> np.ndarray:
    return context.model.set_of("NODE", one.whole, one.shown, one.place) if is_set else np.array([one.whole])


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
