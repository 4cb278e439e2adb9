"""A cover over a bag: two flaps of fabric held at their outer edges, which a tear seam joins in the middle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.rectangle_mesh import even_lines, mesh_rectangle
from billow.geometry.surface import Surface

SLIT = 1e-3
"""Between the two rows of the seam [m]: contact knows no side of layers that start in one place."""


def covered(
    shape: BagShape, name: str, place: np.ndarray, length: float, width: float, size: float, layers: float
) -> tuple[BagShape, np.ndarray]:
    """A bag with a flat cover, and the ties (n, 2) of its seam, along y.

    place: its middle [m], (3,). length: between the edges that are held, along x; width: along y; size: of elements,
    [m]. layers: of the bag's fabric. Gas is on neither side.
    """
    y = even_lines([-0.5 * width, 0.5 * width], size, ())
    outer = even_lines([0.5 * SLIT, 0.5 * length], size, ())
    flap = mesh_rectangle(outer, y, size)
    other = np.column_stack([-flap.points[:, 0], flap.points[:, 1]])
    count, before = len(flap.points), len(shape.positions)
    flat = np.concatenate([flap.points, other])
    cells = np.concatenate([flap.triangles, count + flap.triangles[:, ::-1]])  # mirrored, so turned
    new = np.full(len(cells), OUTSIDE, np.int32)
    old = shape.surface
    surface = Surface.build(
        np.concatenate([old.triangles, before + cells]),
        np.concatenate([old.part, np.full(len(cells), len(old.part_names))]),
        (*old.part_names, name), before + len(flat), (*old.part_kinds, "fabric"),
        Chambers(
            old.chambers.names, np.concatenate([old.chambers.behind, new]), np.concatenate([old.chambers.ahead, new])
        ),
    )  # fmt: skip
    held = np.zeros(len(flat), bool)
    held[[*flap.grid[-1], *(count + flap.grid[-1])]] = True
    whole = replace(
        shape,
        surface=surface,
        positions=np.concatenate([shape.positions, np.column_stack([flat, np.zeros(len(flat))]) + place]),
        reference=np.concatenate([shape.reference, flat[cells]]),
        fixed=np.concatenate([shape.fixed, held]),
        layers=np.concatenate([shape.layers, np.full(len(cells), layers)]),
        leak=np.concatenate([shape.leak, np.zeros(len(cells))]),
    )
    return whole, before + np.column_stack([count + flap.grid[0], flap.grid[0]])
