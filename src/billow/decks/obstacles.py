"""Rigid walls and rigid parts of a deck as obstacles of a case: plates, and super-ellipsoids that fit what they
replace."""

from __future__ import annotations

from typing import Any

import numpy as np

from billow.decks.bag_mesh import material_of, plain_name
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.fields import known
from billow.decks.motions import HELD, Motions, guide, loads_of, motion_table, wall_motion

BOXY = 4.0
"""Degree of a super-ellipsoid that stands for a body of facets."""
STEEP = 0.5
"""z component of a unit normal below which a plate is placed by a point of it, else by its height on the z axis."""
FLAT = 1e-3
"""Smallest over largest extent of a rigid part below which it is a plate."""
THINNEST = 0.01
"""Least radius [m] of a super-ellipsoid that stands for a flat body."""


def put_obstacles(
    context: Context, taken: set[int], kinds: dict[int, str], motions: Motions, bag_points: np.ndarray
) -> None:
    """The `[[obstacles]]` of walls and of rigid parts that do not belong to the bag, taken. kinds: what the command
    says of parts. bag_points: nodes of the bag [m], (n, 3), towards which plates face."""
    obstacles: list[dict[str, Any]] = []
    for block in context.model.all("RIGIDWALL"):
        obstacles += _wall(context, block)
    velocity = _velocities(context)
    for part in np.unique(context.model.shells.part).tolist():
        if part in taken or kinds.get(part) in ("ignore", "fabric", "mouth", "vent"):
            continue
        material = material_of(context.model, part)
        if kinds.get(part) is None and (material is None or material[0] != "MAT_RIGID"):
            name = f"*{material[1].name}" if material else "no material"
            context.report.remarks.append(f"part {part} is left out: it has {name}; --part {part}=obstacle or =plate")
            continue
        obstacles.append(_part(context, part, material, kinds.get(part), velocity.get(part), motions, bag_points))
    names: dict[str, int] = {}
    for one in obstacles:
        names[one["name"]] = names.get(one["name"], 0) + 1
        if names[one["name"]] > 1:
            one["name"] += f"_{names[one['name']]}"
    context.tables["obstacles"] = obstacles


def _flatness(points: np.ndarray) -> tuple[float, np.ndarray]:
    """Smallest over largest extent of points (n, 3) about their middle, and the direction of the smallest."""
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return float(sizes[-1] / max(sizes[0], 1e-300)), axes[-1]


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
        made = _ellipsoid(shared, tail, np.full(3, context.si(size, "length")), 2.0, source)
    elif "CYLINDER" in block.name:
        size = context.card(cards, "cylinder")
        radius, length = (context.si(size[n], "length") for n in ("RADCYL", "LENCYL"))
        half = np.where(np.abs(normal) > 0.9, 0.5 * length, radius)
        for name in ("RADCYL", "LENCYL"):
            report.approximated(size[name], f"a super-ellipsoid of degree {BOXY:g}, along the nearest axis")
        made = _ellipsoid(shared, tail + 0.5 * length * normal, half, BOXY, source)
    else:
        made = _plate(shared, tail, normal, source)
    if "PRISM" in block.name or "FLAT" in block.name:
        _infinite(context, context.card(cards, "flat", optional=True))
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


def _ellipsoid(
    shared: dict[str, Any], centre: np.ndarray, half: np.ndarray, degree: float, source: str
) -> dict[str, Any]:
    return {
        "shape": "super-ellipsoid", **shared, "radii": Said([float(v) for v in half], source), "degree": degree,
        "offset": Said([float(centre[0]), float(centre[1])], source),
        "clearance": Said(float(centre[2] - half[2]), source),
    }  # fmt: skip


