"""FORM 0: orthotropic linear fabric, with or without compression.

Second Piola-Kirchhoff stress S = C E of the Green strain E = (F^T F - I)/2. Fabric buckles under the slightest
compression; "no compression" therefore means the relaxed (quasi-convex) energy, whose stress is continuous and
conserves energy on any closed path:

- isotropic: principal tension field (taut, wrinkled, slack), e.g. Pipkin, IMA J. Appl. Math. 36 (1986);
- orthotropic: each yarn family drops out when its stress would be negative, the other keeps its uniaxial stiffness,
  shear stays.

Damping stress S_v = viscosity dE/dt is proportional to stiffness in the highest mode of each element.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.compiled import CHUNK, kernel, scalar
from billow.fabric.membrane import Membrane

KEEP, PRINCIPAL, YARN = 0, 1, 2  # what compression does


def add_linear_forces(
    membrane: Membrane,
    triangles: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
    corner_force: np.ndarray,
    partial: np.ndarray,
) -> None:
    """Add membrane forces [N] to corner_force (triangles, 3, 3).

    positions [m] and velocities [m/s]: (nodes, 3). partial: (chunks, 3), receives per chunk of elements the strain
    energy [J], the damping power [W] and a bound on the largest squared stretch [-] (for the stable step).
    """
    rule = KEEP if membrane.fabric.compression else PRINCIPAL if membrane.fabric.is_isotropic else YARN
    c11, c22, c12, c66 = membrane.fabric.stiffness
    _linear_forces(
        len(membrane.elements), rule, c11, c22, c12, c66, membrane.elements, membrane.reference_inverse,
        membrane.volume, membrane.viscosity, triangles, positions, velocities, corner_force, partial,
    )  # fmt: skip


@scalar
def linear_stress(rule, c11, c22, c12, c66, e11, e22, e12):
    """Stress (s11, s22, s12) [Pa] of Green strain (e11, e22, e12) [-]; e12 is half the engineering shear."""
    s11 = c11 * e11 + c12 * e22
    s22 = c12 * e11 + c22 * e22
    s12 = 2.0 * c66 * e12
    if rule == KEEP:
        return s11, s22, s12
    if rule == YARN:
        if s11 < 0.0:
            s11 = 0.0
            s22 = (c22 - c12 * c12 / c11) * e22
        if s22 < 0.0:
            s22 = 0.0
            s11 = max(0.0, (c11 - c12 * c12 / c22) * e11)
        return s11, s22, s12
    # Principal tension field; isotropic, so stress and strain share their axes.
    mean = 0.5 * (e11 + e22)
    radius = np.sqrt((0.5 * (e11 - e22)) ** 2 + e12 * e12)
    largest, smallest = mean + radius, mean - radius
    if c12 * largest + c22 * smallest >= 0.0:
        return s11, s22, s12  # taut
    if largest <= 0.0:
        return 0.0, 0.0, 0.0  # slack
    # Wrinkled: uniaxial tension along the first principal direction n, S = E e1 n (x) n.
    tension = (c11 - c12 * c12 / c22) * largest
    nn11 = 0.5 * (1.0 + 0.5 * (e11 - e22) / radius)
    nn12 = 0.5 * e12 / radius
    return tension * nn11, tension * (1.0 - nn11), tension * nn12


@kernel
def _linear_forces(
    n, rule, c11, c22, c12, c66, elements, reference_inverse, volume, viscosity, triangles, positions, velocities,
    corner_force, partial_out,
):  # fmt: skip
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        energy, power, largest = 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            t = elements[i]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            d11, d12, d21, d22 = (
                reference_inverse[0, i], reference_inverse[1, i], reference_inverse[2, i], reference_inverse[3, i],
            )  # fmt: skip
            # Columns of F and of its rate: f1 = dx/dX1 (warp), f2 = dx/dX2 (weft).
            ux, uy, uz = (
                positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
            )  # fmt: skip
            wx, wy, wz = (
                positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1], positions[c, 2] - positions[a, 2],
            )  # fmt: skip
            f1x, f1y, f1z = ux * d11 + wx * d21, uy * d11 + wy * d21, uz * d11 + wz * d21
            f2x, f2y, f2z = ux * d12 + wx * d22, uy * d12 + wy * d22, uz * d12 + wz * d22
            ux, uy, uz = (
                velocities[b, 0] - velocities[a, 0],
                velocities[b, 1] - velocities[a, 1],
                velocities[b, 2] - velocities[a, 2],
            )
            wx, wy, wz = (
                velocities[c, 0] - velocities[a, 0],
                velocities[c, 1] - velocities[a, 1],
                velocities[c, 2] - velocities[a, 2],
            )
            g1x, g1y, g1z = ux * d11 + wx * d21, uy * d11 + wy * d21, uz * d11 + wz * d21
            g2x, g2y, g2z = ux * d12 + wx * d22, uy * d12 + wy * d22, uz * d12 + wz * d22

            c1, c2 = f1x * f1x + f1y * f1y + f1z * f1z, f2x * f2x + f2y * f2y + f2z * f2z
            e11, e22 = 0.5 * (c1 - 1.0), 0.5 * (c2 - 1.0)
            e12 = 0.5 * (f1x * f2x + f1y * f2y + f1z * f2z)
            r11 = f1x * g1x + f1y * g1y + f1z * g1z
            r22 = f2x * g2x + f2y * g2y + f2z * g2z
            r12 = 0.5 * (f1x * g2x + f1y * g2y + f1z * g2z + f2x * g1x + f2y * g1y + f2z * g1z)

            s11, s22, s12 = linear_stress(rule, c11, c22, c12, c66, e11, e22, e12)
            v, mu = volume[i], viscosity[i]
            energy += 0.5 * v * (s11 * e11 + s22 * e22 + 2.0 * s12 * e12)
            power += v * mu * (r11 * r11 + r22 * r22 + 2.0 * r12 * r12)
            largest = max(largest, max(c1, c2) + abs(2.0 * e12))  # Gershgorin bound of F^T F
            s11, s22, s12 = s11 + mu * r11, s22 + mu * r22, s12 + mu * r12

            # First Piola columns P = F S, then corner forces -v P Dm^-T.
            p1x, p1y, p1z = f1x * s11 + f2x * s12, f1y * s11 + f2y * s12, f1z * s11 + f2z * s12
            p2x, p2y, p2z = f1x * s12 + f2x * s22, f1y * s12 + f2y * s22, f1z * s12 + f2z * s22
            bx, by, bz = v * (p1x * d11 + p2x * d12), v * (p1y * d11 + p2y * d12), v * (p1z * d11 + p2z * d12)
            cx, cy, cz = v * (p1x * d21 + p2x * d22), v * (p1y * d21 + p2y * d22), v * (p1z * d21 + p2z * d22)
            corner_force[t, 0, 0] += bx + cx
            corner_force[t, 0, 1] += by + cy
            corner_force[t, 0, 2] += bz + cz
            corner_force[t, 1, 0] -= bx
            corner_force[t, 1, 1] -= by
            corner_force[t, 1, 2] -= bz
            corner_force[t, 2, 0] -= cx
            corner_force[t, 2, 1] -= cy
            corner_force[t, 2, 2] -= cz
        partial_out[chunk, 0] = energy
        partial_out[chunk, 1] = power
        partial_out[chunk, 2] = largest
