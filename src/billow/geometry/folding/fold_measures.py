"""What a folded start does to the fabric: strain along the yarns, shear, distance between layers."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from billow.geometry.bag_shapes import BagShape

ALONG = 1e-9
"""Slope of an edge against a yarn up to which it runs along it."""
NEAR = 2.5
"""Distance on the sheet, in edges, up to which two nodes are neighbours on it."""


def yarn_strains(shape: BagShape, warp_angles: dict[str, float]) -> np.ndarray:
    """Strain [-] of every edge that runs along a yarn, against its length as cut, (edges,). warp_angles: [rad], of each
    part where the mesh does not run along the yarns."""
    strains = []
    for part in _fabric(shape):
        mine = shape.surface.triangles_of(part)
        angle = warp_angles.get(part, 0.0)
        back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        cut = shape.reference[mine] @ back
        corners = shape.positions[shape.surface.triangles[mine]]
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge = cut[:, b] - cut[:, a]
            length = np.linalg.norm(edge, axis=1)
            along = (np.abs(edge) < ALONG * length[:, None]).any(axis=1)
            start = np.linalg.norm(corners[:, b] - corners[:, a], axis=1)
            strains.append((start / length - 1.0)[along])
    return np.concatenate(strains)


def shears(shape: BagShape) -> np.ndarray:
    """Angle [rad] by which warp and weft depart from a right angle, of each triangle of fabric, (triangles,)."""
    cloth = shape.surface.triangles_of_kind("fabric")
    cut = shape.reference[cloth]
    corners = shape.positions[shape.surface.triangles[cloth]]
    flat = np.stack([cut[:, 1] - cut[:, 0], cut[:, 2] - cut[:, 0]], axis=2)
    start = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    warp, weft = np.moveaxis(start @ np.linalg.inv(flat), 2, 0)
    sine = np.sum(warp * weft, axis=1) / (np.linalg.norm(warp, axis=1) * np.linalg.norm(weft, axis=1))
    return np.abs(np.arcsin(np.clip(sine, -1.0, 1.0)))


def least_distance(positions: np.ndarray, flat: np.ndarray, side: np.ndarray, size: float, within: float) -> float:
    """Least distance [m] of two nodes of different layers, at most `within` [m].

    positions, flat: where the nodes are folded and on the flat bag [m], (nodes, 3). side: of the bag that each is on,
    0 for both, (nodes,). size: of the elements [m]. Nodes that are neighbours on one panel, or through a seam, are of
    one layer.
    """
    pairs = cKDTree(positions).query_pairs(within, output_type="ndarray")
    one, other = pairs.T
    on_sheet = np.linalg.norm((flat[one] - flat[other])[:, :2], axis=1) < NEAR * size
    same = (side[one] == side[other]) | (side[one] == 0) | (side[other] == 0)
    apart = ~(on_sheet & same)
    distances = np.linalg.norm(positions[one[apart]] - positions[other[apart]], axis=1)
    return float(distances.min(initial=within))


def _fabric(shape: BagShape) -> list[str]:
    surface = shape.surface
    return [name for name, kind in zip(surface.part_names, surface.part_kinds, strict=True) if kind == "fabric"]
