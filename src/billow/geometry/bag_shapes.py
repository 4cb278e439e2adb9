"""The shape of a bag, ready-made or read from a file: flat reference, start positions, parts, straps, local
thickness."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from billow.base.errors import InputError
from billow.geometry.disc_mesh import mesh_disc, rim_count
from billow.geometry.rectangle_mesh import mesh_rectangle
from billow.geometry.surface import Surface

DOES_NOT_FIT = InputError.declare(
    "E-GEO-010",
    "{part} does not fit into its panel",
    where="bag.{key}",
    cause="a length in another unit, or a vent so close to a rim that no elements fit between",
    remedy="change bag.{key}, or reduce bag.element_size",
)


@dataclass(frozen=True)
class StrapLine:
    """One strap: (bars, 2) node pairs, bar width [m] each, unstretched length of each bar [m], (bars,).

    stiffness: tension per strain of the whole strap [N], None for that of the bag's fabric. failure: tension [N] of the
    whole strap at which it tears. moved: largest distance of its ends from where they were asked for [m].
    """

    bars: np.ndarray
    width: float
    length: np.ndarray
    stiffness: float | None = None
    failure: float = np.inf
    moved: float = 0.0


@dataclass(frozen=True)
class TearLine:
    """A tear seam: (ties, 2) node pairs, and the length of seam that each stands for [m], (ties,).

    rate, strength: points of its strength [N/m] against the rate of loading [N/m/s], (points,) each. stiffness: force
    per length of seam and distance [N/m^2], None for that of a row of elements of the bag's fabric.
    """

    name: str
    ties: np.ndarray
    length: np.ndarray
    rate: np.ndarray
    strength: np.ndarray
    stiffness: float | None = None


@dataclass(frozen=True)
class BagShape:
    """Geometry of a bag, without physics.

    surface: closed surface. positions: start shape, [m], (nodes, 3). reference: (triangles, 3, 2) [m], the flat cut
    coordinates of each triangle's corners in warp and weft direction; triangles that are not fabric may have none
    (zeros). fixed: (nodes,) bool, held by the inflator or ring. straps: strap lines; tear_lines: tear seams.
    mouth_centre (3,) [m], mouth_axis (3,) unit vector into the bag: where the inflator sits. layers: fabric thickness
    in units of the fabric's own, [-], (triangles,), 1 by default. leak: permeability in units of the fabric's own, [-],
    (triangles,), 1 by default. seen_from_inside: parts whose flat cut is drawn as seen from inside the bag, so that its
    triangles run clockwise.
    azimuths_from: direction (3,) from which angles about the mouth's axis count; None for a mesh, which lies in space
    as it likes: they count from the rim of the mouth.
    """

    surface: Surface
    positions: np.ndarray
    reference: np.ndarray
    fixed: np.ndarray
    straps: tuple[StrapLine, ...] = ()
    mouth_centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    mouth_axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    layers: np.ndarray | None = None
    leak: np.ndarray | None = None
    seen_from_inside: tuple[str, ...] = ()
    tear_lines: tuple[TearLine, ...] = ()
    azimuths_from: np.ndarray | None = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))

    def __post_init__(self):
        for name in ("layers", "leak"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.ones(self.surface.triangle_count))


def joined(shape: BagShape, one: str, other: str, line: np.ndarray, near: float) -> np.ndarray:
    """Pairs of nodes (n, 2) of two flat parts along a line [m] (2, 2), in its order: of each node of the first part
    within `near` [m] of the line, and the nearest of the second; none twice, and none that both parts share."""
    first, second = (np.unique(shape.surface.triangles[shape.surface.triangles_of(part)]) for part in (one, other))
    first, second = np.setdiff1d(first, second).astype(np.int64), np.setdiff1d(second, first).astype(np.int64)
    way = line[1] - line[0]
    away = shape.positions[first, :2] - line[0]
    along = away @ way / (way @ way)
    aside = np.linalg.norm(away - np.clip(along, 0.0, 1.0)[:, None] * way, axis=1)
    near_it = np.flatnonzero(aside <= near * (1.0 + 1e-9))
    near_it = near_it[np.argsort(along[near_it], kind="stable")]
    pairs, used = [], set()
    for node in first[near_it].tolist():
        apart = np.linalg.norm(shape.positions[second, :2] - shape.positions[node, :2], axis=1)
        partner = int(second[apart.argmin()])
        if partner not in used and apart.min() <= near * (1.0 + 1e-9):
            used.add(partner)
            pairs.append((node, partner))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def along_warp(shape: BagShape, angles: dict[str, float]) -> BagShape:
    """The shape whose fabric is cut with its warp at an angle [rad] from the flat cut's x axis towards its y axis, for
    each part named."""
    reference = shape.reference.copy()
    for part, angle in angles.items():
        c, s = np.cos(angle), np.sin(angle)
        cut = shape.surface.triangles_of(part)
        reference[cut] = reference[cut] @ np.array([[c, -s], [s, c]])
    return replace(shape, reference=reference)


def square_bag(side: float, divisions: int, initial_gap: float) -> BagShape:
    """Two square panels sewn along their edges ("teabag"): side [m], even number of divisions per side, gap at the
    middle [m].

    Quads are split with alternating diagonals, so that no direction is preferred. ValueError for odd divisions: two
    corners would be cut off by a diagonal that both panels share.
    """
    if divisions % 2:
        raise ValueError(f"divisions must be even, not {divisions}")
    s = np.linspace(-0.5 * side, 0.5 * side, divisions + 1)
    panel = mesh_rectangle(s, s, side / divisions)
    x, y = panel.points.T
    on_edge = (np.abs(x) > 0.5 * side - 1e-9) | (np.abs(y) > 0.5 * side - 1e-9)
    bump = 0.5 * initial_gap * (1.0 - (2.0 * x / side) ** 2) * (1.0 - (2.0 * y / side) ** 2)
    return _two_panels(panel.points, panel.triangles, on_edge, bump)


def round_bag(radius: float, rings: int, initial_gap: float) -> BagShape:
    """Two discs sewn at the rim ("Mylar balloon"): radius [m], number of element rings, gap at the middle [m]."""
    points, triangles, _ = mesh_disc(radius, radius / rings)
    on_rim = np.arange(len(points)) < rim_count(radius, radius / rings)
    dome = np.where(on_rim, 0.0, 0.5 * initial_gap * (1.0 - np.sum(points**2, axis=1) / radius**2))
    return _two_panels(points, triangles, on_rim, dome)


def _two_panels(points: np.ndarray, triangles: np.ndarray, sewn: np.ndarray, height: np.ndarray) -> BagShape:
    """A flat panel and its mirror image. sewn: (nodes,) bool, nodes of both; height: of the front [m], (nodes,)."""
    rear_node = np.arange(len(points))
    rear_node[~sewn] = len(points) + np.arange(np.count_nonzero(~sewn))
    flat = np.concatenate([points, points[~sewn]])
    positions = np.column_stack([flat, np.concatenate([height, -height[~sewn]])])
    both = np.concatenate([triangles, rear_node[triangles][:, [0, 2, 1]]])
    surface = Surface.build(both, np.repeat([0, 1], len(triangles)), ("front", "rear"), len(flat))
    return BagShape(surface, positions, flat[both], np.zeros(len(flat), dtype=bool))