def _part(
    context: Context, part: int, material: tuple[str, Block] | None, kind: str | None, velocity: tuple | None,
    motions: Motions, bag_points: np.ndarray,
) -> dict[str, Any]:  # fmt: skip
    model, report = context.model, context.report
    shells = model.shells
    rows = np.flatnonzero(shells.part == part)
    corners = shells.corners[rows]
    ids = np.unique(corners[corners >= 0])
    at = model.nodes.rows(ids, f"a shell of part {part}", shells.place(rows[0]))
    points = model.nodes.points[at] * context.units.length
    low, high = points.min(axis=0), points.max(axis=0)
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    title = model.parts[part].title if part in model.parts else ""
    name = plain_name(title) or f"part_{part}"
    place = model.parts[part].place if part in model.parts else shells.place(rows[0])
    source = f"{place} PART {part}"
    rigid = _rigid(context, material[1]) if material and material[0] == "MAT_RIGID" else None
    friction = {"friction": 0.2}
    moved = motion_table(context, motions.of_part(part, ids), plain(context.tables["run"]).get("end_time", 0.05), rigid)
    flat, normal = _flatness(points)
    if kind == "plate" or (kind is None and flat < FLAT):
        middle = points.mean(axis=0)
        normal = normal if (bag_points.mean(axis=0) - middle) @ normal >= 0.0 else -normal
        off = float(np.abs((points - middle) @ normal).max())
        report.remarks.append(
            f"part {part} becomes an infinite plate; its nodes lie up to {1e3 * off:.3g} mm away from it"
        )
        return _plate({"name": name, **friction}, middle, normal, source) | ({"motion": moved} if moved else {})
    half = np.maximum(half, THINNEST)
    fitted = np.abs((points - centre) / half)
    # Of a point, how much larger a super-ellipsoid would pass through it.
    gap = float((np.sum(fitted**BOXY, axis=1) ** (1.0 / BOXY) - 1.0).max() * half.min())
    made = _ellipsoid({"name": name, **friction}, centre, half, BOXY, source)
    report.remarks.append(
        f"part {part} becomes a super-ellipsoid of degree {BOXY:g} with its extents; its nodes stand out by up to "
        f"{1e3 * max(gap, 0.0):.3g} mm"
    )
    return made | _freedom(context, part, _mass(context, part, rows, rigid), rigid, kind, velocity, moved, source)


def _freedom(
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
        made["velocity"] = velocity[0]
        if any(velocity[1].value):
            made["spin"] = velocity[1]
    return made


def _rigid(context: Context, block: Block) -> dict[str, Any]:
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


def _mass(context: Context, part: int, rows: np.ndarray, rigid: dict[str, Any] | None) -> float | None:
    """Of the shells, area times thickness times density [kg]; of *PART_INERTIA if the deck has it."""
    model = context.model
    for block in model.all("PART_INERTIA"):
        cards = Cards(model.deck.parameters, block)
        cards.text()
        if cards.card("part", "PID")["PID"].whole == part and cards.left:
            mass = cards.card("inertia", "XC YC ZC TM IRCS NODEID")["TM"]
            context.report.take([mass])
            context.report.mapped(mass, context.si(mass, "mass"), "obstacles.mass")
            return context.si(mass, "mass")
    if rigid is None or part not in model.parts:
        return None
    section = model.thicknesses.get(model.parts[part].section)
    if section is None:
        return None
    shells = model.shells
    corners = np.where(shells.corners[rows] < 0, shells.corners[rows, :1], shells.corners[rows])
    at = model.nodes.rows(corners, f"a shell of part {part}", shells.place(rows[0]))
    a, b, c, d = (model.nodes.points[at[:, k]] * context.units.length for k in range(4))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) + 0.5 * np.linalg.norm(np.cross(c - a, d - a), axis=1)
    if (shells.corners[rows, 3] < 0).any():
        triangle = shells.corners[rows, 3] < 0
        area[triangle] = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)[triangle]
    return float(area.sum()) * section[0] * context.units.length * rigid["density"]


def _velocities(context: Context) -> dict[int, tuple[Said, Said]]:
    """Velocity [m/s] and spin [rad/s] of parts at the start."""
    found: dict[int, tuple[Said, Said]] = {}
    model, report = context.model, context.report

    def keep(parts: list[int], v: list[Field], w: list[Field]) -> None:
        moves = [context.si(one, "velocity") for one in v]
        turns = [context.si(one, "frequency") for one in w] or [0.0, 0.0, 0.0]
        for one, value in zip(v, moves, strict=True):
            report.mapped(one, value, "obstacles.velocity")
        for one, value in zip(w, turns, strict=False):
            report.mapped(one, value, "obstacles.spin")
        speeds = said(moves, v[0])
        spins = said(turns, (w or v)[0])
        for part in parts:
            found[part] = speeds, spins

    for block in model.all("INITIAL_VELOCITY_RIGID_BODY"):
        cards = context.cards(block)
        while cards.left:
            f = context.card(cards, "velocity")
            report.mapped(f["PID"], f["PID"].whole, "obstacles")
            keep([f["PID"].whole], [f[n] for n in ("VX", "VY", "VZ")], [f[n] for n in ("VXR", "VYR", "VZR")])
    for block in model.all("INITIAL_VELOCITY_GENERATION"):
        cards = context.cards(block)
        f = context.card(cards, "velocity")
        context.card(cards, "axis", optional=True)
        one, kind = f["ID"], f["STYP"].whole
        if kind not in (1, 2):
            report.refused(one, "a velocity of single nodes, or of all: give it to a rigid part")
            continue
        parts = model.set_of("PART", one.whole, one.shown, one.place).tolist() if kind == 1 else [one.whole]
        report.mapped(one, str(parts)[1:-1], "obstacles")
        if f["OMEGA"].number:
            report.refused(f["OMEGA"], "a spin about an axis: write obstacles.spin yourself")
        keep(parts, [f[n] for n in ("VX", "VY", "VZ")], [])
    return found
