"""Motion at the start: *INITIAL_VELOCITY, _NODE, _GENERATION and _RIGID_BODY, and that of *PART_INERTIA.

A card names nodes; those of the bag become groups of `[[nodes]]`, and a rigid part whose nodes it names all gets its
velocity and spin. *INITIAL_VELOCITY_RIGID_BODY comes before all others, and a later card before an earlier one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.decks.bag_mesh import BagMesh
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, said
from billow.decks.fields import CARDS
from billow.decks.held_nodes import put_group

BY_NODES = -999
"""In NX: the axis goes through two nodes."""
MOST_GROUPS = 500


@dataclass
class Launch:
    """One card. ids: nodes, None for all. velocity [m/s], spin [rad/s], about [m]: (3,). one: the field that names the
    nodes; says: the fields of velocity, spin and point. resets: whether it counts for *PART_INERTIA too. others: fields
    that name further nodes, where several cards say the same."""

    ids: np.ndarray | None
    velocity: np.ndarray
    spin: np.ndarray
    about: np.ndarray
    one: Field
    says: list[tuple[Field, str]]
    resets: bool = False
    others: list[Field] = field(default_factory=list)

    def names(self, ids: np.ndarray) -> np.ndarray:
        """Which of some nodes it names, (n,) bool."""
        return np.ones(len(ids), bool) if self.ids is None else np.isin(ids, self.ids)


@dataclass
class Velocities:
    """launches: in the order in which they count, the strongest last. of_inertia, of_bodies: velocity and spin by the
    number of a rigid part."""

    launches: list[Launch] = field(default_factory=list)
    of_inertia: dict[int, tuple[Said, Said]] = field(default_factory=dict)
    of_bodies: dict[int, tuple[Said, Said]] = field(default_factory=dict)

    def of_part(self, context: Context, part: int, ids: np.ndarray, centre: np.ndarray) -> tuple[Said, Said] | None:
        """Velocity [m/s] and spin [rad/s] of a rigid part with these nodes and this centre of mass [m], (3,); None if
        the deck says nothing of it."""
        if part in self.of_bodies:
            return self.of_bodies[part]
        found = self.of_inertia.get(part)
        for launch in self.launches:
            mine = launch.names(ids)
            if not mine.any():
                continue
            velocity = launch.velocity + np.cross(launch.spin, centre - launch.about)
            if not mine.all():
                why = f"it names some nodes of the rigid part {part}, and not all of them"
                context.report.refused(launch.one, why)
            elif part in self.of_inertia and not launch.resets:
                own = [*self.of_inertia[part][0].value, *self.of_inertia[part][1].value]
                if not np.allclose(own, [*velocity, *launch.spin], rtol=1e-9, atol=1e-12):
                    why = f"*PART_INERTIA of part {part} says another velocity, which is kept: write obstacles.velocity"
                    context.report.refused(launch.one, why)
            else:
                found = said(velocity.tolist(), launch.one), said(launch.spin.tolist(), launch.one)
                tell(context, launch, "obstacles", f"part {part}")
        return found

    def put(self, context: Context, bag: BagMesh) -> None:
        """The groups of nodes of the bag."""
        taken, groups = np.zeros(len(bag.start.points), bool), 0
        for launch in reversed(self.launches):
            mine = bag.mesh_nodes(bag.nodes if launch.ids is None else launch.ids)
            rest = mine[~taken[mine]]
            if not len(mine):
                continue
            tell(context, launch, "nodes", f"{len(mine)} nodes")
            if len(rest) < len(mine):
                why = f"{len(mine) - len(rest)} of its nodes get their velocity from a later card"
                context.report.approximated(launch.one, why, f"{len(rest)} nodes", "nodes.numbers")
            taken[mine] = True
            if not len(rest) or not (launch.velocity.any() or launch.spin.any()):
                continue
            groups += 1
            if groups > MOST_GROUPS:
                context.report.refused(launch.one, f"more than {MOST_GROUPS} velocities of nodes of the bag")
                continue
            what = {"velocity": said(launch.velocity.tolist(), launch.one)}
            if launch.spin.any():
                what |= {
                    "spin": said(launch.spin.tolist(), launch.one),
                    "about": said(launch.about.tolist(), launch.one),
                }
            put_group(context, "start", rest, what, launch.one.place)

    def finish(self, context: Context) -> None:
        """Say which cards nothing took."""
        for launch in self.launches:
            for one in (launch.one, *launch.others):
                if not context.report.settled(one):
                    context.report.ignored(one, "none of its nodes belongs to the bag or to an obstacle that is free")


def tell(context: Context, launch: Launch, table: str, whom: str) -> None:
    """Rows of a card that counts for something."""
    for one, key in launch.says:
        context.report.mapped(one, one.text, f"{table}.{key}")
    for one in (launch.one, *launch.others):
        if not context.report.settled(one):
            context.report.mapped(one, whom, table)


def velocities_of(context: Context) -> Velocities:
    """All that a deck says of motion at the start."""
    found = Velocities()
    for block in context.model.all("PART_INERTIA"):
        _of_inertia(context, block, found)
    nodes = []
    for block in context.model.all("INITIAL_VELOCITY"):
        name = block.name.removeprefix("INITIAL_VELOCITY").removesuffix("_ID").removesuffix("_TITLE")
        if name == "_RIGID_BODY":
            _of_bodies(context, block, found)
        elif name == "_GENERATION":
            found.launches += _generated(context, block)
        elif name == "_NODE":
            nodes += _of_nodes(context, block)
        elif name in ("", "_SET"):
            found.launches += _of_set(context, block)
    found.launches += _together(context, nodes)  # what names a node alone counts before what names sets
    return found


def _together(context: Context, cards: list[Launch]) -> list[Launch]:
    """Cards of one node each: all that give the same velocity as one, of nodes that are named twice the last."""
    last = {int(card.ids[0]): card for card in cards}
    found: dict[tuple[float, ...], Launch] = {}
    for card in cards:
        if last[int(card.ids[0])] is not card:
            context.report.ignored(card.one, "a later card gives this node its velocity")
            continue
        first = found.setdefault(tuple(card.velocity.tolist()), card)
        if first is not card:
            first.says += card.says
            first.others.append(card.one)
    for first in found.values():
        first.ids = np.array([first.one.whole, *(one.whole for one in first.others)])
    return list(found.values())


def _vector(context: Context, f: dict[str, Field], names: tuple[str, ...], dimension: str) -> np.ndarray:
    return np.array([context.si(f[name], dimension) for name in names])


def _six(context: Context, f: dict[str, Field], names: tuple[str, ...]) -> tuple[Said, Said]:
    """Velocity and spin of a rigid part, in the report as well."""
    moves, turns = _vector(context, f, names[:3], "velocity"), _vector(context, f, names[3:], "frequency")
    for name, value in zip(names, (*moves.tolist(), *turns.tolist()), strict=True):
        context.report.mapped(f[name], value, "obstacles.spin" if name in names[3:] else "obstacles.velocity")
    return said(moves.tolist(), f[names[0]]), said(turns.tolist(), f[names[3]])


def _of_inertia(context: Context, block: Block, found: Velocities) -> None:
    cards = Cards(context.model.deck.parameters, block)
    cards.text()
    part = cards.card("part", "PID")["PID"].whole
    for card in ("inertia", "tensor"):
        cards.optional(card, CARDS["PART_INERTIA"][card])
    f = context.card(cards, "velocity", optional=True)
    found.of_inertia[part] = _six(context, f, ("VTX", "VTY", "VTZ", "VRX", "VRY", "VRZ"))


def _of_bodies(context: Context, block: Block, found: Velocities) -> None:
    cards = context.cards(block)
    while cards.left:
        f = context.card(cards, "velocity")
        if f["ICID"].whole:
            context.report.refused(f["ICID"], "velocities in a local system: give them in that of the deck")
            continue
        context.report.mapped(f["PID"], f["PID"].whole, "obstacles")
        found.of_bodies[f["PID"].whole] = _six(context, f, ("VX", "VY", "VZ", "VXR", "VYR", "VZR"))


def _of_nodes(context: Context, block: Block) -> list[Launch]:
    cards, found = context.cards(block), []
    while cards.left:
        f = context.card(cards, "velocity")
        launch = _launch(context, f, np.array([f["NID"].whole]), f["NID"])
        found += [launch] if launch else []
    return found


def _of_set(context: Context, block: Block) -> list[Launch]:
    cards, report = context.cards(block), context.report
    head = context.card(cards, "set")
    f = context.card(cards, "velocity")
    if head["NSIDEX"].whole:
        context.card(cards, "exempted", optional=True)
    for name, why in (
        ("NSIDEX", "nodes that are left out: give a set without them"),
        ("BOXID", "nodes of a box: give a set of nodes"),
    ):
        if head[name].whole:
            report.refused(head[name], why)
            return []
    one = head["NSID"]
    ids = context.model.set_of("NODE", one.whole, one.shown, one.place) if one.whole else None
    launch = _launch(context, f | {"ICID": head["ICID"]}, ids, one)
    if launch:
        launch.resets = _resets(context, head["IRIGID"], "-1")
    return [launch] if launch else []


def _launch(context: Context, f: dict[str, Field], ids: np.ndarray | None, one: Field) -> Launch | None:
    """A velocity without a spin about an axis."""
    if f["ICID"].whole:
        context.report.refused(f["ICID"], "velocities in a local system: give them in that of the deck")
        return None
    for name in ("VXR", "VYR", "VZR"):
        if f[name].number:
            context.report.refused(f[name], "a rotation of nodes, which fabric has not: give OMEGA of _GENERATION")
    zero, names = np.zeros(3), ("VX", "VY", "VZ")
    return Launch(ids, _vector(context, f, names, "velocity"), zero, zero, one, [(f[n], "velocity") for n in names])


def _resets(context: Context, one: Field, all_of_them: str) -> bool:
    """Whether a card counts for *PART_INERTIA too, as IRIGID says."""
    if one.number and one.text != all_of_them:
        context.report.refused(one, f"rigid parts by a set or a box: 0 or {all_of_them}")
    elif one.number:
        context.report.mapped(one, "all rigid parts", "obstacles.velocity")
    return one.text == all_of_them


def _generated(context: Context, block: Block) -> list[Launch]:
    cards, report, model = context.cards(block), context.report, context.model
    found = []
    while cards.left:
        f = context.card(cards, "velocity")
        f |= context.card(cards, "axis", optional=True)
        one, kind = f["ID"], f["STYP"].whole
        if f["ICID"].whole:
            report.refused(f["ICID"], "velocities in a local system: give them in that of the deck")
            continue
        if one.whole and kind not in (1, 2, 3):
            report.refused(f["STYP"], "a set of parts is 1, a part 2, a set of nodes 3")
            continue
        ids = None
        if one.whole and kind == 3:
            ids = model.set_of("NODE", one.whole, one.shown, one.place)
        elif one.whole:
            parts = [one.whole] if kind == 2 else model.set_of("PART", one.whole, one.shown, one.place)
            corners = model.shells.corners[np.isin(model.shells.part, parts)]
            ids = np.unique(corners[corners >= 0])
        axis, turns = _vector(context, f, ("NX", "NY", "NZ"), "-"), context.si(f["OMEGA"], "frequency")
        spin = np.zeros(3)
        if turns:
            if f["NX"].number == BY_NODES:
                report.refused(f["NX"], "an axis through two nodes: give its point and its direction")
                continue
            if not np.linalg.norm(axis) > 0.0:
                raise f["NX"].bad("an axis without a direction")
            spin = turns * axis / np.linalg.norm(axis)
        if f["PHASE"].whole:
            report.approximated(f["PHASE"], "at the start: a run has no dynamic relaxation before it")
        if f["IVATN"].number:
            report.ignored(f["IVATN"], "rigid parts of a case have no parts that follow them")
        velocity, about = _vector(context, f, ("VX", "VY", "VZ"), "velocity"), np.zeros(3)
        says = [(f[name], "velocity") for name in ("VX", "VY", "VZ")]
        if turns:
            about = _vector(context, f, ("XC", "YC", "ZC"), "length")
            says += [(f[name], "spin") for name in ("OMEGA", "NX", "NY", "NZ")]
            says += [(f[name], "about") for name in ("XC", "YC", "ZC")]
        launch = Launch(ids, velocity, spin, about, one, says, _resets(context, f["IRIGID"], "1"))
        if one.whole:
            report.mapped(f["STYP"], kind, "nodes.numbers")
        found.append(launch)
    return found
