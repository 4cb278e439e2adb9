"""Fabric described by loading and unloading curves for warp, weft and shear: law "curves-shear" (FORM 14), and law
"curves" (FORM 4), kept for comparison with old models. Both: docs/theory.md, Curve laws.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, scalar
from billow.base.errors import Concern
from billow.geometry.assembly import Corners
from billow.parts.fabric.block import (
    AA,
    AB,
    BB,
    BLOCK,
    ENERGY,
    R11,
    R12,
    R22,
    RATES,
    S11,
    S12,
    S22,
    V,
    add_up,
    close_chunk,
    fetch,
    load,
    open_chunk,
    strain_of,
)  # fmt: skip
from billow.parts.fabric.curve import Curve, TestedCurve, green_strain, shear_of_angle, shear_stress, yarn_stress
from billow.parts.fabric.curve_table import INTERVALS, VIRGIN, Spring, SpringTable, place, read
from billow.parts.fabric.membrane import HYSTERESIS, Membrane, odd_speed
from billow.parts.part import Setting

WARP, WEFT, SHEAR, SHEAR_BACK = range(4)
"""Springs of a fabric. Where the yarns are not at right angles, shear differs between its two senses and has a spring
for either; otherwise there is no SHEAR_BACK."""

CRITICAL = 1.2
"""Time a wave takes across an element, over the largest stable step that is taken for that of curves."""

HEAT, LAST_Z, LAST_STRESS, LAST_STORED, OWED = 0, 5, 6, 7, 8
"""Rows of the history. HEAT: energy turned to heat so far [J/m^3]. Two rows per spring follow (`SpringTable`),
from 2 spring + 1 on. Shear that switches has the other four instead: z [-], H [Pa] and recoverable energy [J/m^3] at
the last evaluation, and the energy [J/m^3] it gave back that had been booked as heat."""

NAMES = ("warp", "weft", "shear", "shear")
"""What a case calls the curve of each spring."""

COSTLY = 0.5
"""Part of the stable step that a single steep curve may leave of what it would be without."""

PEAK_PRESSURE = 60e3
"""Gauge pressure [Pa] that curves should reach: that of a hot driver bag at its peak."""

STRAP_STRAIN = 0.05
"""Elongation at which the secant of the warp curve gives the modulus of straps."""

STEEP_CURVE = Concern.declare(
    "W-FAB-004",
    "the curve of {name} makes the step {now:.3g} us instead of {without:.3g} us",
    where="fabric.curves.{name}",
    why="its steepest piece, or unloading from it, sets the step of all: a kink, noise, or a wrong unit",
    remedy="smooth the steepest piece, or end the curve before it",
)
SHORT_CURVE = Concern.declare(
    "W-FAB-005",
    "the curve of {name} ends at {force:.3g} N/m, a strain of {strain:.3g}",
    where="fabric.curves.{name}.loading",
    why=f"{1e-3 * PEAK_PRESSURE:g} kPa in this bag pull with {{needed:.3g}} N/m; beyond its end the curve keeps its "
    "last slope",
    cause="a test that was stopped early, or a stress in another unit",
    remedy="measure further, or check the unit of the stress",
)


@dataclass(frozen=True)
class CurveFabric:
    """density [kg/m^3], thickness [m]; warp, weft and shear as tested. transverse: transverse over axial true strain of
    the tests of warp and weft [-]: 1 equal-biaxial, 0 strip. yarn_angle: between warp and weft in the flat cut [rad].
    compression: whether yarns carry compression, with the first slope of their curve. damping: fraction of critical
    damping of an element's highest mode [-]. switches_shear: whether shear unloads on its own curve by the sign of its
    rate (law "curves") instead of one scaled by history (law "curves-shear").
    """

    density: float
    thickness: float
    warp: TestedCurve
    weft: TestedCurve
    shear: TestedCurve
    damping: float
    transverse: float = 1.0
    yarn_angle: float = 0.5 * np.pi
    compression: bool = False
    switches_shear: bool = False

    @cached_property
    def springs(self) -> list[Spring]:
        """Of warp, weft and shear."""

        def stress(curve: Curve, green: np.ndarray) -> np.ndarray:
            return yarn_stress(curve, self.transverse, green)

        yarns = [Spring.of(tested, stress, lambda c: float(green_strain(c.end))) for tested in (self.warp, self.weft)]
        senses = (1.0,) if self.yarn_angle == 0.5 * np.pi else (1.0, -1.0)
        return yarns + [self._shear_spring(sense) for sense in senses]

    def _shear_spring(self, sense: float) -> Spring:
        start = self.start_angle
        # Two fixed curves must stay apart beyond their ends, too: up to yarns on top of each other.
        last = float(sense - np.sin(start)) * sense if self.switches_shear else None
        return Spring.of(
            self.shear,
            lambda curve, z: shear_stress(curve, start, sense, z),
            lambda curve: abs(float(shear_of_angle(sense * curve.end, start))),
            last,
        )

    @property
    def start_angle(self) -> float:
        """gamma0 [rad]: how far the yarns are from right angles in the flat cut."""
        return 0.5 * np.pi - self.yarn_angle

    @cached_property
    def table(self) -> SpringTable:
        """The springs for kernels."""
        return SpringTable.build(self.springs)

    @cached_property
    def _constants(self) -> tuple[float, ...]:
        """Moduli of shortened warp and weft [Pa], then cosine, cotangent and cosecant of the yarns' angle."""
        below = [float(s.loading.rows[0, 2]) if self.compression else 0.0 for s in self.springs[:2]]
        c0, sine = float(np.sin(self.start_angle)), float(np.sin(self.yarn_angle))
        return (*below, c0, c0 / sine, 1.0 / sine)

    @cached_property
    def wave_speed(self) -> float:
        """Bound of the fastest membrane wave [m/s], from the steepest slopes: docs/theory.md, Curve laws."""
        warp, weft, *shear = (spring.steepest for spring in self.springs)
        stress = max(float((s.loading.stress / (1.0 + 2.0 * s.loading.x)).max()) for s in self.springs[:2])
        along = (max(warp, weft) + stress) * (1.0 + abs(np.cos(self.yarn_angle)))
        return float(np.sqrt((along + max(shear)) / self.density))

    @property
    def warp_modulus(self) -> float:
        """Secant of the nominal warp curve at 5 % elongation [Pa]."""
        return self._modulus(self.warp.loading)

    def _modulus(self, curve: Curve) -> float:
        stretch = 1.0 + STRAP_STRAIN
        stress = yarn_stress(curve, self.transverse, np.array(0.5 * (stretch**2 - 1.0)))
        return float(stress) * stretch / STRAP_STRAIN

    def along_yarns(self, reference_inverse: np.ndarray) -> np.ndarray:
        """Warp lies along the first axis of the flat cut, weft at the yarns' angle to it."""
        d11, d12, d21, d22 = reference_inverse
        c, s = np.sin(self.start_angle), np.cos(self.start_angle)
        return np.array([d11, c * d11 + s * d12, d21, c * d21 + s * d22])

    @property
    def history_width(self) -> int:
        return RATES + (OWED + 1 if self.switches_shear else 1 + 2 * len(self.springs))

    def squared_rate(self, membrane: Membrane) -> np.ndarray:
        """(1.2 c/h)^2: the exact bound of a triangle with a wave speed c in all directions is at least 1/1.28 h/c with
        a third of its mass at each corner. With other shares no mode is faster than if all were as the lightest."""
        return (CRITICAL * self.wave_speed / membrane.altitude) ** 2 * membrane.lightness.max(axis=1)

    def add_forces(
        self, membrane: Membrane, corners: Corners, positions: np.ndarray, velocities: np.ndarray,
        history: np.ndarray, loads: np.ndarray, partial: np.ndarray,
    ) -> None:  # fmt: skip
        """As `billow.parts.fabric.membrane.FabricLaw` promises."""
        mesh = membrane.for_kernels(positions, velocities)
        _curve_forces(
            len(membrane.elements), self.switches_shear, self.table, self._constants, mesh, history, tuple(corners),
            loads, partial,
        )  # fmt: skip

    def cost_of_steepness(self, altitude: float) -> tuple[str, float, float]:
        """What the steepest curve does to the step: (its name, stable step [s], stable step without it [s]).

        Without it: as if it were nowhere steeper than the straight line to its end. altitude: of the smallest element
        [m].
        """
        slopes = [spring.steepest for spring in self.springs]
        chords = [spring.loading.stress[-1] / spring.loading.end for spring in self.springs]
        k = int(np.argmax(slopes))
        milder = max(chords[k], *(s for i, s in enumerate(slopes) if i != k and (i < SHEAR) == (k < SHEAR)), 0.0)
        squared = self.wave_speed**2 - (slopes[k] - milder) / self.density
        xi = self.damping
        safe = 0.75 * altitude * (np.sqrt(1.0 + xi**2) - xi)
        return NAMES[k], float(safe / self.wave_speed), float(safe / np.sqrt(max(squared, milder / self.density)))

    def reach(self) -> dict[str, tuple[float, float]]:
        """How far the curves of warp and weft go: name -> (true strain [-], force per width [N/m]) at their end."""
        ends = {name: getattr(self, name).loading for name in NAMES[:2]}
        return {
            name: (curve.end, curve.stress[-1] * float(np.exp(self.transverse * curve.end)) * self.thickness)
            for name, curve in ends.items()
        }

    def concerns(self, altitude: float, setting: Setting) -> Iterator[Concern]:
        """Curves so steep that they alone cost half the step, and curves that end before the stress of a deployment."""
        yield from odd_speed("weft", self._modulus(self.weft.loading), self.density)
        name, now, without = self.cost_of_steepness(altitude)
        if now < COSTLY * without:
            yield STEEP_CURVE(name=name, now=1e6 * now, without=1e6 * without)
        needed = 0.25 * PEAK_PRESSURE * float(np.ptp(setting.start, axis=0).max())  # p R / 2 of a round bag
        for name, (strain, force) in self.reach().items():
            if force < needed:
                yield SHORT_CURVE(name=name, force=force, strain=strain, needed=needed)


