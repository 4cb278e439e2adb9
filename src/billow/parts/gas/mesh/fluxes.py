"""Flow through the open faces between clusters."""

from __future__ import annotations

import math

from numba import prange

from billow.base.compiled import kernel
from billow.geometry.lattice_clipping import cell_of
from billow.parts.gas.mesh.riemann import hllc
from billow.parts.gas.mesh.slopes import GAMMA, HEAT, VALUES
from billow.parts.gas.mesh.thermodynamics import RHO, P, U

FARTHEST = 1.5
"""Distance [cells] from the centroid of a cluster beyond which its slopes are not followed."""
LEAST = 0.2
"""Density and pressure at a face, relative to the cluster's half a step later, below which the face forgets slopes."""


@kernel
def face_fluxes(n, key, beside, aperture, of, half, slope, place, second_order, flux_out):
    """Fluxes per area through the upper faces of n cells: (n, 3, VALUES), of mass, momentum x, y, z and energy; times
    the aperture. Nothing flows between cells of a cluster."""
    for i in prange(n):
        a = of[i]
        corner = cell_of(key[i])
        gamma_l, e_l = half[a, GAMMA], half[a, HEAT]
        for d in range(3):
            open_share, j = aperture[i, d], beside[i, 2 * d + 1]
            b = of[j] if j >= 0 else a
            if not open_share > 0.0 or a == b or not (half[a, P] > 0.0 and half[b, P] > 0.0):
                for v in range(VALUES):
                    flux_out[i, d, v] = 0.0
                continue
            t1, t2 = U + (d + 1) % 3, U + (d + 2) % 3
            face = corner[d] + 1.0
            rho_l, u_l, v_l, w_l, p_l = half[a, RHO], half[a, U + d], half[a, t1], half[a, t2], half[a, P]
            rho_r, u_r, v_r, w_r, p_r = half[b, RHO], half[b, U + d], half[b, t1], half[b, t2], half[b, P]
            if second_order:
                left = min(max(face - place[a, d], 0.0), FARTHEST)
                right = max(min(face - place[b, d], 0.0), -FARTHEST)
                to_l, to_r = left * slope[a, d, RHO], right * slope[b, d, RHO]
                up_l, up_r = left * slope[a, d, P], right * slope[b, d, P]
                if (
                    rho_l + to_l > LEAST * rho_l
                    and p_l + up_l > LEAST * p_l
                    and rho_r + to_r > LEAST * rho_r
                    and p_r + up_r > LEAST * p_r
                ):
                    rho_l, p_l, rho_r, p_r = rho_l + to_l, p_l + up_l, rho_r + to_r, p_r + up_r
                    u_l, u_r = u_l + left * slope[a, d, U + d], u_r + right * slope[b, d, U + d]
                    v_l, v_r = v_l + left * slope[a, d, t1], v_r + right * slope[b, d, t1]
                    w_l, w_r = w_l + left * slope[a, d, t2], w_r + right * slope[b, d, t2]
            c_l, c_r = math.sqrt(gamma_l * p_l / rho_l), math.sqrt(half[b, GAMMA] * p_r / rho_r)
            mass, along, first, second, energy = hllc(
                rho_l, u_l, v_l, w_l, p_l, e_l, c_l, rho_r, u_r, v_r, w_r, p_r, half[b, HEAT], c_r
            )
            flux_out[i, d, 0], flux_out[i, d, U + d] = open_share * mass, open_share * along
            flux_out[i, d, t1], flux_out[i, d, t2] = open_share * first, open_share * second
            flux_out[i, d, 4] = open_share * energy
