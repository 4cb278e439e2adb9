"""The direction of the warp in each part of the flat cut, from AOPT, BETA and vectors of *MAT_FABRIC."""

from __future__ import annotations

import math

import numpy as np

from billow.decks.bag_mesh import BagMesh
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import Said
from billow.geometry.flat_cut import flat_cut, signed_areas

SPREAD = 2.0
"""Degrees by which directions in one part may differ without a word."""


def put_warp(context: Context, bag: BagMesh, fabrics: dict[int, dict[str, Field]]) -> None:
    """`warp_angle` and `seen_from` of each part of fabric: the mean over its cells, weighted by area. fabrics: fields
    by part; without AOPT the warp is the direction A1, A2, A3."""
    flat = bag.reference or bag.start
    for number, f in fabrics.items():
        mine = np.flatnonzero((flat.part == number) & (bag.shell >= 0))
        if not len(mine):
            continue
        direction = _directions(context, bag, f, mine)
        if direction is None:
            continue
        triangles = flat.cells[mine][:, :3]
        drawn = flat_cut(flat.points, triangles)
        edges, corners = drawn[:, 1:] - drawn[:, :1], flat.points[triangles]
        sides = corners[:, 1:] - corners[:, :1]
        # In-plane components of the direction along both sides, by the Gram matrix of the sides.
        gram = np.einsum("nix,njx->nij", sides, sides)
        right = np.einsum("nix,nx->ni", sides, direction)
        sound = np.linalg.det(gram) > 1e-12 * (gram[:, 0, 0] * gram[:, 1, 1])
        if not sound.any():
            continue
        along = np.einsum("ni,nix->nx", np.linalg.solve(gram[sound], right[sound][..., None])[..., 0], edges[sound])
        angle = np.arctan2(along[:, 1], along[:, 0])
        weight = np.abs(signed_areas(drawn))[sound]
        # The warp has no sense: means of axes are those of the doubled angle.
        mean = 0.5 * math.atan2(float(weight @ np.sin(2 * angle)), float(weight @ np.cos(2 * angle)))
        off = np.degrees(np.abs(np.angle(np.exp(2j * (angle - mean))))) / 2.0
        degrees = round(math.degrees(mean), 9) + 0.0
        if signed_areas(drawn).sum() < 0.0:
            bag.parts[number]["seen_from"] = "inside"
        source = f.get("AOPT", f["BETA"])
        bag.parts[number]["warp_angle"] = Said(degrees, f"{source.place} {source.shown}")
        report = context.report
        for name in ("AOPT", "BETA") if "AOPT" in f else ("BETA",):
            if off.max() > SPREAD:
                how = f"part {number}: directions differ by up to {off.max():.3g} deg from their mean, which is used"
                report.approximated(f[name], how, degrees)
            elif not report.settled(f[name]):
                report.mapped(f[name], degrees)


def _directions(context: Context, bag: BagMesh, f: dict[str, Field], mine: np.ndarray) -> np.ndarray | None:
    """Direction (n, 3) of the warp in the flat cut of cells; None if AOPT is one that is not read."""
    flat = bag.reference or bag.start
    cells = flat.cells[mine]
    # The first corner is that of the deck; cells that were turned list the others backwards.
    turned = bag.turned[mine]
    last = np.where(cells[:, 3] < 0, 2, 3)
    second = np.where(turned, cells[np.arange(len(cells)), last], cells[:, 1])
    third = np.where(turned, cells[np.arange(len(cells)), last - 1], cells[:, 2])
    p = flat.points
    normal = np.cross(p[second] - p[cells[:, 0]], p[third] - p[cells[:, 0]])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(size > 0.0, size, 1.0)
    aopt = f["AOPT"].whole if "AOPT" in f else 2
    if aopt in (0, 1):
        axis = p[second] - p[cells[:, 0]]
    elif aopt == 2:
        axis = np.broadcast_to([f[n].number for n in ("A1", "A2", "A3")], normal.shape)
        _named(context, f, ("A1", "A2", "A3"))
    elif aopt == 3:
        axis = np.cross([f[n].number for n in ("V1", "V2", "V3")], normal)
        _named(context, f, ("V1", "V2", "V3"))
    else:
        context.report.refused(f["AOPT"], "a coordinate system: set bag.parts.warp_angle yourself")
        return None
    axis = axis - np.sum(axis * normal, axis=1, keepdims=True) * normal
    own = f["BETA"].number if aopt != 2 else 0.0  # the manual: BETA of the material is for AOPT 0 and 3
    beta = np.radians(own + context.model.shells.beta[bag.shell[mine]])[:, None]
    return np.cos(beta) * axis + np.sin(beta) * np.cross(normal, axis)


def _named(context: Context, f: dict[str, Field], names: tuple[str, ...]) -> None:
    for name in names:
        context.report.mapped(f[name], f[name].number, "bag.parts.warp_angle")