@scalar
def shortened(below, strain):
    """(stress s_aa [Pa], energy [J/m^3]) of a yarn of Green strain below zero, nothing above.

    below: modulus [Pa], zero for yarns that go slack; s = below E is smooth through zero length.
    """
    pressed = min(strain, 0.0)
    return below * pressed, 0.5 * below * pressed * pressed


@scalar
def shear_measure(c0, aa, bb, ab):
    """z and its gradient in the yarns' basis, (z, z_aa, z_bb, z_ab): dz/da = z_aa a + z_ab b.

    aa, bb, ab: products of the yarn vectors.
    """
    both = 1.0 / ((1.0 + aa) * (1.0 + bb))
    z = 4.0 * both * ab
    if c0 == 0.0:
        return z, -2.0 * z * both * (1.0 + bb), -2.0 * z * both * (1.0 + aa), 4.0 * both
    lengths = math.sqrt(aa * bb)
    z -= 4.0 * both * c0 * lengths
    # Without length the stress on z vanishes, and with it whatever stands here.
    over = 4.0 * both * c0 / lengths if lengths > 0.0 else 0.0
    return z, -2.0 * z * both * (1.0 + bb) - over * bb, -2.0 * z * both * (1.0 + aa) - over * aa, 4.0 * both


@kernel
def _curve_forces(n, switches_shear, table, constants, mesh, history, corners, loads, partial_out):
    rows, scale, share = table
    below_a, below_b, c0, cot, csc = constants
    remember = 2 if switches_shear else 3
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        block = open_chunk(chunk, corners, loads, partial_out)
        end = min(n, (chunk + 1) * CHUNK)
        heat = 0.0
        for first in range(chunk * CHUNK, end, BLOCK):
            count = min(BLOCK, end - first)
            fetch(block, first, count, mesh, corners)
            strain_of(block, first, mesh)
            for j in range(count):
                i = np.uint64(first + j)
                aa, bb, ab = block[AA + j], block[BB + j], block[AB + j]
                z, zaa, zbb, zab = shear_measure(c0, aa, bb, ab)
                shear, sense = SHEAR, math.copysign(1.0, z)
                if c0 != 0.0 and z < 0.0:
                    shear = SHEAR_BACK
                ea, eb = 0.5 * (aa - 1.0), 0.5 * (bb - 1.0)
                size = (ea, eb, sense * z)
                saa, sbb, h, stored = 0.0, 0.0, 0.0, 0.0
                for k in range(remember):
                    spring = shear if k == SHEAR else k
                    x = size[k] if size[k] > 0.0 else 0.0  # slack, or not a number: damping shows that
                    per_x, full = history[2 * spring + 1, i], history[2 * spring + 2, i]
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
                            history[HEAT, i] += held - before - kept * (x * stress - full)
                            history[2 * spring + 1, i] = INTERVALS / x
                            history[2 * spring + 2, i] = x * stress
                            held = kept * x * stress
                    stored += held
                    if k == WARP:
                        saa = stress
                    elif k == WEFT:
                        sbb = stress
                    else:
                        h = sense * stress
                if switches_shear:
                    at = (sense * z if sense * z > 0.0 else 0.0) * scale[shear]
                    row, part = place(2 * shear * INTERVALS, at)
                    upper, _ = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[shear])
                    row, part = place((2 * shear + 1) * INTERVALS, at)
                    lower, held = read(rows[row, 0], rows[row, 1], rows[row, 2], part, scale[shear])
                    faster = zaa * block[R11 + j] + zbb * block[R22 + j] + 2.0 * zab * block[R12 + j]
                    h = sense * (upper if sense * faster >= 0.0 else lower)
                    # Work as the time integration does it, with the mean of both stresses, less what is recoverable.
                    lost = 0.5 * (h + history[LAST_STRESS, i]) * (z - history[LAST_Z, i]) - (
                        held - history[LAST_STORED, i]
                    )
                    owed = history[OWED, i]
                    history[HEAT, i] += max(0.0, lost - owed)  # heat never falls: what comes back is owed
                    history[OWED, i] = max(0.0, owed - lost)
                    history[LAST_Z, i], history[LAST_STRESS, i], history[LAST_STORED, i] = z, h, held
                    stored += held
                pressed_a, stored_a = shortened(below_a, ea)
                pressed_b, stored_b = shortened(below_b, eb)
                saa, sbb, stored = saa + pressed_a, sbb + pressed_b, stored + stored_a + stored_b
                block[S11 + j], block[S22 + j], block[S12 + j] = saa + h * zaa, sbb + h * zbb, h * zab
                block[ENERGY + j] = stored
                heat += mesh[0][V, i] * history[HEAT, i]
            load(block, first, mesh, history, cot, csc, 0.0)
            add_up(block, first, count, mesh, corners, history, loads, chunk, partial_out)
        close_chunk(block, chunk, partial_out)
        partial_out[chunk, HYSTERESIS] = heat
