"""What frames show of the fabric: stretch, strain along the yarns, and stress, whatever its law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.geometry.triangle import cross, sides
from billow.parts.fabric.membrane import Membrane

BITS = 11
"""Significant bits that are kept: what nobody can see would make frames a fifth larger."""
COLLAPSED = 1e-6
"""Area over that of the flat cut below which a triangle has no true stress."""


def fabric_fields(
    membranes: Sequence[Membrane],
    histories: Sequence[np.ndarray],
    triangles: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
) -> dict[str, np.ndarray]:
    """Fields on all triangles, (triangles,) each, of membranes at positions [m] and velocities [m/s], (nodes, 3).

    stretch: largest principal stretch [-]. strain_warp, strain_weft: Green strain along the yarns [-]. stress: largest
    principal true stress [Pa] of the law, without damping, over the thickness of the flat cut. Triangles without fabric
    have stretch 1 and nothing else. All are rounded to `BITS`. histories: as of `FabricState`; they stay as they are.
    """
    count = len(triangles)
    fields = {"stretch": np.ones(count)}
    fields |= {name: np.zeros(count) for name in ("strain_warp", "strain_weft", "stress")}
    for membrane, history in zip(membranes, histories, strict=True):
        elastic = replace(membrane, viscosity=np.zeros_like(membrane.viscosity))
        forces, _ = elastic.by_itself(triangles, positions, velocities, history)
        _fill(
            len(forces), triangles, positions, membrane.elements, membrane.reference_inverse, membrane.yarn_inverse,
            membrane.volume, forces, *fields.values(),
        )  # fmt: skip
    return {name: rounded(values) for name, values in fields.items()}


def rounded(values: np.ndarray) -> np.ndarray:
    """Values with `BITS` significant bits, so that they can be packed well; off by at most 2^-BITS of themselves.
    Veltkamp's splitting: what is far larger takes the other bits away (Dekker, Numerische Mathematik 18, 224, 1971)."""
    larger = (2.0 ** (53 - BITS) + 1.0) * values
    return larger - (larger - values)


@kernel
def _fill(n, triangles, positions, elements, flat, yarns, volume, forces, stretch_out, warp_out, weft_out, stress_out):
    """forces: of each element by itself [N], (n, 3, 3). Its stress needs no other knowledge of the law: volume times
    stress tensor is minus the sum of its corner forces times their places. One eigenvalue of that is zero, along the
    normal; the others follow from their sum and the sum of their squares."""
    for i in prange(n):
        t = elements[i]
        ux, uy, uz, wx, wy, wz = sides(positions, triangles[t, 0], triangles[t, 1], triangles[t, 2])
        uu, ww, uw = ux * ux + uy * uy + uz * uz, wx * wx + wy * wy + wz * wz, ux * wx + uy * wy + uz * wz
        d11, d12, d21, d22 = flat[0, i], flat[1, i], flat[2, i], flat[3, i]
        aa = d11 * d11 * uu + d21 * d21 * ww + 2.0 * d11 * d21 * uw
        bb = d12 * d12 * uu + d22 * d22 * ww + 2.0 * d12 * d22 * uw
        ab = d11 * d12 * uu + d21 * d22 * ww + (d11 * d22 + d12 * d21) * uw
        stretch_out[t] = math.sqrt(0.5 * (aa + bb) + math.sqrt((0.5 * (aa - bb)) ** 2 + ab * ab))
        y11, y12, y21, y22 = yarns[0, i], yarns[1, i], yarns[2, i], yarns[3, i]
        warp_out[t] = 0.5 * (y11 * y11 * uu + y21 * y21 * ww + 2.0 * y11 * y21 * uw - 1.0)
        weft_out[t] = 0.5 * (y12 * y12 * uu + y22 * y22 * ww + 2.0 * y12 * y22 * uw - 1.0)
        nx, ny, nz = cross(ux, uy, uz, wx, wy, wz)
        area, cut = 0.5 * math.sqrt(nx * nx + ny * ny + nz * nz), 0.5 / abs(d11 * d22 - d12 * d21)
        if area <= COLLAPSED * cut:
            continue
        px, py, pz, qx, qy, qz = (
            forces[i, 1, 0], forces[i, 1, 1], forces[i, 1, 2], forces[i, 2, 0], forces[i, 2, 1], forces[i, 2, 2],
        )  # fmt: skip
        xx, yy, zz = px * ux + qx * wx, py * uy + qy * wy, pz * uz + qz * wz
        xy, yz = 0.5 * (px * uy + py * ux + qx * wy + qy * wx), 0.5 * (py * uz + pz * uy + qy * wz + qz * wy)
        zx = 0.5 * (pz * ux + px * uz + qz * wx + qx * wz)
        half, squares = -0.5 * (xx + yy + zz), xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + zx * zx)
        largest = half + math.sqrt(max(0.5 * squares - half * half, 0.0))
        stress_out[t] = max(largest, 0.0) / (area * volume[i] / cut)
