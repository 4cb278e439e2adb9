"""Curves for tests: a stiffening yarn, a locking shear, hollow unloading; and the fabrics made from them."""

from __future__ import annotations

import numpy as np

from billow.parts.fabric.curve import Curve, TestedCurve
from billow.parts.fabric.curve_fabric import LAST_Z, OWED, CurveFabric

STRAIN = (0.0, 0.01, 0.03, 0.06, 0.10, 0.20)
WARP = (0.0, 1e6, 3.9e6, 12.5e6, 28e6, 80e6)
ANGLE = tuple(np.radians([0.0, 3.0, 10.0, 20.0, 30.0, 40.0]))
SHEAR = (0.0, 1e6, 3e6, 4.6e6, 7e6, 12e6)


def hollow(end: float, stress: float) -> Curve:
    """Power 2.5 of strain, in 20 pieces."""
    x = np.linspace(0.0, 1.0, 21)
    return Curve(tuple(end * x), tuple(stress * x**2.5))


def two_way(strain, stress, unloading: bool) -> TestedCurve:
    back = hollow(strain[-1], stress[-1]) if unloading else None
    return TestedCurve(Curve(tuple(strain), tuple(stress)), back)


def fabric(*, unloading: bool = True, damping: float = 0.05, **others):
    weft = tuple(0.8 * s for s in WARP)
    return CurveFabric(
        800.0,
        3e-4,
        two_way(STRAIN, WARP, unloading),
        two_way(STRAIN, weft, unloading),
        two_way(ANGLE, SHEAR, unloading),
        damping,
        **others,
    )


OBLIQUE = np.radians(70.0)


def strained_further(law, history: np.ndarray) -> np.ndarray:
    """History of fabric that was strained half as far again in every direction that remembers."""
    further = history.copy()
    if hasattr(law, "springs"):
        for spring in range(2 if law.switches_shear else len(law.springs)):
            further[2 * spring + 1] /= 1.5
            further[2 * spring + 2] *= 1.5
    return further


def first_time(law, history: np.ndarray) -> np.ndarray:
    """History of fabric that comes to the place of its last evaluation for the first time."""
    fresh = np.zeros_like(history)
    if getattr(law, "switches_shear", False):
        fresh[LAST_Z:OWED] = history[LAST_Z:OWED]  # of the last evaluation, which is needed for the work since
    return fresh


def owed(membrane, history: np.ndarray) -> float:
    """Energy [J] that a membrane gave back though it had been booked as heat."""
    if not getattr(membrane.fabric, "switches_shear", False):
        return 0.0
    return float(membrane.volume @ history[OWED, : len(membrane.volume)])


CURVE_FABRICS = {
    "curves": fabric(switches_shear=True),
    "curves, oblique": fabric(switches_shear=True, yarn_angle=OBLIQUE),
    "curves-shear": fabric(),
    "curves-shear, oblique": fabric(yarn_angle=OBLIQUE),
    "curves-shear, compression": fabric(compression=True),
    "curves-shear, elastic": fabric(unloading=False),
}
"""Name -> a fabric described by curves."""
