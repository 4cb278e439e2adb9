"""Rigid walls and rigid parts of a deck as obstacles of a case: plates, balls, and meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from billow.case.obstacles.surface_file import triangles_of
from billow.decks.bag_mesh import material_of, plain_name
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.fields import known
from billow.decks.motions import Motions, guide, loads_of, motion_table, wall_motion
from billow.decks.tables import HELD
from billow.decks.velocities import Velocities
from billow.geometry.mesh_file import CellMesh
from billow.geometry.shapes.mesh import mass_properties

LENGTHS = {"RADCYL": "radius", "LENCYL": "length"}
"""Fields of a cylindrical wall -> keys of a case."""
STEEP = 0.5
"""z component of a unit normal below which a plate is placed by a point of it, else by its height on the z axis."""
THINNEST = 0.002
"""Least thickness [m] of an open surface: fabric may go a quarter of it deep."""
STIFF = 1e6
"""Contact slope [N/m] of rigid parts: 20 kPa go 0.02 mm deep."""
INERTIA = ("IXX", "IXY", "IXZ", "IYY", "IYZ", "IZZ")


def put_obstacles(
    context: Context, taken: set[int], kinds: dict[int, str], motions: Motions, velocities: Velocities,
    bag_points: np.ndarray,
) -> None:  # fmt: skip
    """The `[[obstacles]]` of walls and of rigid parts that do not belong to the bag, taken. kinds: what the command
    says of parts. bag_points: nodes of the bag [m], (n, 3), towards which plates face."""
    obstacles: list[dict[str, Any]] = []
    for block in context.model.all("RIGIDWALL"):
        obstacles += _wall(context, block)
    for part in np.unique(context.model.shells.part).tolist():
        if part in taken or kinds.get(part) in ("ignore", "fabric", "mouth", "vent"):
            continue
        material = material_of(context.model, part)
        if kinds.get(part) is None and (material is None or material[0] != "MAT_RIGID"):
            name = f"*{material[1].name}" if material else "no material"
            context.report.remarks.append(f"part {part} is left out: it has {name}; --part {part}=obstacle or =plate")
            continue
        obstacles.append(part_obstacle(context, part, material, kinds.get(part), velocities, motions, bag_points))
    put_by_name(context, obstacles)


def put_by_name(context: Context, obstacles: list[dict[str, Any]]) -> None:
    """Obstacles into the draft; of those of one name, the second gets _2, and so on."""
    names: dict[str, int] = {}
    for one in obstacles:
        names[one["name"]] = names.get(one["name"], 0) + 1
        if names[one["name"]] > 1:
            one["name"] += f"_{names[one['name']]}"
    context.tables["obstacles"] = obstacles


def _wall(context: Context, block: Block) -> list[dict[str, Any]]:
    report, kind = context.report, known(block.name)
    if kind is None:
        return []
    cards = Cards(context.model.deck.parameters, block)
    called = "wall"
    if "_ID" in block.name:
        called = plain_name(cards.titled()) or called
    context.card(cards, "nodes")
    f = context.card(cards, "wall")
    tail, head = (np.array([context.si(f[n + e], "length") for n in "XYZ"]) for e in "TH")
    normal = head - tail
    if not np.linalg.norm(normal) > 0.0:
        raise f["XH"].bad("head and tail of its normal are one point")
    normal /= np.linalg.norm(normal)
    for name in ("XT", "YT", "ZT", "XH", "YH", "ZH"):
        report.mapped(f[name], context.si(f[name], "length"), "obstacles.normal" if name[1] == "H" else "obstacles")
    friction = f["FRIC"].number
    report.mapped(f["FRIC"], min(friction, 2.0))
    shared = {"name": called, "friction": said(min(friction, 2.0), f["FRIC"])}
    source = f"{block.place} {block.name}"
    if "SPHERE" in block.name:
        size = context.card(cards, "sphere")["RADSPH"]
        report.mapped(size, context.si(size, "length"), "obstacles.radii")
        made = _ball(shared, tail, context.si(size, "length"), source)
    elif "CYLINDER" in block.name:
        size = context.card(cards, "cylinder")
        radius, length = (context.si(size[n], "length") for n in ("RADCYL", "LENCYL"))
        for k in range(size["NSEGS"].whole):
            for one in context.card(cards, "section", f"[{k + 1}]").values():
                report.refused(one, "sections of their own have no counterpart: RADCYL and LENCYL are used")
        for name in ("RADCYL", "LENCYL"):
            report.mapped(size[name], context.si(size[name], "length"), f"obstacles.{LENGTHS[name]}")
        made = {
            "shape": "cylinder", **shared, "radius": said(radius, size["RADCYL"]),
            "length": said(length, size["LENCYL"]), "place": Said((tail + 0.5 * length * normal).tolist(), source),
            "normal": Said(normal.tolist(), source),
        }  # fmt: skip
    else:
        made = _plate(shared, tail, normal, source)
    for word, card in (("PRISM", "prism"), ("FLAT", "flat")):
        if word in block.name:
            _infinite(context, context.card(cards, card, optional=True))
    if kind == "RIGIDWALL_PLANAR":
        return [made | _planar_options(context, cards, normal)]
    if "MOTION" in block.name:
        made |= {"motion": motion} if (motion := wall_motion(context, context.card(cards, "motion"))) else {}
    return [made]


def _infinite(context: Context, face: dict[str, Field]) -> None:
    """Say what a plate without end makes of a face; lengths of 0 mean one without end too."""
    for one in face.values():
        if face["LENL"].number or face["LENM"].number:
            context.report.approximated(one, "an infinite plate stands for the finite face")
        else:
            context.report.mapped(one, one.text, "obstacles", "lengths of 0: without end")


def _planar_options(context: Context, cards: Cards, normal: np.ndarray) -> dict[str, Any]:
    """The motion of *RIGIDWALL_PLANAR with its options."""
    report, name = context.report, cards.block.name
    if "ORTHO" in name:
        for one in (context.card(cards, "orthotropic") | context.card(cards, "more orthotropic")).values():
            report.refused(one, "friction that depends on the direction: FRIC is used")
    if "FINITE" in name:
        _infinite(context, context.card(cards, "finite"))
    if "MOVING" not in name:
        return {}
    f = context.card(cards, "moving")
    mass, speed = context.si(f["MASS"], "mass"), context.si(f["V0"], "velocity")
    report.mapped(f["MASS"], mass, "obstacles.motion.mass")
    report.mapped(f["V0"], speed, "obstacles.motion.speed")
    direction = said(normal.tolist(), f["V0"])
    return {"motion": {"kind": "guided", "direction": direction, "mass": said(mass, f["MASS"]),
                       "speed": said(speed, f["V0"])}}  # fmt: skip


def _plate(shared: dict[str, Any], point: np.ndarray, normal: np.ndarray, source: str) -> dict[str, Any]:
    made = {"shape": "plate", **shared, "normal": Said([float(v) for v in normal], source)}
    if abs(normal[2]) < STEEP:
        return made | {"height": Said(float(point[2]), source), "offset": Said(point[:2].tolist(), source)}
    return made | {"height": Said(float(point @ normal / normal[2]), source)}


def _ball(shared: dict[str, Any], centre: np.ndarray, radius: float, source: str) -> dict[str, Any]:
    return {
        "shape": "super-ellipsoid", **shared, "radii": Said([radius] * 3, source), "degree": 2.0,
        "offset": Said(centre[:2].tolist(), source), "clearance": Said(float(centre[2] - radius), source),
    }  # fmt: skip


def part_obstacle(
    context: Context, part: int, material: tuple[str, Block] | None, kind: str | None, velocities: Velocities,
    motions: Motions, bag_points: np.ndarray,
) -> dict[str, Any]:  # fmt: skip
    """A part as an obstacle. material: of a rigid part; kind: as the command says."""
    model, report = context.model, context.report
    shells = model.shells
    rows = np.flatnonzero(shells.part == part)
    corners = shells.corners[rows]
    ids = np.unique(corners[corners >= 0])
    at = model.nodes.rows(ids, f"a shell of part {part}", shells.place(rows[0]))
    points = model.nodes.metres(at, context.units)
    title = model.parts[part].title if part in model.parts else ""
    name = plain_name(title) or f"part_{part}"
    place = model.parts[part].place if part in model.parts else shells.place(rows[0])
    source = f"{place} PART {part}"
    rigid = rigid_of(context, material[1]) if material and material[0] == "MAT_RIGID" else None
    friction = {"friction": 0.2}
    moved = motion_table(context, motions.of_part(part, ids), context.end, rigid)
    if kind == "plate":
        middle = points.mean(axis=0)
        normal = np.linalg.svd(points - middle, full_matrices=False)[2][-1]
        normal = normal if (bag_points.mean(axis=0) - middle) @ normal >= 0.0 else -normal
        off = float(np.abs((points - middle) @ normal).max())
        report.remarks.append(
            f"part {part} becomes an infinite plate; its nodes lie up to {1e3 * off:.3g} mm away from it"
        )
        return _plate({"name": name, **friction}, middle, normal, source) | ({"motion": moved} if moved else {})
    section = model.thicknesses.get(model.parts[part].section) if part in model.parts else None
    cells = np.where(corners >= 0, np.searchsorted(ids, corners), -1)
    mesh = CellMesh(points, cells, np.ones(len(cells), np.int64), {})
    made, thickness = surface_table(context, f"part {part}", f"{name}_{part}", mesh, section, source)
    made = {"shape": "mesh", "name": name, **made, **friction}
    mass = _mass(context, part, mesh, thickness, rigid)
    middle = np.array(mass["centre"]) if mass else mass_properties(points, triangles_of(mesh), is_sheet=True)[1]
    velocity = velocities.of_part(context, part, ids, middle)
    made |= freedom(context, part, mass.pop("mass", None), rigid, kind, velocity, moved, source)
    return made | (mass if not plain(made["locked"]) else {})


def surface_table(
    context: Context, called: str, file: str, mesh: CellMesh, section: tuple[float, int, Field] | None, source: str
) -> tuple[dict[str, Any], float]:
    """The file of an obstacle's surface, and the thickness of its shells [m]. called: for messages; section: as in
    `Model.thicknesses`, None if there is none."""
    path = f"obstacles/{file}.vtkhdf"
    context.meshes[path] = mesh
    thickness = section[0] * context.units.length if section else 0.0
    if section:
        context.report.take([section[2]])
        context.report.mapped(section[2], thickness, "obstacles.thickness", "counts where its surface is open")
    if thickness < THINNEST:
        how = f"a surface that is open is {1e3 * THINNEST:g} mm thick in the case, the part {1e3 * thickness:.3g} mm"
        context.report.remarks.append(f"{called}: {how}")
    return {"file": Said(path, source), "thickness": max(thickness, THINNEST), "slope": STIFF}, thickness


def freedom(
    context: Context, part: int, mass: float | None, rigid: dict[str, Any] | None, kind: str | None,
    velocity: tuple | None, moved: dict | None, source: str,
) -> dict[str, Any]:  # fmt: skip
    """Whether a body is moved, guided, free or locked, with its mass [kg] and its motion at the start."""
    locked = {"locked": Said(True, source)}
    if moved:
        return locked | {"motion": moved}
    free = kind is not None or (rigid is not None and (rigid["turns"] or rigid["held"] != "xyz"))
    if free and not (mass and mass > 1e-3):
        context.report.remarks.append(f"part {part} has no mass that is known: it is locked")
    if not (free and mass and mass > 1e-3):
        return locked
    axis = guide(rigid) if rigid else None
    if axis is not None:
        force = loads_of(context, part, axis)
        speed = velocity[0] if velocity else Said([0.0, 0.0, 0.0])
        return locked | {"motion": {
            "kind": "guided", "direction": Said(axis.tolist(), source), "mass": Said(float(mass), source),
            "speed": Said(float(np.dot(speed.value, axis)), speed.source), **({"force": force} if force else {}),
        }}  # fmt: skip
    made = {"locked": Said(False, source), "mass": Said(float(mass), source)}
    if velocity is not None:
        if any(velocity[0].value):
            made["velocity"] = velocity[0]
        if any(velocity[1].value):
            made["spin"] = velocity[1]
    return made


def rigid_of(context: Context, block: Block) -> dict[str, Any]:
    cards, report = context.cards(block), context.report
    f = context.card(cards, "rigid")
    f |= context.card(cards, "constraint", optional=True)
    if cards.left:
        context.card(cards, "axes")
    for name in ("MID", "RO"):
        report.mapped(f[name], f[name].text, "obstacles.mass")
    for name in ("E", "PR"):
        report.ignored(f[name], "contact has a stiffness of its own: obstacles.slope")
    held = HELD.get(f["CON1"].whole, "") if f["CMO"].number == 1.0 else ""
    turns = not (f["CMO"].number == 1.0 and f["CON2"].whole == 7)
    # A case locks a body, guides it along one axis, or leaves it free.
    sound = not f["CMO"].number or (len(held) == 3) or (len(held) == 2 and not turns)
    for name in ("CMO", "CON1", "CON2"):
        if not sound and f[name].number:
            report.approximated(f[name], "constraints of single directions: the body moves freely")
        else:
            how = "locked" if len(held) == 3 else "guided" if held and not turns else "free"
            report.mapped(f[name], how, "obstacles.locked")
    return {"density": context.si(f["RO"], "density"), "held": held, "turns": turns and len(held) < 3}


def _mass(
    context: Context, part: int, mesh: CellMesh, thickness: float, rigid: dict[str, Any] | None
) -> dict[str, Any]:
    """Keys `mass`, `centre` and `inertia` of a part: of *PART_INERTIA if the deck has it, else of its shells, which are
    hollow where a closed mesh of a case is full; none if nothing says them."""
    model, report = context.model, context.report
    triangles = triangles_of(mesh)
    area, centre, per_mass = mass_properties(mesh.points, triangles, is_sheet=True)
    mass = area * thickness * rigid["density"] if rigid else 0.0
    tensor, found = mass * per_mass, {}
    for block in model.all("PART_INERTIA"):
        cards = Cards(model.deck.parameters, block)
        cards.text()
        if cards.card("part", "PID")["PID"].whole != part or not cards.left:
            continue
        f = context.card(cards, "inertia") | context.card(cards, "tensor", optional=True)
        mass = context.si(f["TM"], "mass")
        report.mapped(f["TM"], mass, "obstacles.mass")
        if f["NODEID"].whole:
            at = model.nodes.rows(np.array([f["NODEID"].whole]), f["NODEID"].shown, f["NODEID"].place)
            centre = model.nodes.metres(at, context.units)[0]
            report.mapped(f["NODEID"], str(centre.tolist()), "obstacles.centre")
        else:
            centre = np.array([context.si(f[n], "length") for n in ("XC", "YC", "ZC")])
            for k, n in enumerate(("XC", "YC", "ZC")):
                report.mapped(f[n], float(centre[k]), "obstacles.centre")
        if f["IRCS"].whole:
            report.refused(f["IRCS"], "inertia in local axes: write obstacles.inertia in those of the deck")
            tensor = mass * per_mass
        else:
            xx, xy, xz, yy, yz, zz = (context.si(f[n], "inertia") for n in INERTIA)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            for n in INERTIA:
                report.mapped(f[n], context.si(f[n], "inertia"), "obstacles.inertia")
    if mass > 0.0:
        order = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
        found = {"mass": mass, "centre": centre.tolist(), "inertia": [float(tensor[k]) for k in order]}
    return found
