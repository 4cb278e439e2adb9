"""One triangle in space."""

from __future__ import annotations

from billow.base.compiled import scalar


@scalar
def sides(positions, a, b, c):
    """The sides a-b and a-c [m] of the triangle of nodes a, b, c: six numbers."""
    ax, ay, az = positions[a, 0], positions[a, 1], positions[a, 2]
    return (
        positions[b, 0] - ax, positions[b, 1] - ay, positions[b, 2] - az,
        positions[c, 0] - ax, positions[c, 1] - ay, positions[c, 2] - az,
    )  # fmt: skip


@scalar
def cross(ux, uy, uz, vx, vy, vz):
    """Cross product of two vectors."""
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@scalar
def double_area_vector(positions, a, b, c):
    """Normal times twice the area [m^2] of the triangle of nodes a, b, c: the cross product of its sides."""
    ux, uy, uz, vx, vy, vz = sides(positions, a, b, c)
    return cross(ux, uy, uz, vx, vy, vz)
