"""S9, S10: fabric on the test bench must return its curves (docs/theory.md, Verification cases)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.apps.coupon.bench import Measured, run_test
from billow.apps.coupon.comparison import Points, given_curves, with_law
from billow.apps.coupon.rating import branches, ripple
from billow.apps.coupon.specimen import Biaxial, PictureFrame
from billow.apps.verification.check import Measurement
from billow.case.fabric.build_fabric import build_fabric
from billow.case.schema import Case

NYLON = Case.from_dict({"fabric": {"law": "curves-shear"}}).fabric


def picture_frame() -> Iterator[Measurement]:
    """S9: T is from the shear curve; no ripple on unloading, unlike the law that switches by the sign of the shear
    rate."""
    angle = float(np.radians(40.0))
    test = run_test(PictureFrame(0.2, 0.02), build_fabric(NYLON), angle)
    yield Measurement("furthest from the curves, of peak stress (absolute)", _furthest(test, angle, 0), 0.0, 0.01)
    peak = float(test.machine_force.max())
    tension = 12e6 * NYLON.thickness  # where the shear curve ends
    lever = np.sin(0.25 * np.pi - 0.5 * angle) * PictureFrame.mounted
    yield Measurement("force of the machine at 40 deg [N]", peak, tension * 0.2 / lever, 0.01)
    # Turning back before the curves end, where the unloading curve as it is lies below the loading curve.
    ripples = []
    for law in ("curves-shear", "curves"):
        test = run_test(PictureFrame(0.2, 0.01), build_fabric(with_law(NYLON, law)), 0.875 * angle)
        ripples.append(ripple(test.strain[:, 0], test.stress[:, 0])[1])
    yield Measurement("ripple on unloading from 35 deg (absolute)", ripples[0], 0.0, 0.01)
    yield Measurement("the old law ripples more than tenfold", float(ripples[1] > 10.0 * ripples[0]), 1.0, 0.0)


def biaxial_cycle() -> Iterator[Measurement]:
    """S10: a biaxial loop returns the input curves."""
    test = run_test(Biaxial(0.1, 0.02), build_fabric(NYLON), 0.25, duration=0.05)
    for k, curve in enumerate(test.curves):
        yield Measurement(f"{curve}: furthest from the curves (absolute)", _furthest(test, 0.25, k), 0.0, 0.005)


def _furthest(test: Measured, peak: float, k: int) -> float:
    """Largest deviation from the given curves over the largest stress [-], both branches."""
    given: Points = list(given_curves("biaxial" if len(test.curves) == 2 else "picture-frame", NYLON, peak).values())[k]
    worst = 0.0
    for measured, wanted in zip(branches(test.strain[:, k]), branches(given[0]), strict=True):
        order = np.argsort(test.strain[measured, k], kind="stable")
        found = np.interp(given[0][wanted], test.strain[measured, k][order], test.stress[measured, k][order])
        worst = max(worst, float(np.abs(found - given[1][wanted]).max()))
    return worst / float(given[1].max())
