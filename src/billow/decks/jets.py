"""Orifices of *AIRBAG_PARTICLE and _ALE, and the jet of JETTING, as the ring of jets of a case."""

from __future__ import annotations

import math

import numpy as np

from billow.decks.airbag_gas import Airbag
from billow.decks.bag_mesh import BagMesh
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import said

ROUND = 0.05
"""Share of the ring's radius by which orifices may lie beside it, and of angles in radians."""
ASIDE = math.radians(10.0)
"""Angle between a jet and the axis of the mouth up to which it counts as along the axis."""


def put_jets(context: Context, airbag: Airbag, bag: BagMesh) -> None:
    """The `jets` of each inflator that has orifices; a diffuse source where they make no ring in a mouth."""
    report = context.report
    for number, rows in airbag.orifices.items():
        inflator = context.tables["inflator"][number]
        ring = _ring(context, rows, bag)
        for field, *_ in rows:
            if isinstance(ring, str):
                report.approximated(field, f"a diffuse source stands for the orifices: {ring}", key="inflator.jets")
            else:
                report.mapped(field, f"ring of {ring['count']}", "inflator.jets", ring.pop("note", ""))
        if not isinstance(ring, str):
            inflator["jets"] = {key: said(value, rows[0][0]) for key, value in ring.items()}
    if airbag.jet:
        _put_jet(context, airbag.jet, bag)


def _put_jet(context: Context, f: dict[str, Field], bag: BagMesh) -> None:
    """One jet of JETTING: a ring of one hole on the axis of the mouth, if it lies there."""
    report = context.report
    ends = [np.array([context.si(f[x + n], "length") for x in "XYZ"]) for n in ("JFP", "JVH")]
    focus, head = ends
    named = [f[x + n] for n in ("JFP", "JVH") for x in "XYZ"]
    why = _off_axis(focus, head - focus, bag)
    if why:
        for one in named:
            report.refused(one, f"a jet of a case comes out of its mouth along the axis, and {why}: left out")
        return
    ring = {"count": 1, "ring_radius": 1e-3, "angle": 0.0}
    for inflator in context.tables["inflator"]:
        inflator["jets"] = {key: said(value, named[0]) for key, value in ring.items()}
    for one in named:
        report.approximated(one, "a hole of 5 mm in the middle of the mouth; the card gives none", key="inflator.jets")
    report.approximated(f["CA"], "the jet of uniform pressure widens by a law of its own (docs/theory.md, Jets)")
    if f["BETA"].number not in (0.0, 1.0):
        report.refused(f["BETA"], "the thrust of a jet is that of its mass and speed; there is no factor")


def _off_axis(focus: np.ndarray, along: np.ndarray, bag: BagMesh) -> str:
    """Why a jet from a point [m] in a direction is not one of the bag's mouth; empty if it is."""
    mouths = [number for number, part in bag.parts.items() if part["kind"] == "mouth"]
    if len(mouths) != 1:
        return f"the bag has {len(mouths) or 'no'} mouth{'s' if mouths else ''}"
    cells = bag.start.cells[bag.start.part == mouths[0]]
    a, b, c, d = (bag.start.points[np.where(cells[:, k] < 0, cells[:, 2], cells[:, k])] for k in range(4))
    area = 0.5 * np.cross(c - a, d - b).sum(axis=0)
    points = bag.start.points[np.unique(cells[cells >= 0])]
    radius = math.sqrt(np.linalg.norm(area) / math.pi)
    axis = -area / np.linalg.norm(area)
    if not np.linalg.norm(along) > 0.0:
        return "its direction is not known"
    off = math.acos(np.clip(along @ axis / np.linalg.norm(along), -1.0, 1.0))
    if off > ASIDE:
        return f"this one leans by {math.degrees(off):.3g} deg"
    away = focus - points.mean(axis=0)
    away = float(np.linalg.norm(away - (away @ axis) * axis))
    return f"this one lies {1e3 * away:.3g} mm beside it" if away > radius else ""


def _ring(context: Context, rows, bag: BagMesh) -> dict | str:
    """Keys of the jets, or why there are none."""
    if not any(part["kind"] == "mouth" for part in bag.parts.values()):
        return "the bag has no mouth that would carry them"
    if len(rows) < 3:
        return f"{len(rows)} of them make no ring"
    model = context.model
    at = model.nodes.rows(np.array([r[1] for r in rows]), rows[0][0].shown, rows[0][0].place)
    points = model.nodes.points[at] * context.units.length
    vectors = np.array([context.vector(r[3]) for r in rows])
    centre = points.mean(axis=0)
    axis = np.linalg.svd(points - centre)[2][2]
    mean = vectors.sum(axis=0)
    axis = axis if mean @ axis >= 0.0 else -axis
    arms = points - centre
    radius = np.linalg.norm(arms, axis=1)
    if not radius.min() > 1e-3 or np.ptp(radius) > ROUND * radius.mean():
        return "they do not lie on a circle"
    if not (np.linalg.norm(vectors, axis=1) > 0.0).all():
        return "their directions are not known"
    angle = np.arccos(np.clip(vectors @ axis / np.linalg.norm(vectors, axis=1), -1.0, 1.0))
    if np.ptp(angle) > ROUND or angle.mean() > math.radians(89.0):
        return "they blow at different angles, or backwards"
    area, cone = float(np.mean([r[2] for r in rows])), float(np.mean([r[4] for r in rows]))
    return {
        "count": len(rows), "ring_radius": float(radius.mean()), "hole_diameter": math.sqrt(4.0 * area / math.pi),
        "angle": math.degrees(float(angle.mean())), "cone": cone,
    }  # fmt: skip
