"""Riemann problems: between two states of gas, and between gas and a wall.

E. F. Toro, M. Spruce, W. Speares, Restoration of the contact surface in the HLL-Riemann solver, Shock Waves 4 (1994) 25
(HLLC); E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, 3rd ed., Springer 2009, chapters 4 and 6.
"""

from __future__ import annotations

import math

from billow.base.compiled import scalar

SLOW = 0.05
"""Speed relative to a wall, in speeds of sound, below which shock and fan are alike to second order, 1e-4 of p."""
EMPTIEST = 0.05
"""Least speed of sound behind a fan, relative: a wall that flees faster leaves this pressure rather than a vacuum."""


@scalar
def hllc(rho_l, u_l, v_l, w_l, p_l, e_l, c_l, rho_r, u_r, v_r, w_r, p_r, e_r, c_r):
    """Fluxes per area of mass, momentum along the normal and both tangents, and energy, from left to right.

    rho, p: density and pressure; u: velocity along the normal, v, w: across it; e: internal energy over p; c: speed of
    sound.
    """
    slow, fast = min(u_l - c_l, u_r - c_r), max(u_l + c_l, u_r + c_r)
    q_l, q_r = rho_l * (slow - u_l), rho_r * (fast - u_r)
    middle = (p_r - p_l + u_l * q_l - u_r * q_r) / (q_l - q_r)
    if middle >= 0.0:
        rho, u, v, w, p, e, s, q = rho_l, u_l, v_l, w_l, p_l, e_l, slow, q_l
        outrun = slow >= 0.0
    else:
        rho, u, v, w, p, e, s, q = rho_r, u_r, v_r, w_r, p_r, e_r, fast, q_r
        outrun = fast <= 0.0
    energy = p * e + 0.5 * rho * (u * u + v * v + w * w)
    if outrun:
        return rho * u, rho * u * u + p, rho * u * v, rho * u * w, u * (energy + p)
    p_star, narrow = p + q * (middle - u), 1.0 / (s - middle)
    share = (s - u) * narrow
    mass = rho * share * middle
    energy_star = share * energy + (p_star * middle - p * u) * narrow
    return mass, mass * middle + p_star, mass * v, mass * w, middle * (energy_star + p_star)


@scalar
def wall_pressure(rho, p, c, g, du):
    """Pressure [Pa] at a wall that gas of this density, pressure, speed of sound and gamma meets with the relative
    speed du [m/s] along the wall's normal: the exact solution of half a Riemann problem, shock or fan."""
    if abs(du) < SLOW * c:
        return p + rho * du * (c + 0.25 * (g + 1.0) * du)
    if du > 0.0:
        a, b = 2.0 / ((g + 1.0) * rho), (g - 1.0) / (g + 1.0) * p
        return p + du * (du + math.sqrt(du * du + 4.0 * a * (p + b))) / (2.0 * a)
    return p * max(1.0 + 0.5 * (g - 1.0) * du / c, EMPTIEST) ** (2.0 * g / (g - 1.0))
