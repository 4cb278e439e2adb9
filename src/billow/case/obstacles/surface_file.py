"""From a file of triangles and quads to a rigid surface with its mass properties."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS
from billow.case.named_files import files_digest
from billow.geometry.mesh_file import CellMesh, read_mesh
from billow.geometry.mesh_repair import crowded, flipped, free_edges, to_flip
from billow.geometry.shapes.mesh import Mesh, mass_properties

MOST_TRIANGLES = 50_000

NO_SURFACE = InputError.declare(
    "E-GEO-150",
    "{file} is no surface that an obstacle can have",
    where="obstacles.{name}.file",
    cause="a file of another kind or unit, or a mesh as fine as a drawing",
    remedy="check the file and obstacles.{name}.unit; make coarser what has very many triangles",
)
CHANGED = InputError.declare(
    "E-GEO-151",
    "{file} is not the one the case was made with",
    where="obstacles.{name}.file",
    why="its SHA-256 is not that in obstacles.{name}.digest",
    cause="a file that was edited or replaced while a study or an interrupted run still needs it",
    remedy="bring the file back, or remove obstacles.{name}.digest to use it as it is now",
)
NO_MASS = InputError.declare(
    "E-GEO-152",
    "the inertia of {name} is that of no body",
    where="obstacles.{name}.inertia",
    why="its principal moments are {moments} kg m^2; each is positive and at most the sum of the others",
    cause="products of inertia with the wrong sign, or moments in another unit",
    remedy="correct it, or leave it out: then it is that of uniform density",
)
LARGEST = 10.0
"""Extent [m] of an obstacle."""


class Solid(NamedTuple):
    """mesh: in principal axes, about the middle of its box. middle: from the centre of mass, in these axes [m], (3,).
    mass [kg]; inertia: principal moments [kg m^2], (3,). centre: of mass [m], and axes: principal ones, (3, 3) columns,
    both in those of the file."""

    mesh: Mesh
    middle: np.ndarray
    mass: float
    inertia: np.ndarray
    centre: np.ndarray
    axes: np.ndarray


def read_surface(file: str, name: str, unit: str, digest: str) -> tuple[np.ndarray, np.ndarray, bool]:
    """Points [m], (nodes, 3), triangles (n, 3), outwards if they close a volume, and whether they do.

    Raises InputError E-GEO-030, E-GEO-031 as `read_mesh`, E-GEO-150, E-GEO-151.
    """
    if digest and digest != files_digest(file):
        raise CHANGED(file=file, name=name)
    mesh = read_mesh(file)
    points = mesh.points * CONVERSIONS["m"][unit]
    triangles = triangles_of(mesh)
    if not 1 <= len(triangles) <= MOST_TRIANGLES:
        raise NO_SURFACE(file=file, name=name, why=f"it has {len(triangles)} triangles, of at most {MOST_TRIANGLES}")
    used, triangles = np.unique(triangles, return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3)
    size = float(np.ptp(points, axis=0).max())
    if not 1e-3 < size < LARGEST:
        raise NO_SURFACE(file=file, name=name, why=f"it is {size:.3g} m wide; 1 mm to {LARGEST:g} m can be meant")
    cells = np.column_stack([triangles, np.full(len(triangles), -1)])
    if crowded(cells) is not None or len(free_edges(cells)):
        return points, triangles, False
    try:
        triangles = flipped(cells, to_flip(cells))[:, :3]
    except ValueError:  # one-sided, as a Klein bottle is
        return points, triangles, False
    volume, *_ = mass_properties(points, triangles, is_sheet=False)
    return points, triangles if volume > 0.0 else triangles[:, ::-1], True


def triangles_of(mesh: CellMesh) -> np.ndarray:
    """Triangles (n, 3) of cells, those without area left out; quads as two."""
    quads = mesh.cells[mesh.cells[:, 3] >= 0]
    found = np.concatenate([mesh.cells[mesh.cells[:, 3] < 0][:, :3], quads[:, :3], quads[:, [0, 2, 3]]])
    a, b, c = (mesh.points[found[:, k]] for k in range(3))
    return found[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0]


def solid_of(
    points: np.ndarray, triangles: np.ndarray, thickness: float, name: str, mass: float, density: float,
    centre: np.ndarray | None, inertia: tuple[float, ...] | None,
) -> Solid:  # fmt: skip
    """Mass properties of a surface; thickness: of a sheet [m], 0 for a solid. density [kg/m^3]: if it is not zero, the
    mass follows from it. centre [m], inertia (xx, yy, zz, xy, yz, zx) [kg m^2] about it: if not those of uniform
    density. Raises InputError E-GEO-152."""
    amount, own_centre, per_mass = mass_properties(points, triangles, bool(thickness))
    if density:
        mass = density * amount * (thickness or 1.0)
    middle = own_centre if centre is None else centre
    if inertia is None:
        # Parallel axes, if the centre is another than that of uniform density.
        away = own_centre - middle
        tensor = mass * (per_mass + (away @ away) * np.eye(3) - np.outer(away, away))
    else:
        xx, yy, zz, xy, yz, zx = inertia
        tensor = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    moments, axes = np.linalg.eigh(tensor)
    if not (moments[0] > 0.0 and moments[2] <= (moments[0] + moments[1]) * (1.0 + 1e-9)):
        raise NO_MASS(name=name, moments=", ".join(f"{m:.4g}" for m in moments))
    if np.linalg.det(axes) < 0.0:
        axes = axes * [1.0, 1.0, -1.0]
    own = (points - middle) @ axes
    half_way = 0.5 * (own.min(axis=0) + own.max(axis=0))
    mesh = Mesh(np.ascontiguousarray(own - half_way), np.ascontiguousarray(triangles), thickness)
    return Solid(mesh, half_way, mass, moments, middle, axes)
