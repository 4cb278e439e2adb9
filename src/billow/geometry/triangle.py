"""One triangle in space."""

from __future__ import annotations

from billow.base.compiled import scalar


@scalar
def double_area_vector(positions, a, b, c):
    """Normal times twice the area [m^2] of the triangle of nodes a, b, c: the cross product of its sides."""
    ux, uy, uz = (
        positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
    )  # fmt: skip
    vx, vy, vz = (
        positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1], positions[c, 2] - positions[a, 2],
    )  # fmt: skip
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
