"""Stress-strain curves as they come out of a test, and the forces s(E) and H(z) that have a potential and return the
test: docs/theory.md, Curve laws. gamma0 is 90 degrees minus the yarns' angle in the flat cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Curve:
    """Points of a curve through (0, 0), joined by straight lines; beyond the end the last slope continues.

    Yarns: true (logarithmic) strain [-] against true stress [Pa]. Shear: angle [rad] against shear stress [Pa].
    """

    strain: tuple[float, ...]
    stress: tuple[float, ...]

    @property
    def end(self) -> float:
        """Last strain."""
        return self.strain[-1]

    def at(self, strain: np.ndarray | float) -> np.ndarray:
        """Stress [Pa] at strains of any size from 0 on, same shape."""
        slope = (self.stress[-1] - self.stress[-2]) / (self.strain[-1] - self.strain[-2])
        return np.interp(strain, self.strain, self.stress) + slope * np.maximum(0.0, np.asarray(strain) - self.end)


@dataclass(frozen=True)
class TestedCurve:
    """Loading, and unloading from the end of the test; without unloading the fabric is elastic in this direction."""

    __test__ = False  # not a test for pytest to collect

    loading: Curve
    unloading: Curve | None = None


def green_strain(strain: np.ndarray | float) -> np.ndarray:
    """E [-] of true strains [-]."""
    return 0.5 * np.expm1(2.0 * np.asarray(strain))


def yarn_stress(curve: Curve, transverse: float, green: np.ndarray) -> np.ndarray:
    """s [Pa] at Green strains E >= 0 [-]; transverse: transverse over axial true strain of the test [-]."""
    strain = 0.5 * np.log1p(2.0 * green)
    return curve.at(strain) * np.exp((transverse - 1.0) * strain)


def shear_of_angle(angle: np.ndarray | float, start: float) -> np.ndarray:
    """z [-] of shear angles [rad] of either sign; start: gamma0 [rad]."""
    return np.sin(angle + start) - np.sin(start)


def shear_stress(curve: Curve, start: float, sense: float, z: np.ndarray) -> np.ndarray:
    """H [Pa] at sizes z >= 0 [-] of the measure in the sense +1 or -1; start: gamma0 [rad].

    Beyond the curve's end H, not tau, continues straight: tau / cos has a pole where the yarns lie on each other.
    """
    last = abs(float(shear_of_angle(sense * curve.end, start)))

    def at(size: np.ndarray) -> np.ndarray:
        turned = np.arcsin(np.sin(start) + sense * size)
        return curve.at(sense * (turned - start)) / np.cos(turned)

    step = 1e-3 * last
    slope = (at(np.array(last)) - at(np.array(last - step))) / step
    return at(np.minimum(z, last)) + slope * np.maximum(0.0, z - last)
