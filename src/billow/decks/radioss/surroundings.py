"""What is around the bag in a starter deck, /RWALL, /INTER, /GRAV, and the times of the run, from the engine file."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.decks.bag_mesh import BagMesh, plain_name
from billow.decks.block import Block
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.parameters import number
from billow.decks.radioss.columns import card
from billow.decks.radioss.starter_model import StarterModel, kind_of

LONG, LONGEST = 8.0, 10.0
"""Length of a cylinder that stands for an endless one: in sizes of the bag, and at most [m]."""


def walls(context: Context, bag: BagMesh) -> list[dict[str, Any]]:
    """The `[[obstacles]]` of /RWALL."""
    obstacles: list[dict[str, Any]] = []
    for block in context.model.find("RWALL"):
        obstacles += _wall(context, block, bag)
    return obstacles


def _wall(context: Context, block: Block, bag: BagMesh) -> list[dict[str, Any]]:
    model, report = context.model, context.report
    own, kind = replace(context, units=model.deck.units_of(block)), kind_of(block)
    cards = model.cards(block)
    if kind not in ("PLANE", "SPHER", "CYL", "PARAL"):
        model.used.discard(block.name)
        return []
    name = plain_name(cards.block.body.split(b"\n")[0].decode("latin-1").strip()) or "wall"
    f = card(own, cards, "RWALL", "nodes") | card(own, cards, "RWALL", "wall") | card(own, cards, "RWALL", "M")
    if f["node_ID"].whole:
        report.refused(f["node_ID"], "a wall that moves with a node: write a free obstacle; it is left out")
        return []
    source = f"{block.place} {block.shown}"
    slides = f["Slide"].whole == 0
    friction = 0.0 if slides else min(f["fric"].number, 2.0)
    if f["Slide"].whole == 1:
        report.approximated(f["Slide"], "nodes are not tied; friction of 2", key="obstacles.friction")
        friction = 2.0
    else:
        report.mapped(f["Slide"], friction, "obstacles.friction")
    report.mapped(f["fric"], friction, "obstacles.friction", "without effect: Slide is 0" if slides else "")
    for one in ("Dsearch", "ffac", "ifq", "grnd_ID1", "grnd_ID2"):
        report.ignored(f[one], "a wall of a case stops all fabric")
    m = _point(own, f, ("XM", "YM", "ZM"))
    shared = {"name": name, "friction": said(friction, f["fric"])}
    if kind == "SPHER":
        radius = 0.5 * own.si(f["Diameter"], "length")
        report.mapped(f["Diameter"], radius, "obstacles.radii")
        return [_ellipsoid(shared, m, np.full(3, radius), 2.0, source)]
    g = card(own, cards, "RWALL", "M1")
    along = _point(own, g, ("XM1", "YM1", "ZM1")) - m
    if not np.linalg.norm(along) > 0.0:
        raise g["XM1"].bad("M and M1 are one point")
    along /= np.linalg.norm(along)
    if kind == "CYL":
        size = float(np.ptp(bag.start.points, axis=0).max())
        radius = 0.5 * own.si(f["Diameter"], "length")
        length = min(LONG * size, LONGEST)
        report.approximated(f["Diameter"], f"{length:.3g} m long, not endless", 2.0 * radius, "obstacles.radius")
        return [{
            "shape": "cylinder", **shared, "radius": said(radius, f["Diameter"]), "length": Said(length, source),
            "place": Said(m.tolist(), source), "normal": Said(along.tolist(), source), "locked": True,
        }]  # fmt: skip
    if kind == "PARAL":
        h = card(own, cards, "RWALL", "M2")
        along = np.cross(along, _point(own, h, ("XM2", "YM2", "ZM2")) - m)
        along /= max(float(np.linalg.norm(along)), 1e-300)
        report.remarks.append(f"{block.place}: an infinite plate stands for the parallelogram")
    plate = {"shape": "plate", **shared, "height": Said(float(m[2]), source)}
    plate["offset"] = Said([float(m[0]), float(m[1])], source)
    return [plate | {"normal": Said([float(v) for v in along], source)}]


def _point(context: Context, f: dict[str, Field], names: tuple[str, ...]) -> np.ndarray:
    values = [context.si(f[name], "length") for name in names]
    for name, value in zip(names, values, strict=True):
        context.report.mapped(f[name], value, "obstacles")
    return np.array(values)


def _ellipsoid(shared, centre: np.ndarray, half: np.ndarray, degree: float, source: str) -> dict[str, Any]:
    return {
        "shape": "super-ellipsoid", **shared, "radii": Said([float(v) for v in half], source), "degree": degree,
        "offset": Said([float(centre[0]), float(centre[1])], source), "locked": True,
        "clearance": Said(float(centre[2] - half[2]), source),
    }  # fmt: skip


def put_interfaces(context: Context, bag: BagMesh) -> None:
    """Friction, and whether layers of fabric are kept apart."""
    model, report = context.model, context.report
    mine = set(bag.nodes.tolist())
    for block in model.find("INTER"):
        if kind_of(block) not in ("TYPE7", "TYPE19"):
            model.used.discard(block.name)
            continue
        cards = model.cards(block)
        f = card(context, cards, "INTER", "sides")
        for name in ("gap", "stiffness", *(["curvature"] if f["Icurv"].whole in (1, 2) else []), "friction"):
            f |= card(context, cards, "INTER", name, optional=True)
        first = model.surface if kind_of(block) == "TYPE19" else model.group
        sides = [_nodes(model, first(f["ids_s"].whole, f["ids_s"]))]
        sides.append(_nodes(model, model.surface(f["surf_IDm"].whole, f["surf_IDm"])))
        both = all(mine & side for side in sides)
        for name in ("ids_s", "surf_IDm"):
            report.ignored(f[name], "a case keeps all fabric apart from itself and from all obstacles")
        value = min(max(f["Fric"].number, 0.0), 2.0)
        if both:
            context.set("fabric.self_contact", True, f["ids_s"])
            if value:
                context.set("fabric.friction", value, f["Fric"])
                how = "friction between layers counts with fabric.self_contact = layers only"
                report.approximated(f["Fric"], how, value, "fabric.friction")
            else:
                report.mapped(f["Fric"], value, "fabric.friction")
        else:
            report.mapped(f["Fric"], value, "obstacles.friction", "obstacles have their own")
        for name in ("Stfac", "Gapmin", "Istf", "Igap", "Stmin", "Stmax"):
            report.ignored(f[name], "contact of a case has a stiffness of its own: obstacles.slope")
        report.mapped(f["Ibag"], f["Ibag"].whole, "bag.vents.blockage")


def _nodes(model: StarterModel, found) -> set[int]:
    if isinstance(found, tuple):
        parts, segments = found
        found = np.concatenate([model.shells.corners[np.isin(model.shells.part, parts)].ravel(), segments.ravel()])
    return set(found[found >= 0].tolist())


def put_run(context: Context, base: dict[str, Any]) -> None:
    """Gravity; and end and frames of the engine file beside the starter file, NAME_0001.rad beside NAME_0000.rad."""
    run, model, report = dict(base.get("run", {})), context.model, context.report
    for block in model.find("GRAV"):
        own = replace(context, units=model.deck.units_of(block))
        f = card(own, model.cards(block), "GRAV", "gravity")
        axis = "XYZ".find(f["Dir"].text.upper()) if len(f["Dir"].text) == 1 else -1
        if axis < 0 or f["skew_ID"].whole:
            report.refused(f["Dir"], "gravity along a skew: write run.gravity")
            continue
        points = model.curve(f["fct_IDT"]).points
        value = (
            own.units.si(float(points[0, 1]) * (f["Fscale_y"].number or 1.0), "acceleration") if len(points) else 0.0
        )
        gravity = list(plain(run.get("gravity", [0.0, 0.0, 0.0])))
        gravity[axis] += value
        run["gravity"] = said(gravity, f["fct_IDT"])
        varies = len(points) and np.ptp(points[:, 1])
        if varies:
            report.approximated(f["fct_IDT"], "it varies in time; its first value is kept", value, "run.gravity")
        else:
            report.mapped(f["fct_IDT"], value, "run.gravity")
        report.mapped(f["Dir"], f["Dir"].text, "run.gravity")
    engine = model.deck.path.with_name(re.sub(r"0000(?=\.rad$)", "0001", model.deck.path.name))
    if engine != model.deck.path and engine.is_file():
        _times(context, engine, run)
    elif "end_time" not in run:
        report.remarks.append(f"no engine file {engine.name}: the end of the run is that of a case by default")
    context.tables["run"] = run


def _times(context: Context, engine, run: dict[str, Any]) -> None:
    try:
        lines = read_bytes(engine, LARGEST_DATA).decode("latin-1").splitlines()
    except (OSError, ValueError):
        return
    units, found = context.model.deck.work_units, {}
    for k, line in enumerate(lines[:-1]):
        key = re.match(r"/(RUN/|ANIM/DT|TFILE)", line.upper())
        if key:
            texts = lines[k + 1].split()
            with_value = texts[-1:] if key[1] == "ANIM/DT" else texts[:1]
            try:
                found[key[1]] = units.si(number(with_value[0]), "time") if with_value else 0.0
            except ValueError:
                continue
            context.report.remarks.append(f"{engine.name}:{k + 2}: {line.strip()} {found[key[1]]:.6g} s")
    end = found.get("RUN/", 0.0)
    if not end > 0.0:
        return
    run["end_time"] = Said(end, f"{engine.name} /RUN")
    frames = 0
    if found.get("ANIM/DT", 0.0) > 0.0:
        frames = max(1, min(round(end / found["ANIM/DT"]), 1000))
        run["frames"] = Said(frames, f"{engine.name} /ANIM/DT")
    if frames and found.get("TFILE", 0.0) > 0.0:
        rows = max(1, min(round(end / frames / found["TFILE"]), 1000))
        run["histories_per_frame"] = Said(rows, f"{engine.name} /TFILE")
