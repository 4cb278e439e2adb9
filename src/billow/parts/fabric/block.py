"""Membrane triangles as kernels see them: in blocks, one quantity a row, so that arithmetic runs over rows and becomes
vector instructions (docs/theory.md, Membrane element).

Every law's kernel calls `fetch` and `strain_of`, fills the rows S11, S22, S12 and ENERGY, and calls `load` and `total`.
The axes are warp and weft, which need not be at right angles. A row begins at its name and has BLOCK numbers: quantity
Q of triangle j is block[Q + j].
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import inlined

VOLUMES = 5
"""First column of the volumes in the sums of a chunk: of the surroundings, then of each chamber."""

BLOCK = 64
"""Triangles in a block; all rows together stay in the fastest cache."""

# fmt: off
(
    UX, UY, UZ, WX, WY, WZ,  # edges from corner 0 to 1 and to 2 [m]
    DUX, DUY, DUZ, DWX, DWY, DWZ,  # their rates [m/s]
    CX, CY, CZ,  # corner 0 from a point of the surface [m]
    D11, D12, D21, D22,  # inverse of the flat edges [1/m]
    V, MU, RATE,  # volume [m^3], damping modulus [Pa s], 1/dt^2 at rest [1/s^2]
    AX, AY, AZ, BX, BY, BZ,  # columns of the deformation gradient F, along warp and weft [-]
    AA, BB, AB,  # their products, the entries of F^T F [-]
    R11, R22, R12,  # rates of Green strain [1/s]
    S11, S22, S12, ENERGY,  # second Piola-Kirchhoff stress [Pa] and recoverable energy [J], from the law
    NX, NY, NZ,  # a third of the area vector [m^2]
    F1X, F1Y, F1Z, F2X, F2Y, F2Z,  # minus the forces on corners 1 and 2 [N]
) = (BLOCK * row for row in range(47))
ROWS = 47
# fmt: on


@inlined
def fetch(block, first, count, mesh):
    """Fill the rows UX to RATE with `count` elements from `first` on; mesh: of `Membrane.for_kernels`."""
    elements, inverse, volume, viscosity, squared_rate, _, _, triangles, positions, velocities = mesh
    ox, oy, oz = positions[0, 0], positions[0, 1], positions[0, 2]  # so that far-away bags lose no digits
    for j in range(count):
        i = np.uint64(first + j)
        t = np.uint64(elements[i])
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x, y, z = positions[a, 0], positions[a, 1], positions[a, 2]
        block[UX + j], block[UY + j], block[UZ + j] = positions[b, 0] - x, positions[b, 1] - y, positions[b, 2] - z
        block[WX + j], block[WY + j], block[WZ + j] = positions[c, 0] - x, positions[c, 1] - y, positions[c, 2] - z
        block[CX + j], block[CY + j], block[CZ + j] = x - ox, y - oy, z - oz
        x, y, z = velocities[a, 0], velocities[a, 1], velocities[a, 2]
        block[DUX + j], block[DUY + j] = velocities[b, 0] - x, velocities[b, 1] - y
        block[DWX + j], block[DWY + j] = velocities[c, 0] - x, velocities[c, 1] - y
        block[DUZ + j], block[DWZ + j] = velocities[b, 2] - z, velocities[c, 2] - z
        block[D11 + j], block[D12 + j] = inverse[0, i], inverse[1, i]
        block[D21 + j], block[D22 + j] = inverse[2, i], inverse[3, i]
        block[V + j], block[MU + j], block[RATE + j] = volume[i], viscosity[i], squared_rate[i]


@inlined
def strain_of(block):
    """Fill the rows AX to R12, and NX to NZ."""
    for j in range(BLOCK):
        ux, uy, uz = block[UX + j], block[UY + j], block[UZ + j]
        wx, wy, wz = block[WX + j], block[WY + j], block[WZ + j]
        d11, d12, d21, d22 = block[D11 + j], block[D12 + j], block[D21 + j], block[D22 + j]
        ax, ay, az = ux * d11 + wx * d21, uy * d11 + wy * d21, uz * d11 + wz * d21
        bx, by, bz = ux * d12 + wx * d22, uy * d12 + wy * d22, uz * d12 + wz * d22
        px, py, pz = block[DUX + j], block[DUY + j], block[DUZ + j]
        qx, qy, qz = block[DWX + j], block[DWY + j], block[DWZ + j]
        dax, day, daz = px * d11 + qx * d21, py * d11 + qy * d21, pz * d11 + qz * d21
        dbx, dby, dbz = px * d12 + qx * d22, py * d12 + qy * d22, pz * d12 + qz * d22
        block[AX + j], block[AY + j], block[AZ + j] = ax, ay, az
        block[BX + j], block[BY + j], block[BZ + j] = bx, by, bz
        block[AA + j] = ax * ax + ay * ay + az * az
        block[BB + j] = bx * bx + by * by + bz * bz
        block[AB + j] = ax * bx + ay * by + az * bz
        block[R11 + j] = ax * dax + ay * day + az * daz
        block[R22 + j] = bx * dbx + by * dby + bz * dbz
        block[R12 + j] = 0.5 * (ax * dbx + ay * dby + az * dbz + bx * dax + by * day + bz * daz)
        block[NX + j] = (uy * wz - uz * wy) / 6.0
        block[NY + j] = (uz * wx - ux * wz) / 6.0
        block[NZ + j] = (ux * wy - uy * wx) / 6.0


@inlined
def load(block, first, count, mesh, corner_force, thirds):
    """Set the corner forces -V P Dm^-T [N] with P = F (S + damping), (triangles, 3, 3), and a third of each area vector
    [m^2], (triangles, 3)."""
    for j in range(BLOCK):
        v, mu = block[V + j], block[MU + j]
        s11, s22 = block[S11 + j] + mu * block[R11 + j], block[S22 + j] + mu * block[R22 + j]
        s12 = block[S12 + j] + mu * block[R12 + j]
        ax, ay, az = block[AX + j], block[AY + j], block[AZ + j]
        bx, by, bz = block[BX + j], block[BY + j], block[BZ + j]
        p1x, p1y, p1z = ax * s11 + bx * s12, ay * s11 + by * s12, az * s11 + bz * s12
        p2x, p2y, p2z = ax * s12 + bx * s22, ay * s12 + by * s22, az * s12 + bz * s22
        d11, d12, d21, d22 = block[D11 + j], block[D12 + j], block[D21 + j], block[D22 + j]
        block[F1X + j], block[F2X + j] = v * (p1x * d11 + p2x * d12), v * (p1x * d21 + p2x * d22)
        block[F1Y + j], block[F2Y + j] = v * (p1y * d11 + p2y * d12), v * (p1y * d21 + p2y * d22)
        block[F1Z + j], block[F2Z + j] = v * (p1z * d11 + p2z * d12), v * (p1z * d21 + p2z * d22)
    elements = mesh[0]
    for j in range(count):
        t = np.uint64(elements[np.uint64(first + j)])
        x1, y1, z1 = block[F1X + j], block[F1Y + j], block[F1Z + j]
        x2, y2, z2 = block[F2X + j], block[F2Y + j], block[F2Z + j]
        corner_force[t, 0, 0], corner_force[t, 0, 1], corner_force[t, 0, 2] = x1 + x2, y1 + y2, z1 + z2
        corner_force[t, 1, 0], corner_force[t, 1, 1], corner_force[t, 1, 2] = -x1, -y1, -z1
        corner_force[t, 2, 0], corner_force[t, 2, 1], corner_force[t, 2, 2] = -x2, -y2, -z2
        thirds[t, 0], thirds[t, 1], thirds[t, 2] = block[NX + j], block[NY + j], block[NZ + j]


@inlined
def total(block, first, count, mesh, cot, csc, stiffening, chunk, partial_out):
    """Add to the sums of a chunk, as `FabricLaw.add_forces` promises them, but for HYSTERESIS.

    cot, csc: cotangent and cosecant of the angle between the yarns in the flat cut. stiffening: how much faster than
    the squared stretch s the squared rate grows, as (1 + stiffening) s - stiffening: 0.5 for stress linear in Green
    strain, whose tangent is s + (s - 1)/2 in units of the modulus; 0 where the rate at rest includes it.
    """
    energy, power, largest, rate = 0.0, 0.0, 0.0, 0.0
    behind, ahead = mesh[5], mesh[6]
    for j in range(count):
        aa, bb, ab = block[AA + j], block[BB + j], block[AB + j]
        if cot != 0.0:
            ab, bb = csc * ab - cot * aa, csc * csc * bb - 2.0 * csc * cot * ab + cot * cot * aa
        squared = max(aa, bb) + abs(ab)  # Gershgorin's bound of the largest squared stretch
        largest = max(largest, squared)
        rate = max(rate, block[RATE + j] * max(1.0, (1.0 + stiffening) * squared - stiffening))
        energy += block[ENERGY + j]
        r11, r22, r12 = block[R11 + j], block[R22 + j], block[R12 + j]
        power += block[V + j] * block[MU + j] * (r11 * r11 + r22 * r22 + 2.0 * r12 * r12)
        volume = block[CX + j] * block[NX + j] + block[CY + j] * block[NY + j] + block[CZ + j] * block[NZ + j]
        i = np.uint64(first + j)
        partial_out[chunk, VOLUMES + 1 + behind[i]] += volume  # OUTSIDE, -1, is the first
        partial_out[chunk, VOLUMES + 1 + ahead[i]] -= volume
    partial_out[chunk, 0] += energy
    partial_out[chunk, 1] += power
    partial_out[chunk, 2] = max(partial_out[chunk, 2], largest)
    partial_out[chunk, 4] = max(partial_out[chunk, 4], rate)
