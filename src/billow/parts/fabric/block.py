"""Membrane triangles as kernels see them: in blocks, one quantity a row, so that arithmetic runs over rows and becomes
vector instructions (docs/theory.md, Membrane element).

Every law's kernel calls `open_chunk`, and for each block `fetch` and `strain_of`, fills the rows S11, S22, S12 and
ENERGY, and calls `load` and `add_up`; at last `close_chunk`.
The axes are warp and weft, which need not be at right angles. A row begins at its name and has BLOCK numbers: quantity
Q of triangle j is block[Q + j].
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar, spliced

VOLUMES = 7
"""First column of the volumes in the sums of a chunk: of the surroundings, then of each chamber."""

BLOCK, QUARTER = 32, 8
"""Triangles in a block, and a quarter of them; all rows together stay in the fastest cache."""

D11, D12, D21, D22, V, MU, RATE = range(7)
"""Rows of what is constant of the elements (CONSTANTS, n), with room to the end of the last block: inverse of the flat
edges [1/m], volume [m^3], damping modulus [Pa s], 1/dt^2 at rest [1/s^2]."""
CONSTANTS = 7
RATES = 3
"""Last rows of what a law remembers: the rates of Green strain that its damping last went by [1/s]."""
SIXTH = 1.0 / 6.0

# fmt: off
(
    UX, UY, UZ, WX, WY, WZ,  # edges from corner 0 to 1 and to 2 [m]
    DUX, DUY, DUZ, DWX, DWY, DWZ,  # their rates [m/s]
    CX, CY, CZ,  # corner 0 from a point of the surface [m]
    AX, AY, AZ, BX, BY, BZ,  # columns of the deformation gradient F, along warp and weft [-]
    AA, BB, AB,  # their products, the entries of F^T F [-]
    R11, R22, R12,  # rates of Green strain [1/s]
    Q11, Q22, Q12,  # products of the rates of F [1/s^2]
    S11, S22, S12, ENERGY,  # second Piola-Kirchhoff stress [Pa] and recoverable energy [J/m^3], from the law
    NX, NY, NZ,  # a third of the area vector [m^2]
    F1X, F1Y, F1Z, F2X, F2Y, F2Z,  # minus the forces on corners 1 and 2 [N]
    VOLUME,  # part in the volume [m^3]
    STORED, POWER, LATE, TURNED, SQUARED, FASTEST,  # of all blocks of a chunk so far: see `FabricLaw.add_forces`
) = (BLOCK * row for row in range(50))
ROWS = 50
# fmt: on


@spliced
def open_chunk(chunk, corners, loads, partial_out):
    """Set the sums of a chunk and its entries to zero; returns rows for a block."""
    partial_out[chunk] = 0.0
    for entry in range(corners[2][chunk], corners[2][chunk + 1]):
        for k in range(6):
            loads[entry, k] = 0.0
    return np.zeros(ROWS * BLOCK)


@spliced
def fetch(block, first, count, mesh, corners):
    """Fill the rows UX to CZ with `count` elements from `first` on; mesh: of `Membrane.for_kernels`."""
    node, positions, velocities = corners[0], mesh[3], mesh[4]
    ox, oy, oz = positions[0, 0], positions[0, 1], positions[0, 2]  # so that far-away bags lose no digits
    for j in range(count):
        i = np.uint64(first + j)
        a, b, c = np.uint64(node[i, 0]), np.uint64(node[i, 1]), np.uint64(node[i, 2])
        x, y, z = positions[a, 0], positions[a, 1], positions[a, 2]
        block[UX + j], block[UY + j], block[UZ + j] = positions[b, 0] - x, positions[b, 1] - y, positions[b, 2] - z
        block[WX + j], block[WY + j], block[WZ + j] = positions[c, 0] - x, positions[c, 1] - y, positions[c, 2] - z
        block[CX + j], block[CY + j], block[CZ + j] = x - ox, y - oy, z - oz
        x, y, z = velocities[a, 0], velocities[a, 1], velocities[a, 2]
        block[DUX + j], block[DUY + j] = velocities[b, 0] - x, velocities[b, 1] - y
        block[DWX + j], block[DWY + j] = velocities[c, 0] - x, velocities[c, 1] - y
        block[DUZ + j], block[DWZ + j] = velocities[b, 2] - z, velocities[c, 2] - z


@spliced
def strain_of(block, first, mesh):
    """Fill the rows AX to Q12, and NX to NZ."""
    flat, begin = mesh[0], np.uint64(first)
    for j in range(BLOCK):
        ux, uy, uz = block[UX + j], block[UY + j], block[UZ + j]
        wx, wy, wz = block[WX + j], block[WY + j], block[WZ + j]
        i = begin + np.uint64(j)
        d11, d12, d21, d22 = flat[D11, i], flat[D12, i], flat[D21, i], flat[D22, i]
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
        block[Q11 + j] = dax * dax + day * day + daz * daz
        block[Q22 + j] = dbx * dbx + dby * dby + dbz * dbz
        block[Q12 + j] = dax * dbx + day * dby + daz * dbz
        block[NX + j] = (uy * wz - uz * wy) * SIXTH
        block[NY + j] = (uz * wx - ux * wz) * SIXTH
        block[NZ + j] = (ux * wy - uy * wx) * SIXTH


@spliced
def load(block, first, mesh, history, cot, csc, stiffening):
    """Fill the rows F1X to VOLUME: corner forces -V P Dm^-T [N] with P = F (S + damping); bring STORED to FASTEST up
    to date, to which triangles beyond the last one add nothing, being without volume.

    cot, csc: cotangent and cosecant of the angle between the yarns in the flat cut. stiffening: how much faster than
    the squared stretch s the squared rate grows, as (1 + stiffening) s - stiffening: 0.5 for stress linear in Green
    strain, whose tangent is s + (s - 1)/2 in units of the modulus; 0 where the rate at rest includes it.
    """
    flat, begin, one, two = mesh[0], np.uint64(first), np.uint64(1), np.uint64(2)
    before = np.uint64(len(history) - RATES)  # rates of Green strain in the call before [1/s]
    for j in range(BLOCK):
        i = begin + np.uint64(j)
        v, mu = flat[V, i], flat[MU, i]
        r11, r22, r12 = block[R11 + j], block[R22 + j], block[R12 + j]
        s11, s22, s12 = block[S11 + j] + mu * r11, block[S22 + j] + mu * r22, block[S12 + j] + mu * r12
        ax, ay, az = block[AX + j], block[AY + j], block[AZ + j]
        bx, by, bz = block[BX + j], block[BY + j], block[BZ + j]
        p1x, p1y, p1z = ax * s11 + bx * s12, ay * s11 + by * s12, az * s11 + bz * s12
        p2x, p2y, p2z = ax * s12 + bx * s22, ay * s12 + by * s22, az * s12 + bz * s22
        d11, d12, d21, d22 = flat[D11, i], flat[D12, i], flat[D21, i], flat[D22, i]
        block[F1X + j], block[F2X + j] = v * (p1x * d11 + p2x * d12), v * (p1x * d21 + p2x * d22)
        block[F1Y + j], block[F2Y + j] = v * (p1y * d11 + p2y * d12), v * (p1y * d21 + p2y * d22)
        block[F1Z + j], block[F2Z + j] = v * (p1z * d11 + p2z * d12), v * (p1z * d21 + p2z * d22)
        block[STORED + j] += v * block[ENERGY + j]
        power = r11 * r11 + r22 * r22 + 2.0 * r12 * r12
        p11, p22, p12 = history[before, i], history[before + one, i], history[before + two, i]
        block[POWER + j] += v * mu * power
        block[LATE + j] += 0.5 * v * mu * (p11 * r11 + p22 * r22 + 2.0 * p12 * r12 - power)
        block[TURNED + j] += 0.5 * v * mu * (p11 * block[Q11 + j] + p22 * block[Q22 + j] + 2.0 * p12 * block[Q12 + j])
        aa, bb, ab = block[AA + j], block[BB + j], block[AB + j]
        ab, bb = csc * ab - cot * aa, csc * csc * bb - 2.0 * csc * cot * ab + cot * cot * aa
        squared = (aa if aa > bb else bb) + abs(ab)  # Gershgorin's bound of the largest squared stretch
        faster = (1.0 + stiffening) * squared - stiffening
        rate = flat[RATE, i] * (faster if faster > 1.0 else 1.0)
        block[SQUARED + j] = squared if squared > block[SQUARED + j] else block[SQUARED + j]
        block[FASTEST + j] = rate if rate > block[FASTEST + j] else block[FASTEST + j]
        block[VOLUME + j] = (
            block[CX + j] * block[NX + j] + block[CY + j] * block[NY + j] + block[CZ + j] * block[NZ + j]
        )


@spliced
def add_up(block, first, count, mesh, corners, history, loads, chunk, partial_out):
    """Add forces and area vectors to their entries, and to the volumes of a chunk; remember the rates."""
    entry, begin, one, two = corners[1], np.uint64(first), np.uint64(1), np.uint64(2)
    now = np.uint64(len(history) - RATES)
    for j in range(BLOCK):
        i = begin + np.uint64(j)
        history[now, i], history[now + one, i], history[now + two, i] = block[R11 + j], block[R22 + j], block[R12 + j]
    for j in range(count):
        i = begin + np.uint64(j)
        a, b, c = np.uint64(entry[i, 0]), np.uint64(entry[i, 1]), np.uint64(entry[i, 2])
        x1, y1, z1 = block[F1X + j], block[F1Y + j], block[F1Z + j]
        x2, y2, z2 = block[F2X + j], block[F2Y + j], block[F2Z + j]
        nx, ny, nz = block[NX + j], block[NY + j], block[NZ + j]
        loads[a, 0], loads[a, 1], loads[a, 2] = loads[a, 0] + x1 + x2, loads[a, 1] + y1 + y2, loads[a, 2] + z1 + z2
        loads[a, 3], loads[a, 4], loads[a, 5] = loads[a, 3] + nx, loads[a, 4] + ny, loads[a, 5] + nz
        loads[b, 0], loads[b, 1], loads[b, 2] = loads[b, 0] - x1, loads[b, 1] - y1, loads[b, 2] - z1
        loads[b, 3], loads[b, 4], loads[b, 5] = loads[b, 3] + nx, loads[b, 4] + ny, loads[b, 5] + nz
        loads[c, 0], loads[c, 1], loads[c, 2] = loads[c, 0] - x2, loads[c, 1] - y2, loads[c, 2] - z2
        loads[c, 3], loads[c, 4], loads[c, 5] = loads[c, 3] + nx, loads[c, 4] + ny, loads[c, 5] + nz
    behind, ahead, mixed = mesh[1], mesh[2], mesh[5]
    if mixed[first // BLOCK]:
        _add_volumes(block, first, count, behind, ahead, chunk, partial_out)
    else:
        volume = 0.0
        for j in range(QUARTER):
            volume += (block[VOLUME + j] + block[VOLUME + QUARTER + j]) + (
                block[VOLUME + 2 * QUARTER + j] + block[VOLUME + 3 * QUARTER + j]
            )
        partial_out[chunk, VOLUMES + 1 + behind[first]] += volume  # OUTSIDE, -1, is the first
        partial_out[chunk, VOLUMES + 1 + ahead[first]] -= volume


@scalar
def _add_volumes(block, first, count, behind, ahead, chunk, partial_out):
    """Add the parts of `count` triangles in the volumes, one by one."""
    for j in range(count):
        partial_out[chunk, VOLUMES + 1 + behind[first + j]] += block[VOLUME + j]
        partial_out[chunk, VOLUMES + 1 + ahead[first + j]] -= block[VOLUME + j]


@spliced
def close_chunk(block, chunk, partial_out):
    """Set the sums of a chunk but for HYSTERESIS."""
    energy, power, late, turned, largest, rate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(BLOCK):
        energy, power = energy + block[STORED + j], power + block[POWER + j]
        late, turned = late + block[LATE + j], turned + block[TURNED + j]
        largest, rate = max(largest, block[SQUARED + j]), max(rate, block[FASTEST + j])
    partial_out[chunk, 0], partial_out[chunk, 1] = energy, power
    partial_out[chunk, 2], partial_out[chunk, 4] = largest, rate
    partial_out[chunk, 5], partial_out[chunk, 6] = late, turned
