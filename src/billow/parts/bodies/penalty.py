"""Penalty contact of one fabric node over one step, solved instead of sampled: the average force is a discrete gradient
of the spring's energy, the depth at the end the root of a quadratic (docs/theory.md, Contact over a step).
"""

from __future__ import annotations

import math

from billow.base.compiled import scalar

A_REFERENCE = 1e-4
"""Fabric area [m^2] for which a slope [N/m] is meant (docs/theory.md, Contact slope)."""


@scalar
def normal_contact(depth, closing, stiffness, inverse_mass, damping, dt):
    """Average normal force over a step: (force [N], depth at its end [m]).

    depth: at the start [m], negative outside; closing: speed towards the body [m/s]; stiffness [N/m];
    inverse_mass of the node [1/kg], zero if fixed; damping: fraction of critical [-]; dt [s].
    """
    half = 0.5 * dt * dt * inverse_mass
    elastic = half * stiffness
    free = dt * closing
    if depth >= 0.0:
        travel = (free - elastic * depth) / (1.0 + 0.5 * elastic)
        force = stiffness * (depth + 0.5 * travel)
        inside = 1.0
        if depth + travel < 0.0:  # leaves within the step
            travel = 0.5 * (free - math.sqrt(free * free + 2.0 * elastic * depth * depth))
            force = -0.5 * stiffness * depth * depth / travel if travel < 0.0 else 0.0
            inside = -depth / travel if travel < 0.0 else 0.0
    else:
        if depth + free <= 0.0:
            return 0.0, depth + free
        b = elastic * depth - free
        a, c = 1.0 + 0.5 * elastic, 0.5 * elastic * depth * depth
        travel = (-b + math.sqrt(max(0.0, b * b - 4.0 * a * c))) / (2.0 * a)
        inside = max(0.0, depth + travel) / travel
        force = 0.5 * stiffness * inside * (depth + travel)
    if damping > 0.0 and inverse_mass > 0.0:
        viscosity = 2.0 * damping * math.sqrt(stiffness / inverse_mass) * inside
        force = max(0.0, force + viscosity * travel / dt / (1.0 + half * viscosity / dt))
    return force, depth + free - half * force


@scalar
def contact_force(depth, nx, ny, nz, vx, vy, vz, stiffness, inverse_mass, damping, friction, sx, sy, sz, dt):
    """Average contact force over a step on a node at signed `depth` [m] in a body with outward normal n.

    v: velocity of the node relative to the body at the start [m/s]; s: offset from the sticking point [m]; the rest as
    in `normal_contact`.

    Returns force (3) [N], new offset (3) [m], energy stored at the end [J], energy dissipated [J], depth at the end
    [m].
    """
    speed = vx * nx + vy * ny + vz * nz
    normal, after = normal_contact(depth, -speed, stiffness, inverse_mass, damping, dt)
    old = 0.5 * stiffness * (max(0.0, depth) ** 2 + sx * sx + sy * sy + sz * sz)
    if normal == 0.0:  # outside, or damping keeps a leaving node from being held back while its spring still relaxes
        left = 0.5 * stiffness * max(0.0, after) ** 2
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, left, old - left, after

    # Tangential: the stick spring by the implicit midpoint rule, cut back to the Coulomb limit.
    along = sx * nx + sy * ny + sz * nz  # the normal turns as the node travels
    sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    tx, ty, tz = vx - speed * nx, vy - speed * ny, vz - speed * nz
    kick = 0.5 * dt * inverse_mass
    viscosity = 2.0 * damping * math.sqrt(stiffness / inverse_mass) if inverse_mass > 0.0 else 0.0
    resist = 0.5 * stiffness * dt + viscosity
    share = 1.0 / (1.0 + kick * resist)
    fx = -share * (stiffness * sx + resist * tx)
    fy = -share * (stiffness * sy + resist * ty)
    fz = -share * (stiffness * sz + resist * tz)
    size, limit = math.sqrt(fx * fx + fy * fy + fz * fz), friction * normal
    slips = size > limit
    if slips:
        fx, fy, fz = fx * limit / size, fy * limit / size, fz * limit / size
    mx, my, mz = tx + kick * fx, ty + kick * fy, tz + kick * fz  # tangential velocity at the middle
    sx, sy, sz = sx + dt * mx, sy + dt * my, sz + dt * mz
    if slips:  # the sticking point is dragged along; it is never farther than the travel put it
        longest, stretch = limit / stiffness, math.sqrt(sx * sx + sy * sy + sz * sz)
        if stretch > longest:
            sx, sy, sz = sx * longest / stretch, sy * longest / stretch, sz * longest / stretch
    if after <= 0.0:  # it left
        sx, sy, sz = 0.0, 0.0, 0.0
    stored = 0.5 * stiffness * (max(0.0, after) ** 2 + sx * sx + sy * sy + sz * sz)
    # What the forces took from the motion and the springs do not hold.
    dissipated = normal * (after - depth) - (fx * mx + fy * my + fz * mz) * dt - (stored - old)
    fx, fy, fz = fx + normal * nx, fy + normal * ny, fz + normal * nz
    return fx, fy, fz, sx, sy, sz, stored, dissipated, after
