"""Flow through the open faces between clusters."""

from __future__ import annotations

import math

from numba import prange

from billow.base.compiled import kernel
from billow.geometry.lattice_clipping import cell_of
from billow.parts.gas.mesh.riemann import hllc
from billow.parts.gas.mesh.slopes import VALUES
from billow.parts.gas.mesh.thermodynamics import RHO, C, G, P, U

FARTHEST = 1.5
"""Distance [cells] from the centroid of a cluster beyond which its slopes are not followed."""
LEAST = 0.2
"""Density and pressure at a face, relative to the cluster's, below which the face forgets slopes."""


@kernel
def face_fluxes(n, key, beside, aperture, of, state, half, slope, place, second_order, flux_out):
    """Fluxes per area through the upper faces of n cells: (n, 3, VALUES), of mass, momentum x, y, z and energy; times
    the aperture. Nothing flows between cells of a cluster."""
    for i in prange(n):
        a = of[i]
        corner = cell_of(key[i])
        for d in range(3):
            for v in range(VALUES):
                flux_out[i, d, v] = 0.0
            open_share, j = aperture[i, d], beside[i, 2 * d + 1]
            if not open_share > 0.0:
                continue
            b = of[j]
            if a == b or not (state[a, P] > 0.0 and state[b, P] > 0.0):
                continue
            t1, t2 = U + (d + 1) % 3, U + (d + 2) % 3
            face = corner[d] + 1.0
            rho_l, u_l, v_l, w_l, p_l = half[a, RHO], half[a, U + d], half[a, t1], half[a, t2], half[a, P]
            rho_r, u_r, v_r, w_r, p_r = half[b, RHO], half[b, U + d], half[b, t1], half[b, t2], half[b, P]
            if second_order:
                left = min(max(face - place[a, d], 0.0), FARTHEST)
                right = max(min(face - place[b, d], 0.0), -FARTHEST)
                rho_l, p_l = rho_l + left * slope[a, d, RHO], p_l + left * slope[a, d, P]
                rho_r, p_r = rho_r + right * slope[b, d, RHO], p_r + right * slope[b, d, P]
                u_l, u_r = u_l + left * slope[a, d, U + d], u_r + right * slope[b, d, U + d]
                v_l, v_r = v_l + left * slope[a, d, t1], v_r + right * slope[b, d, t1]
                w_l, w_r = w_l + left * slope[a, d, t2], w_r + right * slope[b, d, t2]
                if not (
                    rho_l > LEAST * state[a, RHO]
                    and p_l > LEAST * state[a, P]
                    and rho_r > LEAST * state[b, RHO]
                    and p_r > LEAST * state[b, P]
                ):
                    rho_l, u_l, v_l, w_l, p_l = state[a, RHO], state[a, U + d], state[a, t1], state[a, t2], state[a, P]
                    rho_r, u_r, v_r, w_r, p_r = state[b, RHO], state[b, U + d], state[b, t1], state[b, t2], state[b, P]
            # Along an isentrope the speed of sound follows from gamma.
            c_l = state[a, C] * math.sqrt(p_l / state[a, P] * state[a, RHO] / rho_l)
            c_r = state[b, C] * math.sqrt(p_r / state[b, P] * state[b, RHO] / rho_r)
            mass, along, first, second, energy = hllc(
                rho_l, u_l, v_l, w_l, p_l, state[a, G], c_l, rho_r, u_r, v_r, w_r, p_r, state[b, G], c_r
            )
            flux_out[i, d, 0], flux_out[i, d, U + d] = open_share * mass, open_share * along
            flux_out[i, d, t1], flux_out[i, d, t2] = open_share * first, open_share * second
            flux_out[i, d, 4] = open_share * energy
