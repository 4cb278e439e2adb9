"""Work to the last digit: the gas pays what the fabric receives.

Over a step the structure does the work of the mean of the forces at its start and end. What the gas booked at the
walls, part by part, differs a little. The difference is owed by the gas beside each triangle, which pays in the next
step; so the energy of the gas closes to rounding, and its work is the fabric's.
"""

from __future__ import annotations

from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.mesh.walls import GIVEN


@kernel
def add_load(n, triangles, index, positions, force, sign, outer, ambient, corner_force):
    """Add the force of the gas, less that of the ambient pressure [Pa], to the corners (all triangles, 3, 3)."""
    for t in prange(n):
        nx, ny, nz = double_area_vector(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
        pull = ambient * sign[t] / 6.0 if outer[t] else 0.0
        back = (pull * nx, pull * ny, pull * nz)
        for k in range(3):
            for d in range(3):
                corner_force[index[t], k, d] += force[t, k, d] - back[d]


@kernel
def debts(n, triangles, positions, face, owed, per_area_out):
    """What is owed for n triangles, per area [J per face of a cell]; face: its area [m^2]."""
    for t in prange(n):
        x, y, z = double_area_vector(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
        area = 0.5 * (x * x + y * y + z * z) ** 0.5 / face
        per_area_out[t] = owed[t] / area if area > 0.0 else 0.0


@scalar
def settle(triangle, booked, owed):
    """Book what the gas has given to each patch."""
    for q in range(len(triangle)):
        owed[triangle[q]] -= booked[q, GIVEN]
