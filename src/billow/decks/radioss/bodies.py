"""/RBODY, and parts that stand still, as obstacles of a case: their shells, with the mass of shells and main node."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from billow.case.obstacles.surface_file import triangles_of
from billow.decks.bag_mesh import BagMesh, plain_name
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import plain
from billow.decks.fixed import RigidPart
from billow.decks.motions import Motions, motion_table
from billow.decks.obstacles import freedom, part_obstacle, surface_table
from billow.decks.radioss.columns import card
from billow.decks.radioss.starter_file import kind_of
from billow.decks.radioss.starter_model import StarterModel, number_of
from billow.decks.velocities import Velocities
from billow.geometry.mesh_file import CellMesh
from billow.geometry.shapes.mesh import mass_properties

MOMENTS = (("Jxx", 0, 0), ("Jyy", 1, 1), ("Jzz", 2, 2), ("Jxy", 0, 1), ("Jyz", 1, 2), ("Jxz", 0, 2))
AT_MAIN, MAIN_ALONE = 3, 4
"""ICoG: the centre of mass is the main node; so it is, and the mass of shells does not count."""


@dataclass(frozen=True)
class Body:
    """One /RBODY. part: number, nodes with the main one, title and place; f: its fields, in units of its own."""

    part: RigidPart
    f: dict[str, Field]
    own: Context


def bodies_of(context: Context) -> list[Body]:
    """All rigid bodies that can be read; of the others it is said why not."""
    model, report, found = context.model, context.report, []
    for block in model.find("RBODY"):
        cards = Cards(model.deck.parameters, block)
        title = cards.text() if cards.left else ""
        if not cards.left or not kind_of(block).isdecimal():
            model.used.discard(block.name)
            continue
        own = replace(context, units=model.deck.units_of(block))
        f = card(own, cards, "RBODY", "body")
        for name in ("moments", "products"):
            f |= card(own, cards, "RBODY", name, optional=True)
        if f["sens_ID"].whole:
            report.refused(f["sens_ID"], "a body that a sensor makes rigid: it is left out")
            continue
        ids = np.union1d(model.group(f["grnd_ID"].whole, f["grnd_ID"]), [f["node_ID"].whole])
        number = number_of(block)
        part = RigidPart(number, f"body {number}", ids, title, block.place, f["node_ID"].whole)
        found.append(Body(part, f, own))
        for name in ("node_ID", "grnd_ID"):
            report.mapped(f[name], f[name].whole, "obstacles")
    return found


def constraint_of(context: Context, part: RigidPart) -> dict[str, Any]:
    """What /BCS holds of a body, as `obstacles.rigid_of` says it."""
    ways = np.zeros(6, bool)
    for held, ids in context.model.constraints:
        if np.isin(part.ids, ids).all() or part.main in ids:
            ways |= held
    axes = "".join(axis for axis, is_held in zip("xyz", ways[:3], strict=True) if is_held)
    return {"density": 0.0, "held": axes, "turns": not ways[3:].all()}


def meshes(
    context: Context, bag: BagMesh, bodies: list[Body], motions: Motions, velocities: Velocities, kinds: dict[int, str]
) -> list[dict[str, Any]]:
    """Obstacles of bodies, and of parts beside the bag that stand still or that the command names, kinds."""
    model, made = context.model, []
    outside = [part for part in np.unique(model.shells.part).tolist() if part not in bag.parts]
    outside = [part for part in outside if kinds.get(part) not in ("ignore", "fabric", "mouth", "vent")]
    nodes = {part: np.unique(corners[corners >= 0]) for part in outside
             for corners in [model.shells.corners[model.shells.part == part]]}  # fmt: skip
    for body in bodies:
        members = [part for part in outside if kinds.get(part) is None and np.isin(nodes[part], body.part.ids).all()]
        if not members:
            context.report.remarks.append(f"{body.part.called}: no shells beside the bag belong to it alone; left out")
            continue
        outside = [part for part in outside if part not in members]
        made.append(_body(context, body, members, motions, velocities))
    for part in outside:
        if kinds.get(part) is None and not np.isin(nodes[part], model.still).all():
            how = f"it is not rigid; --part {part}=obstacle or =plate"
            context.report.remarks.append(f"part {part} is left out: {how}")
            continue
        made.append(part_obstacle(context, part, None, kinds.get(part), velocities, motions, bag.start.points))
    return made


def _body(context: Context, body: Body, members: list[int], motions: Motions, velocities: Velocities) -> dict[str, Any]:
    model, report, f = context.model, context.report, body.f
    rows = np.flatnonzero(np.isin(model.shells.part, members))
    corners = model.shells.corners[rows]
    ids = np.unique(corners[corners >= 0])
    points = model.nodes.metres(model.nodes.rows(ids, f"a shell of {body.part.called}", body.part.place), context.units)
    cells = np.where(corners >= 0, np.searchsorted(ids, corners), -1)
    name, source = plain_name(body.part.title) or f"body_{body.part.number}", f"{body.part.place} /RBODY"
    section = model.thicknesses.get(model.parts[members[0]].section) if members[0] in model.parts else None
    mesh = CellMesh(points, cells, np.ones(len(cells), np.int64), {})
    table, _ = surface_table(context, body.part.called, f"{name}_{body.part.number}", mesh, section, source)
    made = {"shape": "mesh", "name": name, **table, "friction": 0.2}
    rigid = constraint_of(context, body.part)
    if not (len(rigid["held"]) in (0, 3) or (len(rigid["held"]) == 2 and not rigid["turns"])):
        report.approximated(f["node_ID"], f"held along {rigid['held']} alone: the body moves freely")
    elif len(rigid["held"]) == 3 and rigid["turns"]:
        report.approximated(f["node_ID"], "held, but free to turn: it is locked")
    moved = motion_table(context, motions.of_part(body.part.number, body.part.ids), context.end, rigid)
    mass = _mass(body, members, model)
    velocity = velocities.of_part(context, body.part.number, body.part.ids, mass["centre"])
    made |= freedom(context, body.part.number, mass["mass"], rigid, None, velocity, moved, source)
    if plain(made["locked"]):
        return made
    tensor = mass["tensor"]
    inertia = [float(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return made | {"centre": mass["centre"].tolist(), "inertia": inertia}


def _mass(body: Body, members: list[int], model: StarterModel) -> dict[str, Any]:
    """mass [kg], centre [m] (3,) and tensor about it [kg m^2] (3, 3), of shells and of the main node."""
    own, f, report = body.own, body.f, body.own.report
    how, added = f["ICoG"].whole or 1, own.si(f["Mass"], "mass")
    lumps = [] if how == MAIN_ALONE else [_lump(own, model, part) for part in members]
    at = model.nodes.rows(np.array([body.part.main]), f["node_ID"].shown, f["node_ID"].place)
    main = model.nodes.metres(at, model.deck.units)[0]
    tensor = np.zeros((3, 3))
    for name, i, j in MOMENTS:
        tensor[i, j] = tensor[j, i] = own.si(f[name], "inertia")
        report.mapped(f[name], float(tensor[i, j]), "obstacles.inertia")
    if f["Skew_ID"].whole and tensor.any():
        report.refused(f["Skew_ID"], "inertia along a skew: write obstacles.inertia in the axes of the deck")
        tensor[...] = 0.0
    if f["Ispher"].whole:
        report.refused(f["Ispher"], "inertia made that of a ball: write obstacles.inertia")
    shells = sum(mass for mass, _, _ in lumps)
    centre = main
    if how not in (AT_MAIN, MAIN_ALONE) and shells:
        centre = sum(mass * place for mass, place, _ in lumps) / shells
        if how == 1 and added:
            centre = (shells * centre + added * main) / (shells + added)
            report.approximated(f["ICoG"], "the added mass stands in the main node, its inertia in the centre", how)
    for mass, place, about in lumps:
        arm = place - centre
        tensor += about + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    report.mapped(f["Mass"], shells + added, "obstacles.mass", "with that of its shells" if shells else "")
    if not report.settled(f["ICoG"]):
        report.mapped(f["ICoG"], how, "obstacles.centre")
    return {"mass": shells + added, "centre": centre, "tensor": tensor}


def _lump(context: Context, model: StarterModel, part: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass [kg], centre [m] and inertia about it [kg m^2] of the shells of a part."""
    corners = model.shells.corners[model.shells.part == part]
    ids = np.unique(corners[corners >= 0])
    points = model.nodes.metres(model.nodes.rows(ids, f"a shell of part {part}", str(part)), model.deck.units)
    mesh = CellMesh(points, np.where(corners >= 0, np.searchsorted(ids, corners), -1), np.ones(len(corners)), {})
    area, centre, per_mass = mass_properties(points, triangles_of(mesh), is_sheet=True)
    told, mass = model.parts.get(part), 0.0
    section = model.thicknesses.get(told.section) if told else None
    law = model.law_of(part)
    if section and law:
        f = model.cards(law[1]).optional("density", "rho_i rho_0", "", (20, 20))
        context.report.take(f.values())
        context.report.mapped(f["rho_i"], f["rho_i"].text, "obstacles.mass")
        density = model.deck.units_of(law[1]).si(f["rho_i"].number, "density")
        mass = area * section[0] * model.deck.units.length * density
    return mass, centre, mass * per_mass
