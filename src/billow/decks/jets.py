"""Orifices of *AIRBAG_PARTICLE and _ALE, and the jet of JETTING, as the ring of jets of a case."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from billow.case.gas.build_gas import start_of_rim
from billow.decks.airbag_gas import Airbag
from billow.decks.bag_mesh import BagMesh
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import said

ROUND = 0.05
"""Share of the ring's radius by which orifices may lie beside it, and of angles in radians."""
THINNEST = 1e-3
"""Least radius [m] of a ring of a case: a single hole stands there."""
ASIDE = math.radians(10.0)
"""Angle between a jet and the axis of the mouth up to which it counts as along the axis."""


def put_jets(context: Context, airbag: Airbag, bag: BagMesh) -> None:
    """The `jets` of each inflator that has orifices; a diffuse source where they make no ring in a mouth."""
    report = context.report
    for number, rows in airbag.orifices.items():
        inflator = context.tables["inflator"][number]
        ring = _ring(context, rows, bag)
        note = ring.pop("note", "") if isinstance(ring, dict) else ""
        for field, *_ in rows:
            if isinstance(ring, str):
                report.approximated(field, f"a diffuse source stands for the orifices: {ring}", key="inflator.jets")
            elif note:
                report.approximated(field, note, f"ring of {ring['count']}", "inflator.jets")
            else:
                report.mapped(field, f"ring of {ring['count']}", "inflator.jets")
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


@dataclass(frozen=True)
class _Mouth:
    """centre [m] (3,), axis into the bag, radius [m] of a disc of its area, and the direction across the axis from
    which azimuths of a case count."""

    centre: np.ndarray
    axis: np.ndarray
    radius: float
    zero: np.ndarray

    @classmethod
    def of(cls, bag: BagMesh) -> _Mouth | str:
        """The one mouth of a bag, or why there is none."""
        mouths = [number for number, part in bag.parts.items() if part["kind"] == "mouth"]
        if len(mouths) != 1:
            return f"the bag has {len(mouths) or 'no'} mouth{'s' if mouths else ''}"
        cells, points = bag.start.cells[bag.start.part == mouths[0]], bag.start.points
        quads = cells[cells[:, 3] >= 0]
        triangles = np.concatenate([cells[:, :3], quads[:, [0, 2, 3]]])
        a, b, c = (points[triangles[:, k]] for k in range(3))
        area = 0.5 * np.cross(b - a, c - a).sum(axis=0)
        size = float(np.linalg.norm(area))
        axis = -area / size
        zero = start_of_rim(triangles, points, axis)
        zero = zero - (zero @ axis) * axis
        centre = points[np.unique(triangles)].mean(axis=0)
        return cls(centre, axis, math.sqrt(size / math.pi), zero / np.linalg.norm(zero))

    def across(self, arms: np.ndarray) -> np.ndarray:
        """The part of vectors (n, 3) across the axis."""
        return arms - (arms @ self.axis)[:, None] * self.axis

    def azimuths(self, across: np.ndarray) -> np.ndarray:
        """Angles [rad] of vectors (n, 3) across the axis."""
        return np.arctan2(across @ np.cross(self.axis, self.zero), across @ self.zero)


def _off_axis(focus: np.ndarray, along: np.ndarray, bag: BagMesh) -> str:
    """Why a jet from a point [m] in a direction is not one of the bag's mouth; empty if it is."""
    mouth = _Mouth.of(bag)
    if isinstance(mouth, str):
        return mouth
    if not np.linalg.norm(along) > 0.0:
        return "its direction is not known"
    off = math.acos(np.clip(along @ mouth.axis / np.linalg.norm(along), -1.0, 1.0))
    if off > ASIDE:
        return f"this one leans by {math.degrees(off):.3g} deg"
    away = float(np.linalg.norm(mouth.across((focus - mouth.centre)[None])))
    return f"this one lies {1e3 * away:.3g} mm beside it" if away > mouth.radius else ""


def _ring(context: Context, rows, bag: BagMesh) -> dict | str:
    """Keys of the jets, or why there are none."""
    mouth, count = _Mouth.of(bag), len(rows)
    if isinstance(mouth, str):
        return mouth
    model = context.model
    at = model.nodes.rows(np.array([r[1] for r in rows]), rows[0][0].shown, rows[0][0].place)
    points = model.nodes.points[at] * context.units.length
    vectors = np.array([context.vector(r[3]) for r in rows])
    length = np.linalg.norm(vectors, axis=1)
    if not (length > 0.0).all():
        return "their directions are not known"
    vectors /= length[:, None]
    angle = np.arccos(np.clip(vectors @ mouth.axis, -1.0, 1.0))
    if np.ptp(angle) > ROUND or angle.mean() > math.radians(89.0):
        return "they blow at different angles from the axis of the mouth, or backwards"
    middle = mouth.centre if count == 1 else points.mean(axis=0)
    arms, tilt = mouth.across(points - middle), mouth.across(vectors)
    radius = np.linalg.norm(arms, axis=1)
    if count > 1 and (not radius.min() > THINNEST or np.ptp(radius) > ROUND * radius.mean()):
        return "they do not lie on a circle"
    leans = angle.mean() > ROUND
    out = tilt if leans else arms
    if leans and radius.min() > ROUND * mouth.radius:
        agree = (arms * tilt).sum(axis=1) / (radius * np.linalg.norm(tilt, axis=1))
        if agree.min() < math.cos(ASIDE):
            return "they do not blow away from the axis of the mouth"
    way = np.exp(1j * count * mouth.azimuths(out)).mean()
    if count > 1 and abs(way) < 0.9:
        return "they are not spaced evenly"
    area, cone = float(np.mean([r[2] for r in rows])), float(np.mean([r[4] for r in rows]))
    aside = float(np.linalg.norm(mouth.across((middle - mouth.centre)[None])))
    found = {
        "count": count, "ring_radius": max(float(radius.mean()), THINNEST),
        "hole_diameter": math.sqrt(4.0 * area / math.pi), "angle": math.degrees(float(angle.mean())), "cone": cone,
        "azimuth": math.degrees(float(np.angle(way))) / count,
    }  # fmt: skip
    if aside > ROUND * mouth.radius:
        found["note"] = f"moved by {1e3 * aside:.3g} mm to the middle of the mouth"
    return found
