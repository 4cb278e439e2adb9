"""What is allowed but probably not meant: slips of units and settings that defeat each other.

Ranges in the schema refuse the impossible. Concerns look at quantities together; they are printed before a run, kept in
its record, and turn its verdict to REVIEW. Each part has its own; those of the mesh are here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.base.plausible import unusual
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.schema import Case
from billow.geometry.crossings import CrossingCount
from billow.geometry.reference_check import NOTICED, Panel, panels, place
from billow.parts.fabric.fabric import STEP_FACTOR
from billow.parts.fabric.mass_shares import fastest, share_mass
from billow.solver.model import Model

START_STRAIN = 0.05  # of fabric or straps at the start: from here on it cannot be meant
MANY = 0.05  # share of a panel's triangles from which on compression is no matter of a few odd elements
FEWEST = 10  # elements across a chamber below which shape and volume mean little

COARSE = Concern.declare(
    "W-MESH-001",
    "only {count:.0f} elements across the {room}",
    where="{key}",
    why="shape and volume will be off by several percent",
    cause="an element size for a quick look",
    remedy="use at least twenty elements across",
)
STRETCHED = Concern.declare(
    "W-MESH-002",
    f"{{share:.3g}} % of part {{part}} starts stretched by more than {100 * NOTICED:g} %, at most by {{most:.3g}} %",
    where="{place}; {key}",
    why="it would snap back at the first step: the start shape is not the shape the fabric was cut in",
    cause="a start shape that is too high, or reference coordinates that belong to other nodes",
    remedy="use a bag.initial_gap of a few millimetres; for a mesh, set bag.birth_time to 1 or 2 ms",
)
STRETCHED_STRAP = Concern.declare(
    "W-MESH-003",
    "a strap of {length:g} m starts {distance:.3g} m long",
    where="{key}, strap {strap}",
    why="it would snap back at the first step",
    cause="a strap shorter than the distance of its ends",
    remedy="give the strap more length or slack in bag.straps",
)
COMPRESSED = Concern.declare(
    "W-MESH-004",
    f"{{share:.3g}} % of part {{part}} starts compressed by more than {100 * NOTICED:g} %, at most by {{most:.3g}} %",
    where="{place}; {key}",
    why="folds keep lengths, and a start shape smaller than the flat cut has lost some of its fabric",
    cause="a start shape in another unit than the reference, or one that was shortened by folding",
    remedy="check bag.unit and bag.reference, or fold the start shape without shortening it",
)
COLLAPSED = Concern.declare(
    "W-MESH-005",
    "{share:.3g} % of part {part} has collapsed at the start",
    where="{place}; {key}",
    why="a triangle without area has no side that gas could push on",
    cause="nodes in the same place, from a mesh that was folded or merged carelessly",
    remedy="move the nodes of the start shape apart",
)

SLIVERS = Concern.declare(
    "W-MESH-006",
    "slivers, {count} of {triangles} triangles, make the step {now:.3g} us instead of {without:.3g} us",
    where="{place}; {key}",
    why="the smallest height of a triangle sets the step; the run takes {times:.3g} times as long",
    cause="slivers left by a mesher or by merging nodes",
    remedy="collapse the short edges of these triangles, or mesh that spot again",
)
CROSSED = Concern.declare(
    "W-MESH-007",
    "the bag passes through itself at the start, at {count} places",
    where="{place}; {key}",
    why="layers that have crossed never part again, and gas between them pushes both the wrong way",
    cause="a mesh folded by another tool without a check, or folds without a row of nodes along them",
    remedy="move the start shape apart there",
)
FOLDED_VENT = Concern.declare(
    "W-MESH-008",
    "a fold line goes through {vent}",
    where="bag.folds",
    why="the elements around a vent follow its rim, not the line: layers may cut each other there, and gas leaves from "
    "within the fold",
    cause="a vent where the bag is folded",
    remedy="move the vent or the line, and look at the crossings that billow check counts",
)
TIGHT = Concern.declare(
    "W-MESH-009",
    "the panels of a folded sheet lie {apart:.3g} mm apart, the fabric is {thickness:.3g} mm thick",
    where="bag.folds; fabric.thickness",
    why="contact would push them apart at the first step",
    cause="a thick fabric, or a bag.folds.layer_gap for a thinner one",
    remedy="raise bag.folds.layer_gap to at least twice the thickness",
)
NO_LAYERS = Concern.declare(
    "W-FAB-006",
    "layers of the folded bag may pass through each other",
    where="fabric.self_contact",
    why="springs are made for bags that start flat, and without self-contact nothing keeps folded layers apart: the "
    "run may complete with fabric that has crossed",
    remedy='leave fabric.self_contact away, or set it to "layers"',
)
NO_FRICTION = Concern.declare(
    "W-FAB-007",
    "the friction between layers of fabric has no effect",
    where="fabric.friction",
    why='only fabric.self_contact = "layers" knows it',
    remedy='set fabric.self_contact = "layers", or remove fabric.friction',
)
NOT_TOUCHED = Concern.declare(
    "W-OBS-217",
    "{body} is {gap:.3g} m away from nodes that {count} groups hold in some directions only",
    where="nodes, obstacles.{body}",
    why="obstacles do not touch such nodes, and may pass between them",
    cause="a rail or a plane of symmetry where an obstacle may come",
    remedy="hold nodes only where no obstacle comes, or in all directions",
)
FEW = 0.01
"""Share of the triangles, but at least four, that is compared with the others."""
COSTLY = 5.0
"""Times by which they may shorten the step."""


def concerns_of(case: Case, model: Model) -> list[Concern]:
    """Everything about a case that looks unintended."""
    setting = model.setting(case.run.end_time)
    of_parts = [concern for _, part in model.parts for concern in part.concerns(setting)]
    of_mesh = [
        concern
        for ask in (_units, _size, _slivers, _panels, _straps, _folds, _layers, _crossings, _rails)
        for concern in ask(case, model)
    ]
    return [*of_mesh, *of_parts]


def _units(case: Case, model: Model) -> Iterator[Concern]:
    """What hints at numbers in another unit comes first."""
    bag = case.bag
    size = float(np.ptp(model.start[np.unique(model.surface.triangles)], axis=0).max())
    if bag.shape == "mesh":
        change = 'write bag.unit = "{unit}"'
        yield from unusual("bag size", size, "the width of the mesh", bag.start, change, bag.unit)
    else:
        yield from unusual("bag size", size, "the width of the bag", "bag", "write the unit")
    pressure = case.ambient.pressure
    yield from unusual("ambient pressure", pressure, "the ambient pressure", "ambient.pressure", "write the unit")


def _size(case: Case, model: Model) -> Iterator[Concern]:
    chambers = model.surface.chambers.count
    fabric = model.fabric.area
    across = 2.0 * np.sqrt(fabric / chambers / (2.0 * np.pi))  # two discs of the same area
    edge = np.sqrt(4.0 / np.sqrt(3.0) * fabric / model.fabric.element_count)
    if edge > across / FEWEST:
        key = "bag.start" if case.bag.shape == "mesh" else "bag.element_size"
        yield COARSE(count=across / edge, room="bag" if chambers == 1 else "chambers", key=key)


def _slivers(case: Case, model: Model) -> Iterator[Concern]:
    membranes, triangles = model.fabric.membranes, model.surface.triangles
    now = STEP_FACTOR * fastest(membranes) ** -0.5
    for k, membrane in enumerate(membranes):
        order = np.argsort(-membrane.alone.squared_rate)
        steps = membrane.alone.squared_rate[order] ** -0.5
        few = min(max(math.ceil(FEW * len(steps)), 4), len(steps) // 4)
        count = int(np.searchsorted(steps[:few], steps[few] / COSTLY))
        if not count:
            continue
        rest = (*membranes[:k], membrane.only(order[count:]), *membranes[k + 1 :])
        without = STEP_FACTOR * fastest(share_mass(rest, triangles)) ** -0.5
        if without >= COSTLY * now:
            worst = place(model.surface, model.start, int(membrane.elements[order[0]]))
            key = "bag.start" if case.bag.shape == "mesh" else "bag"
            yield SLIVERS(
                count=count, triangles=len(steps), now=1e6 * now, without=1e6 * without, times=without / now,
                place=worst, key=key,
            )  # fmt: skip


def _folds(case: Case, model: Model) -> Iterator[Concern]:
    plan = fold_plan(case.bag)
    if plan is None:
        return
    thickness = max(membrane.fabric.thickness for membrane in model.fabric.membranes)
    if 2.0 * plan.half < thickness:
        yield TIGHT(apart=2e3 * plan.half, thickness=1e3 * thickness)
    flat = plan.unfolded(build_shape(case.bag).positions)
    lines = [(axis, row.place) for axis in (0, 1) for row in plan.rows(axis)]
    crossed = {vent for line in lines for vent in plan.vents_on(model.surface, flat, *line)}
    for vent in sorted(crossed):
        yield FOLDED_VENT(vent=vent)


def _layers(case: Case, model: Model) -> Iterator[Concern]:
    if model.layers is not None:
        return
    if getattr(case.bag, "folds", ()):
        yield NO_LAYERS()
    if case.fabric.friction:
        yield NO_FRICTION()


def _crossings(case: Case, model: Model) -> Iterator[Concern]:
    per_triangle = CrossingCount(model.surface).per_triangle(model.start)
    if per_triangle.any():
        worst = place(model.surface, model.start, int(per_triangle.argmax()))
        key = "bag.start" if case.bag.shape == "mesh" else "bag.folds" if getattr(case.bag, "folds", ()) else "bag"
        yield CROSSED(count=int(per_triangle.sum()), place=worst, key=key)


def _straps(case: Case, model: Model) -> Iterator[Concern]:
    driver = case.bag.shape == "driver"
    ends = model.start[model.straps.bars]
    distance = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    taut = distance / model.straps.length - 1.0
    if len(taut) and taut.max() > START_STRAIN:
        bar = int(taut.argmax())
        closer = "raise bag.straps.length, or bring bag.straps.stitch_radius closer to bag.mouth_radius"
        length, strap = model.straps.length[bar], model.straps.strap[bar] + 1
        key, remedy = ("bag.straps.length", closer) if driver else ("bag.straps", None)
        yield STRETCHED_STRAP(length=length, distance=distance[bar], strap=strap, key=key, remedy=remedy)


def _rails(case: Case, model: Model) -> Iterator[Concern]:
    driven = model.driven
    if driven is None or not driven.yielding.any():
        return
    places, across = model.start[driven.nodes[driven.yielding > 0.0]], model.setting(case.run.end_time).across
    count = sum(bool(driven.yielding[members].any()) for members in driven.groups.values())
    for body in model.bodies.bodies:
        gap = float(body.distance(places).min())
        if gap < 0.5 * across:
            yield NOT_TOUCHED(body=body.name, gap=gap, count=count)


def start_panels(model: Model) -> list[Panel]:
    """How every panel's start shape fits its flat cut."""
    found = []
    for membrane in model.fabric.membranes:
        d11, d12, d21, d22 = membrane.reference_inverse
        first, second = (np.column_stack(e) / (d11 * d22 - d12 * d21)[:, None] for e in ((d22, -d21), (-d12, d11)))
        flat = np.stack([np.zeros_like(first), first, second], axis=1)
        found += panels(model.surface, model.start, membrane.elements, flat)
    return found


