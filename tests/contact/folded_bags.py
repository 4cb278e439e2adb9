"""Square bags of two sewn panels, folded like a leporello in one direction or two, as start meshes with their flat
pieces. A row of nodes lies on every fold line, at the same place in both panels."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.results.vtkhdf import FabricWriter

SIDE = 0.6
LINES = (0.12, 0.24, 0.36, 0.48)
RADIUS, HALF_GAP = 6e-4, 2e-4  # of a crease, and between the panels [m]


def flat_bag(size):
    """Points (n, 3) and triangles of the flat bag, with the part of each, 0 front and 1 rear; size: of the elements."""
    count = round(SIDE / size)
    rows = np.array([r for r in np.linspace(0.0, SIDE, count + 1) if all(abs(r - q) > 0.6 * size for q in LINES)])
    rows = np.sort(np.concatenate([rows, LINES]))
    x, y = np.meshgrid(rows, rows, indexing="ij")
    rim = (np.minimum(x, y) < 1e-12) | (np.maximum(x, y) > SIDE - 1e-12)
    front = np.arange(x.size).reshape(x.shape)
    rear = front.copy()
    rear[~rim] = x.size + np.arange((~rim).sum())
    points = np.vstack(
        [
            np.column_stack([x.ravel(), y.ravel(), np.where(rim, 0.0, HALF_GAP).ravel()]),
            np.column_stack([x[~rim], y[~rim], np.full((~rim).sum(), -HALF_GAP)]),
        ]
    )
    triangles, on_rim = [], np.zeros(len(points), bool)
    on_rim[front[rim]] = True
    for number, turned in ((front, False), (rear, True)):
        corners = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
        for a, b, c, d in zip(*corners, strict=True):
            # A diagonal between two nodes of the rim would be an edge of both panels.
            cells = [(a, b, d), (b, c, d)] if on_rim[a] and on_rim[c] else [(a, b, c), (a, c, d)]
            triangles += [cell[::-1] for cell in cells] if turned else cells
    half = len(triangles) // 2
    return points, np.array(triangles), np.repeat([0, 1], half)


def leporello(along, radius, lines):
    """A centre line that turns by half a circle at each fold line, always upwards: place (x, z) and normal (x, z) of
    points at `along` [m]."""
    place, normal = np.zeros((len(along), 2)), np.zeros((len(along), 2))
    arc, at, way = np.pi * radius, np.array([lines[0] - 0.5 * np.pi * radius, 0.0]), 1.0
    begun = at[0]
    before = along <= begun
    place[before, 0], normal[before, 1] = along[before], 1.0
    for k, _ in enumerate(lines):
        end = lines[k + 1] - 0.5 * arc if k + 1 < len(lines) else np.inf
        sign = 1.0 if k % 2 == 0 else -1.0
        turning, flat = (along > begun) & (along <= begun + arc), (along > begun + arc) & (along <= end)
        angle = (along[turning] - begun) / radius
        place[turning] = np.column_stack([at[0] + way * radius * np.sin(angle), at[1] + radius * (1 - np.cos(angle))])
        normal[turning] = np.column_stack([-way * np.sin(angle) * sign, np.cos(angle) * sign])
        at, way = at + np.array([0.0, 2.0 * radius]), -way
        place[flat] = np.column_stack([at[0] + way * (along[flat] - begun - arc), np.full(flat.sum(), at[1])])
        normal[flat, 1] = -sign
        at, begun = np.array([at[0] + way * (end - begun - arc), at[1]]), end
    return place, normal


def fold(points, axis, radius, middle=0.0):
    """Points of a stack about the height `middle` [m], folded across an axis."""
    place, normal = leporello(points[:, axis], radius, LINES)
    above, folded = points[:, 2] - middle, points.copy()
    folded[:, axis] = place[:, 0] + above * normal[:, 0]
    folded[:, 2] = place[:, 1] + above * normal[:, 1]
    return folded


def folded_bag(folder: Path, size: float, directions: int) -> dict:
    """The [bag] table of a bag folded in 0, 1 or 2 directions, whose files lie in `folder`."""
    flat, triangles, part = flat_bag(size)
    points = flat
    if directions > 0:
        points = fold(points, 0, RADIUS)
    if directions > 1:
        height = np.ptp(points[:, 2])
        points = fold(points, 1, 0.6 * height, 0.5 * (points[:, 2].max() + points[:, 2].min()))
    corners = points[triangles]
    seen = "outside"
    if np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) < 0.0:
        triangles, seen = triangles[:, ::-1], "inside"
    other = {"outside": "inside", "inside": "outside"}[seen]
    for name, places in (("start", points), ("flat", flat * [1.0, 1.0, 0.0])):
        path = folder / f"{name}.vtkhdf"
        with FabricWriter(path, places, triangles, part, ["front", "rear"]) as file:
            file.append(0.0, places)
    return {
        "shape": "mesh", "start": str(folder / "start.vtkhdf"), "reference": str(folder / "flat.vtkhdf"),
        "parts": [{"name": "front", "seen_from": seen}, {"name": "rear", "seen_from": other}],
    }  # fmt: skip
