"""Whether curves describe a fabric: refused here if a run with them would have no physics, before it starts.

Every message names the curve as the case does, for example `fabric.curves.warp.loading`.
"""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.parts.fabric.curve import Curve, TestedCurve
from billow.parts.fabric.curve_fabric import NAMES, CurveFabric

LARGEST_TURN = np.radians(80.0)
"""Shear angle, counted from right angles, up to which a curve may go: at 90 degrees the yarns lie on each other."""

SAME = 0.02
"""Part of the stress by which unloading may miss the end of loading, or rise above it."""

NO_CURVE = InputError.declare(
    "E-FAB-003",
    "the points do not make a curve",
    cause="fewer than two points, strains that do not grow, or no point at zero",
    remedy="begin the curve at 0, 0 and sort its points by strain",
)
STRESS_FALLS = InputError.declare(
    "E-FAB-004",
    "the stress falls from {before:.4g} to {after:.4g} Pa",
    where="{curve}, from {start:g} to {end:g} {unit}",
    why="fabric that softens has no stable shape: strain would gather in one row of elements",
    cause="noise of the test, or points beyond the tearing of the sample",
    remedy="smooth the curve, and end it where the fabric tears",
)
UNLOADING_DOES_NOT_FIT = InputError.declare(
    "E-FAB-005",
    "the unloading curve does not begin on the loading curve",
    where="{curve}.unloading, {place}",
    cause="the two exchanged, or taken from different tests",
    remedy="end both curves at the point where the test turned round",
)
ENERGY_CREATED = InputError.declare(
    "E-FAB-006",
    "a cycle to a larger strain would give back energy that smaller cycles turned to heat",
    where="{curve}.unloading",
    why="unloading gives back {share:.3g} % of stress times strain; where loading stiffens most ({strain:.3g}, "
    "{stress:.3g} Pa) at most {most:.3g} % are possible",
    remedy="make the unloading curve more hollow, or smooth the kink of the loading curve",
)


def check_curves(fabric: CurveFabric, where: str) -> None:
    """where: key of the table that holds warp, weft and shear.

    Raises InputError: E-FAB-003 points that make no curve, E-FAB-004 falling or negative stress, E-FAB-005 unloading
    that does not belong to the loading, E-FAB-006 unloading that would create energy.
    """
    for name in NAMES[:3]:
        tested: TestedCurve = getattr(fabric, name)
        _check_points(tested.loading, name, f"{where}.{name}.loading", fabric)
        if tested.unloading is not None:
            _check_points(tested.unloading, name, f"{where}.{name}.unloading", fabric)
            _check_pair(tested, name, f"{where}.{name}")
    for name, spring in zip(NAMES, fabric.springs, strict=False):
        if not (name == "shear" and fabric.switches_shear):
            _check_heat(spring, name, f"{where}.{name}")


def check_shape(strain: tuple[float, ...], stress: tuple[float, ...], where: str) -> None:
    """Raises InputError E-FAB-003 unless there are as many strains as stresses, and at least two."""
    if len(strain) != len(stress):
        why = f"it has {len(strain)} strains and {len(stress)} stresses"
        raise NO_CURVE(where=where, why=why, remedy="give one stress per strain")
    if len(strain) < 2:
        raise NO_CURVE(where=where, why=f"it has {len(strain)} points", remedy="give at least two, the first at zero")


def _check_points(curve: Curve, name: str, where: str, fabric: CurveFabric) -> None:
    x, stress = np.array(curve.strain), np.array(curve.stress)
    shown, unit = (np.degrees(x), "deg") if name == "shear" else (x, "of strain")
    if x[0] != 0.0 or stress[0] != 0.0:
        why = f"it begins at {shown[0]:g} {unit} with {stress[0]:g} Pa; fabric without strain has no stress"
        remedy = "begin with the point 0, 0; take off what a pretension or a residual strain added"
        raise NO_CURVE(where=where, why=why, remedy=remedy)
    k = int(np.argmin(np.diff(x)))
    if x[k + 1] <= x[k]:
        why = f"{shown[k + 1]:g} {unit} follows {shown[k]:g}"
        raise NO_CURVE(where=where, why=why, remedy="sort the points; give each strain once")
    turn = x[-1] + abs(fabric.start_angle)
    if name == "shear" and turn > LARGEST_TURN:
        why = f"it ends {np.degrees(turn):.3g} deg from right angles; at 90 the yarns lie on each other"
        remedy = "check the unit of the angle; end the curve at 40 to 50 deg, beyond which its last slope is kept"
        raise NO_CURVE(where=where, why=why, remedy=remedy)
    falling = np.flatnonzero(np.diff(stress) < 0.0)
    if len(falling) or (stress < 0.0).any():
        k = int(falling[0]) if len(falling) else int(np.argmax(stress < 0.0)) - 1
        raise STRESS_FALLS(
            before=stress[k], after=stress[k + 1], curve=where, start=shown[k], end=shown[k + 1], unit=unit
        )
    if stress[-1] == 0.0 or (stress[1] == 0.0 and where.endswith(".loading")):
        raise STRESS_FALLS(
            what="there is no stress",
            where=f"{where}, up to {shown[-1 if stress[-1] == 0.0 else 1]:g} {unit}",
            why="fabric that does not resist at all has no shape",
            remedy="give the first point a small stress, or check the column of stresses",
        )


def _check_pair(tested: TestedCurve, name: str, where: str) -> None:
    loading, unloading = tested.loading, tested.unloading
    end, stress = unloading.end, unloading.stress[-1]
    reached = float(loading.at(end))
    shown = f"{np.degrees(end):g} deg" if name == "shear" else f"{end:g} of strain"
    beyond = end > loading.end * (1.0 + SAME)
    if beyond or abs(stress - reached) > SAME * reached:
        why = "loading ends before" if beyond else f"it has {stress:.4g} Pa there, loading {reached:.4g} Pa"
        raise UNLOADING_DOES_NOT_FIT(curve=where, place=f"at {shown}", why=why)
    x = np.array(unloading.strain[1:])
    above = np.array(unloading.stress[1:]) - (1.0 + SAME) * loading.at(x)
    if (above > 0.0).any():
        k = int(above.argmax())
        raise UNLOADING_DOES_NOT_FIT(
            what="the unloading curve lies above the loading curve",
            curve=where,
            place=f"point {k + 2}",
            why=f"it has {unloading.stress[k + 1]:.4g} Pa, loading {float(loading.at(x[k])):.4g} Pa: "
            "each cycle would create energy",
            remedy="exchange the two curves, or check the columns",
        )


def _check_heat(spring, name: str, where: str) -> None:
    """Loading further must not give back what was turned to heat before: (1 - U) f >= U x f' on the whole curve."""
    growth = np.diff(spring.heat, prepend=0.0)
    if growth.min() >= -1e-6 * spring.heat.max():
        return
    k = int(growth.argmin())
    x, f, slope = spring.loading.x[k], spring.loading.stress[k], spring.loading.slope[k]
    raise ENERGY_CREATED(curve=where, share=100 * spring.share, strain=x, stress=f, most=100 / (1.0 + x * slope / f))