def _panels(case: Case, model: Model) -> Iterator[Concern]:
    read, folded = case.bag.shape == "mesh", bool(getattr(case.bag, "folds", ()))
    if (read or folded) and case.bag.birth_time:
        return  # the user knows, and the reference moves slowly
    key = "bag.start, bag.reference" if read else "bag.folds" if folded else "bag.initial_gap"
    born = (
        'end bag.folds with kind = "relax", or set bag.birth_time to a few ms'
        if folded
        else "set bag.birth_time to 1 or 2 ms"
    )
    for panel in start_panels(model):
        part = panel.name
        if panel.longest > 1.0 + START_STRAIN:
            at, most = place(model.surface, model.start, panel.longest_at), 100 * (panel.longest - 1.0)
            remedy = born if read or folded else "use a bag.initial_gap of a few millimetres"
            yield STRETCHED(share=100 * panel.stretched, part=part, most=most, place=at, key=key, remedy=remedy)
        if panel.collapsed:  # a fold shortens the elements beside its line on purpose, but never to nothing
            at = place(model.surface, model.start, panel.collapsed_at)
            yield COLLAPSED(share=100 * panel.collapsed, part=part, place=at, key=key)
        elif not folded and panel.compressed > MANY and panel.shortest < 1.0 - START_STRAIN:
            at, most = place(model.surface, model.start, panel.shortest_at), 100 * (1.0 - panel.shortest)
            yield COMPRESSED(share=100 * panel.compressed, part=part, most=most, place=at, key=key)
