"""Fabric described by curves: what the laws "curves" and "curves-shear" share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from billow.base.errors import Concern
from billow.parts.fabric.curve import TestedCurve
from billow.parts.fabric.curve_table import Spring, SpringTable, Stress
from billow.parts.fabric.nominal import green_strain, shear_measure, shear_stress, yarn_stress
from billow.parts.part import Setting

WARP, WEFT, SHEAR, SHEAR_BACK = range(4)
"""Springs of a fabric. Where the yarns are not at right angles, shear differs between its two senses and has a spring
for either; otherwise there is no SHEAR_BACK."""

HEAT = 0
"""Column of the history: energy turned to heat so far [J/m^3]."""

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
    damping of an element's highest mode [-].
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
    switches_shear: ClassVar[bool]
    """Whether shear unloads on its own curve instead of one scaled by history."""

    @cached_property
    def springs(self) -> list[Spring]:
        """Of warp, weft and shear."""
        yarns = [_spring(curve, *self._yarn(curve), scaled=True) for curve in (self.warp, self.weft)]
        senses = (1.0,) if self.is_orthogonal else (1.0, -1.0)
        scaled = not self.switches_shear
        return yarns + [_spring(self.shear, *self._shear(sense), scaled=scaled) for sense in senses]

    def _yarn(self, tested: TestedCurve):
        return (
            lambda curve: lambda green: yarn_stress(curve, self.transverse, green),
            lambda curve: float(green_strain(curve.end)),
            float(green_strain(tested.loading.end)),
        )

    def _shear(self, sense: float):
        start = self.start_angle

        def end(curve):
            return abs(float(shear_measure(sense * curve.end, start)))

        # Two fixed curves must stay apart beyond their ends, too: up to yarns on top of each other.
        last = float(sense - np.sin(start)) * sense if self.switches_shear else end(self.shear.loading)
        return lambda curve: lambda z: shear_stress(curve, start, sense, z), end, last

    @property
    def is_orthogonal(self) -> bool:
        return self.yarn_angle == 0.5 * np.pi

    @property
    def start_angle(self) -> float:
        """gamma0 [rad]: how far the yarns are from right angles in the flat cut."""
        return 0.5 * np.pi - self.yarn_angle

    @cached_property
    def table(self) -> SpringTable:
        """The springs for kernels."""
        return SpringTable.build(self.springs)

    @cached_property
    def constants(self) -> np.ndarray:
        """(5,): moduli of shortened warp and weft [Pa], then cosine, cotangent and cosecant of the yarns' angle."""
        below = [s.loading.rows[0, 2] if self.compression else 0.0 for s in self.springs[:2]]
        angle = self.yarn_angle
        return np.array(
            [*below, np.sin(self.start_angle), np.sin(self.start_angle) / np.sin(angle), 1.0 / np.sin(angle)]
        )

    @cached_property
    def wave_speed(self) -> float:
        """Bound of the fastest membrane wave [m/s], from the steepest slopes.

        A yarn family of stretch l has the tangent ds/dE l^2 + s along itself; `Membrane.stable_dt` allows for the
        growth with l^2. The acoustic tensor of two families, K_warp a (x) a cos^2 + K_weft b (x) b cos^2, has no larger
        eigenvalue than max(K) (1 + |cos|) with the cosine of the yarns' angle. Shear adds dH/dz.
        """
        warp, weft, *shear = (spring.steepest for spring in self.springs)
        stress = max(float((s.loading.stress / (1.0 + 2.0 * s.loading.x)).max()) for s in self.springs[:2])
        along = (max(warp, weft) + stress) * (1.0 + abs(np.cos(self.yarn_angle)))
        return float(np.sqrt((along + max(shear)) / self.density))

    @property
    def warp_modulus(self) -> float:
        """Secant of the nominal warp curve at 5 % elongation [Pa]."""
        stretch = 1.0 + STRAP_STRAIN
        stress = yarn_stress(self.warp.loading, self.transverse, np.array(0.5 * (stretch**2 - 1.0)))
        return float(stress) * stretch / STRAP_STRAIN

    def along_yarns(self, reference_inverse: np.ndarray) -> np.ndarray:
        """Warp lies along the first axis of the flat cut, weft at the yarns' angle to it."""
        d11, d12, d21, d22 = reference_inverse
        c, s = np.sin(self.start_angle), np.cos(self.start_angle)
        return np.array([d11, c * d11 + s * d12, d21, c * d21 + s * d22])

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
        """How far the curves of warp and weft go: name -> (true strain [-], force per width [N/m]) at their end.

        Beyond, they go on with their last slope.
        """
        ends = {name: getattr(self, name).loading for name in NAMES[:2]}
        return {
            name: (curve.end, curve.stress[-1] * float(np.exp(self.transverse * curve.end)) * self.thickness)
            for name, curve in ends.items()
        }

    def concerns(self, altitude: float, setting: Setting) -> Iterator[Concern]:
        """Curves so steep that they alone cost half the step, and curves that end before the stresses of a deployment.

        altitude: of the smallest element [m].
        """
        name, now, without = self.cost_of_steepness(altitude)
        if now < COSTLY * without:
            yield STEEP_CURVE(name=name, now=1e6 * now, without=1e6 * without)
        needed = 0.25 * PEAK_PRESSURE * float(np.ptp(setting.start, axis=0).max())  # p R / 2 of a round bag
        for name, (strain, force) in self.reach().items():
            if force < needed:
                yield SHORT_CURVE(name=name, force=force, strain=strain, needed=needed)


def _spring(tested: TestedCurve, stress, end, table_end: float, *, scaled: bool) -> Spring:
    """Spring of a tested direction; stress(curve) and end(curve) are its nominal stress and the end of its curve."""
    loading: Stress = stress(tested.loading)
    if tested.unloading is None:
        return Spring.elastic(loading, table_end)
    unloading = stress(tested.unloading)
    if scaled:
        return Spring.scaled(loading, table_end, unloading, end(tested.unloading))
    return Spring.switched(loading, table_end, unloading)
