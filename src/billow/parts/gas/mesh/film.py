"""Friction of gas in films: layers of gas between walls closer than a cell.

The speed across a film is a parabola between the speeds of its walls. With the mean speed U of the gas, the walls'
mean speed V and their distance h, the wall that moves with v feels (H. Schlichting, Boundary-Layer Theory, chapter V)

    tau = mu (6 (U - V) + 2 (V - v))/h,

plane Poiseuille flow for walls at rest, 12 mu U/h on both of them, and Couette flow for gas that they drag along. Above
a Reynolds number of about 2,000 on twice the distance, Blasius' law of smooth channels is larger, and replaces the 6.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.geometry.lattice_clipping import NORMAL, WEIGHT
from billow.parts.gas.mesh.patches import AREA, SIDE, SPEED
from billow.parts.gas.mesh.thermodynamics import RHO, P, T, U

NARROW = 1.0
"""Distance of walls [cells] from which a layer is no film."""
BLASIUS = 0.079
"""Friction factor of a smooth channel times the fourth root of its Reynolds number: tau = rho U^2/2 BLASIUS Re^-1/4."""


class Drag(NamedTuple):
    """What films do to their walls: patches (m,), their numbers; traction (m, 3), in their planes [Pa]."""

    patches: np.ndarray
    traction: np.ndarray


def viscosity(temperature: np.ndarray) -> np.ndarray:
    """Of air [Pa s], by W. Sutherland, Phil. Mag. 36 (1893) 507; gas of inflators differs by up to a fifth."""
    return 1.716e-5 * (temperature / 273.15) ** 1.5 * (273.15 + 110.4) / (temperature + 110.4)


def find_drag(
    cluster: np.ndarray, rows: np.ndarray, is_wall: np.ndarray, state: np.ndarray, volume: np.ndarray, h: float,
    dt: float,
) -> Drag:  # fmt: skip
    """In a part of a step of dt [s], from the state at its start.

    cluster: of each patch; rows: as in Patches; is_wall: (patches,) bool; state: of the clusters, and their volume
    [cells]. h: edge of a cell [m].

    Walls face each other with the half of all area that their normals do not sum up to. A film that would stop within
    less than dt stops.
    """
    n, area = len(volume), np.where(is_wall, rows[:, AREA], 0.0)
    whole = np.bincount(cluster, area, n)
    net = np.sqrt(sum(np.bincount(cluster, area * rows[:, SIDE + d], n) ** 2 for d in range(3)))
    facing = 0.5 * (whole - net)
    film = (volume < NARROW * facing) & (volume > 0.0) & (state[:, P] > 0.0)
    some = np.flatnonzero(film[cluster] & (area > 0.0))
    own, area = cluster[some], area[some]
    normal, speed = rows[some, SIDE : SIDE + 3], rows[some, SPEED : SPEED + 3]
    mean = np.column_stack([np.bincount(own, area * speed[:, d], n) for d in range(3)])[own] / whole[own, None]
    density, distance = state[own, RHO], h * volume[own] / facing[own]
    slip, mu = state[own, U : U + 3] - mean, viscosity(state[own, T])
    reynolds = 2.0 * density * np.sqrt((slip**2).sum(axis=1)) * distance / mu
    factor = np.maximum(6.0, 0.25 * BLASIUS * reynolds**0.75)
    rate = np.bincount(own, area * factor * mu / distance, n)[own] / (density * volume[own] * h)
    factor *= np.minimum(1.0, 1.0 / (rate * dt))
    traction = (mu / distance)[:, None] * (factor[:, None] * slip + 2.0 * (mean - speed))
    traction -= np.einsum("ij,ij->i", traction, normal)[:, None] * normal
    return Drag(some, traction)


def brake(
    drag: Drag, cluster: np.ndarray, triangle: np.ndarray, rows: np.ndarray, time_face: float, gained: np.ndarray,
    owed: np.ndarray,
) -> None:  # fmt: skip
    """Take the momentum and the work that walls get from their gas, and book the work for their triangles.

    cluster, triangle, rows: of the patches; time_face: dt times the area of a face [s m^2]; gained: (clusters, species
    + 4); owed: of the triangles [J]."""
    own, wall = cluster[drag.patches], triangle[drag.patches]
    impulse = time_face * rows[drag.patches, AREA][:, None] * drag.traction
    work = np.einsum("ij,ij->i", impulse, rows[drag.patches, SPEED : SPEED + 3])
    for column, given in zip((-4, -3, -2, -1), (*impulse.T, work), strict=True):
        gained[:, column] -= np.bincount(own, given, len(gained))
    owed -= np.bincount(wall, work, len(owed))


def pull_along(
    drag: Drag, patches: int, of: np.ndarray, triangle: np.ndarray, rows: np.ndarray, face: float,
    force_out: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Add what films do to the forces on the corners of triangles [N], (n, 3, 3); returns what was added.

    patches: how many there are; of, triangle, rows: patch and triangle of the fragments after the step; face: area
    [m^2] of a cell's."""
    traction, added = np.zeros((patches, 3)), np.zeros_like(force_out)
    traction[drag.patches] = drag.traction
    some = np.flatnonzero(traction[of].any(axis=1))
    push = face * np.sqrt((rows[some, NORMAL : NORMAL + 3] ** 2).sum(axis=1))[:, None] * traction[of[some]]
    second, third = rows[some, WEIGHT], rows[some, WEIGHT + 1]
    for k, weight in enumerate((1.0 - second - third, second, third)):
        for d in range(3):
            added[:, k, d] = np.bincount(triangle[some], push[:, d] * weight, len(added))
    force_out += added
    return added
