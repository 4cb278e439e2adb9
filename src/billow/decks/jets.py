"""Orifices of *AIRBAG_PARTICLE as the ring of jets of a case."""

from __future__ import annotations

import math

import numpy as np

from billow.decks.airbag_gas import Airbag
from billow.decks.bag_mesh import BagMesh
from billow.decks.context import Context
from billow.decks.draft import said

ROUND = 0.05
"""Share of the ring's radius by which orifices may lie beside it, and of angles in radians."""


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
