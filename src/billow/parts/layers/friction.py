"""Coulomb friction between layers, as impulses against the tangential speed of pairs that press on each other.

The impulse of a step is at most mu times the normal one: what the filter pushed in the last step, and what the cushion
pushes in this. Impulses of the sweeps add up within this cone, so that what sticks is stopped. Friction takes energy
only, and needs no memory of where a pair stuck.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import kernel
from billow.parts.layers.cushion import stiffness_of
from billow.parts.layers.velocity_filter import inverse_inertia

SWEEPS = 4


@kernel
def rub(
    n, awake, edges_from, nodes, weight, normal, distance, gap, near, impulse, friction, mass, inverse_mass,
    spring, dt, velocities, push_out,
):  # fmt: skip
    """Change velocities [m/s] (nodes, 3) by friction; returns the number of pairs that press. friction: coefficient.
    push_out: nodes that do not yield get what pushes on them [N s], (nodes, 3)."""
    pressed, cone, per = np.empty(n, np.int64), np.empty(n), np.empty(n)
    m = 0
    for i in range(n):
        k = awake[i]
        reach = near[1] if k >= edges_from else near[0]
        normal_impulse = impulse[k] if distance[k] < reach else 0.0
        pressed_by = min(gap[k], reach) - distance[k]
        if pressed_by > 0.0:
            normal_impulse += stiffness_of(k, edges_from, nodes, mass, inverse_mass, spring) * pressed_by * dt
        if normal_impulse <= 0.0:
            continue
        inverse = inverse_inertia(k, nodes, weight, inverse_mass)
        if inverse > 0.0:
            pressed[m], cone[m], per[m] = k, friction * normal_impulse, 1.0 / inverse
            m += 1
    total = np.zeros((m, 3))
    for _ in range(SWEEPS):
        for q in range(m):
            k = pressed[q]
            vx, vy, vz = 0.0, 0.0, 0.0
            for i in range(4):
                j, w = nodes[k, i], weight[k, i]
                vx, vy, vz = vx + w * velocities[j, 0], vy + w * velocities[j, 1], vz + w * velocities[j, 2]
            along = vx * normal[k, 0] + vy * normal[k, 1] + vz * normal[k, 2]
            x = total[q, 0] - per[q] * (vx - along * normal[k, 0])
            y = total[q, 1] - per[q] * (vy - along * normal[k, 1])
            z = total[q, 2] - per[q] * (vz - along * normal[k, 2])
            size = math.sqrt(x * x + y * y + z * z)
            if size > cone[q]:
                x, y, z = x * cone[q] / size, y * cone[q] / size, z * cone[q] / size
            dx, dy, dz = x - total[q, 0], y - total[q, 1], z - total[q, 2]
            total[q, 0], total[q, 1], total[q, 2] = x, y, z
            for i in range(4):
                j = nodes[k, i]
                change = weight[k, i] * inverse_mass[j]
                velocities[j, 0] += change * dx
                velocities[j, 1] += change * dy
                velocities[j, 2] += change * dz
                if inverse_mass[j] <= 0.0:
                    push_out[j, 0] += weight[k, i] * dx
                    push_out[j, 1] += weight[k, i] * dy
                    push_out[j, 2] += weight[k, i] * dz
    return m
