"""FORM 4: loading and unloading curves for warp, weft and shear; shear switches between them by the sign of its rate.

Warp and weft have history (`curve_table`). Shear follows its loading curve while the angle grows and its unloading
curve while it shrinks, whatever happened before. Stress then jumps whenever the rate changes its sign, and small
vibrations of the angle jump between the curves: this is what makes the old formulation oscillate (docs/theory.md, Curve
laws; LS-DYNA paper, figure 2). What shear turns to heat depends on the path and is summed up. The law is kept for
comparison with old models; `curves_shear_law` is the cure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.parts.fabric.curve_fabric import HEAT, SHEAR, SHEAR_BACK, WARP, CurveFabric
from billow.parts.fabric.curve_table import INTERVALS, VIRGIN, place, read
from billow.parts.fabric.membrane import Membrane
from billow.parts.fabric.triangle import add_corner_forces, along
from billow.parts.fabric.yarns import shear_measure, shortened, stretch_bound


@dataclass(frozen=True)
class CurvesFabric(CurveFabric):
    """Law "curves". History: energy turned to heat [J/m^3], two numbers for warp and weft each (`SpringTable`), then
    z [-], H [Pa] and recoverable energy [J/m^3] of shear at the last evaluation."""

    switches_shear: ClassVar[bool] = True
    history_width: ClassVar[int] = 8

    def add_forces(
        self,
        membrane: Membrane,
        triangles: np.ndarray,
        positions: np.ndarray,
        velocities: np.ndarray,
        history: np.ndarray,
        corner_force: np.ndarray,
        partial: np.ndarray,
    ) -> None:
        """As `billow.parts.fabric.fabric_law.FabricLaw` promises."""
        table = self.table
        _curves_forces(
            len(membrane.elements), table.rows, table.scale, table.share, self.constants, membrane.elements,
            membrane.yarn_inverse, membrane.volume, membrane.viscosity, triangles, positions, velocities, history,
            corner_force, partial,
        )  # fmt: skip


@kernel
def _curves_forces(
    n, rows, scale, share, constants, elements, yarn_inverse, volume, viscosity, triangles, positions, velocities,
    history, corner_force, partial_out,
):  # fmt: skip
    below_a, below_b, c0, cot, csc = constants[0], constants[1], constants[2], constants[3], constants[4]
    chunks = (n + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        energy, power, largest, heat = 0.0, 0.0, 0.0, 0.0
        for i in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            t = elements[i]
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            d11, d12, d21, d22 = yarn_inverse[0, i], yarn_inverse[1, i], yarn_inverse[2, i], yarn_inverse[3, i]
            f = along(positions, a, b, c, d11, d12, d21, d22)
            ax, ay, az, bx, by, bz = f
            gax, gay, gaz, gbx, gby, gbz = along(velocities, a, b, c, d11, d12, d21, d22)
            aa, bb, ab = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, ax * bx + ay * by + az * bz
            raa, rbb = ax * gax + ay * gay + az * gaz, bx * gbx + by * gby + bz * gbz
            rab = 0.5 * (ax * gbx + ay * gby + az * gbz + bx * gax + by * gay + bz * gaz)

            z, zaa, zbb, zab = shear_measure(c0, aa, bb, ab)
            shear, sense = SHEAR, np.copysign(1.0, z)
            if c0 != 0.0 and z < 0.0:
                shear = SHEAR_BACK
            ea, eb = 0.5 * (aa - 1.0), 0.5 * (bb - 1.0)
            size = (ea, eb)
            saa, sbb, stored = 0.0, 0.0, 0.0
            for spring in range(2):
                x = size[spring] if size[spring] > 0.0 else 0.0  # slack, or not a number: damping shows that
                per_x, full = history[i, 2 * spring + 1], history[i, 2 * spring + 2]
                at = x * (per_x if per_x > 0.0 else VIRGIN)
                if at <= INTERVALS:
                    row, part = place((2 * spring + 1) * INTERVALS, at)
                    value, area = read(rows[row, 0], rows[row, 1], rows[row, 2], part, per_x)
                    stress, held = full * value, full * area
                else:
                    row, part = place(2 * spring * INTERVALS, x * scale[spring])
                    stress, held = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[spring])
                    kept = share[spring]
                    if kept > 0.0:
                        most = INTERVALS / per_x if per_x > 0.0 else 0.0
                        row, part = place(2 * spring * INTERVALS, most * scale[spring])
                        _, before = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[spring])
                        history[i, HEAT] += held - before - kept * (x * stress - full)
                        history[i, 2 * spring + 1] = INTERVALS / x
                        history[i, 2 * spring + 2] = x * stress
                        held = kept * x * stress
                stored += held
                if spring == WARP:
                    saa = stress
                else:
                    sbb = stress

            angle = sense * z if sense * z > 0.0 else 0.0
            row, part = place(2 * shear * INTERVALS, angle * scale[shear])
            upper, _ = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[shear])
            row, part = place((2 * shear + 1) * INTERVALS, angle * scale[shear])
            lower, held = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[shear])
            h = sense * (upper if sense * (zaa * raa + zbb * rbb + 2.0 * zab * rab) >= 0.0 else lower)
            # Work as the time integration does it, with the mean of both forces, less what is recoverable.
            history[i, HEAT] += 0.5 * (h + history[i, 6]) * (z - history[i, 5]) - (held - history[i, 7])
            history[i, 5], history[i, 6], history[i, 7] = z, h, held
            stored += held

            pressed_a, stored_a = shortened(below_a, ea)
            pressed_b, stored_b = shortened(below_b, eb)
            saa, sbb, stored = saa + pressed_a, sbb + pressed_b, stored + stored_a + stored_b

            v, mu = volume[i], viscosity[i]
            energy += v * stored
            heat += v * history[i, HEAT]
            power += v * mu * (raa * raa + rbb * rbb + 2.0 * rab * rab)
            largest = max(largest, stretch_bound(aa, bb, ab, cot, csc))
            saa, sbb, sab = saa + h * zaa + mu * raa, sbb + h * zbb + mu * rbb, h * zab + mu * rab
            add_corner_forces(corner_force, t, v, f, saa, sbb, sab, d11, d12, d21, d22)
        partial_out[chunk, 0] = energy
        partial_out[chunk, 1] = power
        partial_out[chunk, 2] = largest
        partial_out[chunk, 3] = heat
