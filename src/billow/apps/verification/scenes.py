"""Simple shapes with known answers, and models of one shape and one fabric."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from billow.case.build import nodal_mass
from billow.geometry.bag_shapes import BagShape
from billow.geometry.disc_mesh import mesh_disc, rim_count
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import Surface, nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.mass_shares import share_mass
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_model import Bag, GasModel, GasTotals
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.part import Loads
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, State
from billow.solver.run import Recorder

WIDTH, DEPTH, HEIGHT = 0.3, 0.2, 1.0
VOLUME = WIDTH * DEPTH * HEIGHT  # 60 l
GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))


def bag_of_height(height: float) -> Bag:
    """The box of 60 l with its lid at a height [m]."""
    shape = box(WIDTH, DEPTH, height)
    return Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))


def box(width: float, depth: float, height: float) -> BagShape:
    """Closed box [m] of twelve triangles from the origin to (width, depth, height); part "lid" is its top."""
    x, y, z = (g.ravel() for g in np.meshgrid([0.0, width], [0.0, depth], [0.0, height], indexing="ij"))
    quads = [[0, 2, 6, 4], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5], [1, 5, 7, 3]]
    triangles = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])
    return _shape(triangles, np.column_stack([x, y, z]), fixed=True, part=np.repeat([0, 1], [10, 2]))


def disc(radius: float, size: float, jitter: float = 0.0) -> BagShape:
    """Open flat disc [m] in the plane z = 0, its rim fixed.

    jitter: inner nodes are moved at random by up to this fraction of `size` each way, for an irregular mesh.
    """
    flat, triangles, _ = mesh_disc(radius, size)
    rim = rim_count(radius, size)
    flat[rim:] += jitter * size * np.random.default_rng(1).uniform(-1.0, 1.0, (len(flat) - rim, 2))
    positions = np.column_stack([flat, np.zeros(len(flat))])
    return _shape(triangles, positions, fixed=np.arange(len(flat)) < rim, reference=flat[triangles])


def sphere(radius: float, subdivisions: int) -> BagShape:
    """Sphere of radius [m]: an icosahedron, each face split into 4^subdivisions, nodes on the sphere."""
    turn = np.array([[-1.0, 1.0, -1.0, 1.0], [GOLDEN, GOLDEN, -GOLDEN, -GOLDEN], [0.0, 0.0, 0.0, 0.0]]).T
    points = np.concatenate([np.roll(turn, shift, axis=1) for shift in range(3)])  # three golden rectangles
    triangles = ConvexHull(points).simplices
    inwards = np.linalg.det(points[triangles]) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    for _ in range(subdivisions):
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        edges, which = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = len(points) + which.reshape(3, -1)
        points = np.concatenate([points, points[edges].sum(axis=1)])
        points /= np.linalg.norm(points, axis=1)[:, None]
        a, b, c = triangles.T
        triangles = np.concatenate([np.column_stack(t) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return _shape(triangles, radius * points / np.linalg.norm(points, axis=1)[:, None], fixed=False)


def tube(radius: float, length: float, around: int, along: int) -> BagShape:
    """Open tube [m] about the z axis, its two rims fixed; quads are split with alternating diagonals."""
    i, j = (g.ravel() for g in np.meshgrid(np.arange(along + 1), np.arange(around), indexing="ij"))
    angle = 2.0 * np.pi * j / around
    positions = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), length * (i / along - 0.5)])
    i, j = (g.ravel() for g in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = b + around, a + around
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    fixed = np.abs(positions[:, 2]) > 0.5 * length - 1e-9 * length
    return _shape(np.concatenate([first, second]), positions, fixed=fixed)


def flattened(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Each triangle laid flat on its own, its first edge along the warp: [m], (triangles, 3, 2)."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    warp = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    x = np.sum((c - a) * warp, axis=1)
    y = np.linalg.norm(c - a - x[:, None] * warp, axis=1)
    flat = np.zeros((len(triangles), 3, 2))
    flat[:, 1, 0], flat[:, 2, 0], flat[:, 2, 1] = np.linalg.norm(b - a, axis=1), x, y
    return flat


def _shape(triangles, positions, fixed, reference=None, part=None):
    part = np.zeros(len(triangles)) if part is None else part
    surface = Surface.build(triangles, part, ("fabric", "lid")[: int(part.max()) + 1], len(positions))
    reference = flattened(positions, triangles) if reference is None else reference
    fixed = np.broadcast_to(np.asarray(fixed), len(positions)).copy()
    return BagShape(surface, np.ascontiguousarray(positions), reference, fixed)


@dataclass(frozen=True)
class PrescribedPressure(GasModel):
    """A constant gauge pressure [Pa]: a gas model for cases that look for an equilibrium."""

    gauge: float
    ambient: float = 101325.0

    def start(self, bag: Bag) -> np.ndarray:
        """Volumes at time zero and now [m^3]."""
        return np.full(2, bag.surface.volume(bag.positions))

    def advance(self, gas: np.ndarray, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        gas[1] = bag.surface.volume(bag.positions)
        loads.gauge[0] = self.gauge

    def totals(self, gas: np.ndarray) -> GasTotals:
        start, volume = gas.tolist()
        work, ambient_work = ((self.ambient + self.gauge) * (volume - start), self.ambient * (volume - start))
        still = {"temperature": 295.0, "mass_by_species": np.zeros(0), "energy": 0.0}
        return GasTotals(self.ambient + self.gauge, volume=volume, work=work, ambient_work=ambient_work, **still)

    def fields(self, gas: np.ndarray) -> dict[str, np.ndarray]:
        return {}


def isotropic(
    young: float, poisson: float, density: float, thickness: float, compression: bool = False, damping: float = 0.0
) -> LinearFabric:
    """Fabric with equal moduli [Pa] in all directions; without compression it follows the principal tension field."""
    shear = 0.5 * young / (1.0 + poisson)
    return LinearFabric(density, thickness, young, young, poisson, shear, compression, damping)


def fabric_model(
    shape: BagShape, fabric: LinearFabric, gas: GasModel | None = None, *, start: np.ndarray | None = None,
    bodies: tuple[Body, ...] = (), gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mass_damping: float = 0.0,
) -> Model:  # fmt: skip
    """Model of a shape made of one fabric all over; start: [m], (nodes, 3), where not the shape's own positions."""
    surface, down = shape.surface, np.array(gravity)
    cloth = np.arange(surface.triangle_count)
    membranes = (Membrane.build(fabric, cloth, shape.reference, chambers=surface.chambers),)
    membranes = share_mass(membranes, surface.triangles)
    start = shape.positions if start is None else np.ascontiguousarray(start)
    area = nodal_share(surface.triangles.astype(np.int64), flat_area(shape.reference), surface.node_count)
    filled, contact = GasPart(gas or NoGas(), surface, start), Bodies(bodies, area, down)
    parts = (filled, Fabric(surface, membranes), NO_STRAPS, contact)
    mass = nodal_mass(shape, membranes, NO_STRAPS)
    return Model(surface, start, mass, shape.fixed, down, *parts, mass_damping=mass_damping)


class Observer(Recorder):
    """Recorder that keeps `watch(state)` of every history row."""

    def __init__(self, watch: Callable[[State], Any]):
        self.watch, self.rows = watch, []

    def history(self, model: Model, state: State) -> None:
        self.rows.append(self.watch(state))
