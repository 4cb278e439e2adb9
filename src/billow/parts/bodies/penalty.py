"""Penalty contact of one fabric node over one step, solved instead of sampled: the average force is a discrete gradient
of the spring's energy, the depth at the end the root of a quadratic (docs/theory.md, Contact over a step).

Both functions compute whatever may happen and then choose, so that loops over many nodes become vector instructions.
"""

from __future__ import annotations

import math

from billow.base.compiled import spliced

A_REFERENCE = 1e-4
"""Fabric area [m^2] for which a slope [N/m] is meant (docs/theory.md, Contact slope)."""


@spliced
def _viscosity(stiffness, inverse_mass, damping):
    """Of the damper beside a spring [N s/m]; none for a fixed node, which has no critical damping."""
    critical = 2.0 * math.sqrt(stiffness / (inverse_mass if inverse_mass > 0.0 else 1.0))
    return damping * critical if inverse_mass > 0.0 else 0.0


@spliced
def normal_contact(depth, closing, stiffness, inverse_mass, damping, dt):
    """Average normal force over a step: (force [N], depth at its end [m]).

    depth: at the start [m], negative outside; closing: speed towards the body [m/s]; stiffness [N/m];
    inverse_mass of the node [1/kg], zero if fixed; damping: fraction of critical [-]; dt [s].
    """
    half = 0.5 * dt * dt * inverse_mass
    elastic, free = half * stiffness, dt * closing
    ahead, whole, square = free - elastic * depth, 1.0 + 0.5 * elastic, 2.0 * elastic * depth * depth
    share = 1.0 / whole
    is_in = depth >= 0.0
    comes = (depth < 0.0) & (depth + free > 0.0)
    stays = share * ahead  # of a node inside, if it does not leave
    leaves = is_in & (depth + stays < 0.0)
    of_leaving, of_coming = free * free + square, ahead * ahead - whole * square
    under = of_leaving if leaves else of_coming
    under = under if under > 0.0 else 0.0
    root = math.sqrt(under)
    leaving, coming = 0.5 * (free - root), 0.5 * share * (ahead + root)
    travel = leaving if leaves else stays
    travel = coming if comes else travel
    # The part of the way that lies inside, and the mean depth over the whole way.
    after = depth + travel
    after = after if after > 0.0 else 0.0
    within = -depth if leaves else after
    farthest = depth if leaves else after
    part = within / (travel if travel != 0.0 else 1.0)
    partly = leaves | comes
    inside = part if partly else 1.0
    mean_partly, mean = 0.5 * part * farthest, depth + 0.5 * travel
    force = stiffness * (mean_partly if partly else mean)
    viscous = _viscosity(stiffness, inverse_mass, damping) * inside / dt
    force += viscous * travel / (1.0 + half * viscous)
    force = force if (is_in | comes) & (force > 0.0) else 0.0
    return force, depth + free - half * force


@spliced
def contact_force(depth, nx, ny, nz, vx, vy, vz, stiffness, inverse_mass, damping, friction, sx, sy, sz, dt):
    """Average contact force over a step on a node at signed `depth` [m] in a body with outward normal n.

    v: velocity of the node relative to the body at the start [m/s]; s: offset from the sticking point [m]; the rest as
    in `normal_contact`.

    Returns force (3) [N], new offset (3) [m], energy stored at the end [J], energy dissipated [J], depth at the end
    [m].
    """
    speed = vx * nx + vy * ny + vz * nz
    normal, after = normal_contact(depth, -speed, stiffness, inverse_mass, damping, dt)
    before, left = (depth if depth > 0.0 else 0.0), (after if after > 0.0 else 0.0)
    old = 0.5 * stiffness * (before * before + sx * sx + sy * sy + sz * sz)

    # Tangential: the stick spring by the implicit midpoint rule, cut back to the Coulomb limit.
    along = sx * nx + sy * ny + sz * nz  # the normal turns as the node travels
    sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    tx, ty, tz = vx - speed * nx, vy - speed * ny, vz - speed * nz
    kick, resist = 0.5 * dt * inverse_mass, 0.5 * stiffness * dt + _viscosity(stiffness, inverse_mass, damping)
    share = 1.0 / (1.0 + kick * resist)
    fx = -share * (stiffness * sx + resist * tx)
    fy = -share * (stiffness * sy + resist * ty)
    fz = -share * (stiffness * sz + resist * tz)
    size, limit = math.sqrt(fx * fx + fy * fy + fz * fz), friction * normal
    slips = size > limit
    cut = limit / (size if slips else 1.0)
    cut = cut if slips else 1.0
    fx, fy, fz = cut * fx, cut * fy, cut * fz
    mx, my, mz = tx + kick * fx, ty + kick * fy, tz + kick * fz  # tangential velocity at the middle
    sx, sy, sz = sx + dt * mx, sy + dt * my, sz + dt * mz
    # The sticking point is dragged along; it is never farther than the travel put it. A node that left has none, nor
    # has one outside, or one that damping keeps from being held back while its spring still relaxes.
    longest, stretch = limit / stiffness, math.sqrt(sx * sx + sy * sy + sz * sz)
    too_far = slips & (stretch > longest)
    keep = longest / (stretch if too_far else 1.0)
    keep = keep if too_far else 1.0
    pushes = normal > 0.0
    keep = keep if pushes & (after > 0.0) else 0.0
    sx, sy, sz = keep * sx, keep * sy, keep * sz
    fx, fy, fz = (fx if pushes else 0.0), (fy if pushes else 0.0), (fz if pushes else 0.0)
    stored = 0.5 * stiffness * (left * left + sx * sx + sy * sy + sz * sz)
    # What the forces took from the motion and the springs do not hold.
    dissipated = normal * (after - depth) - (fx * mx + fy * my + fz * mz) * dt - (stored - old)
    return fx + normal * nx, fy + normal * ny, fz + normal * nz, sx, sy, sz, stored, dissipated, after
