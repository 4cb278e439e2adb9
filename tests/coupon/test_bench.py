"""The bench against closed forms of the linear law, where stress follows from the clamps' motion alone."""

import numpy as np
import pytest

from billow.apps.coupon.bench import run_test
from billow.apps.coupon.specimen import Biaxial, PictureFrame, Strip
from billow.parts.fabric.linear_law import LinearFabric

FABRIC = LinearFabric(
    density=800.0, thickness=0.3e-3, young_warp=0.40e9, young_weft=0.35e9, poisson=0.0, shear=10e6,
    compression=False, damping=0.05,
)  # fmt: skip
STATIC = 5e-3  # of the largest value: what inertia and damping of a test of 20 ms add


@pytest.fixture(scope="module")
def tests():
    return {
        "biaxial": run_test(Biaxial(0.1, 0.02), FABRIC, 0.05, duration=0.02),
        "strip": run_test(Strip(0.2, 0.05, 0.0125, "weft"), FABRIC, 0.05, duration=0.02),
        "frame": run_test(PictureFrame(0.1, 0.02), FABRIC, 0.5, duration=0.02),
    }


def green(strain):
    return 0.5 * (np.exp(2.0 * strain) - 1.0)


def test_biaxial_stress_is_that_of_the_law(tests):
    """Second Piola stress S = E Green: per current width the force is S lambda / lambda."""
    measured = tests["biaxial"]
    for k, young in enumerate((FABRIC.young_warp, FABRIC.young_weft)):
        exact = young * green(measured.strain[:, k])
        np.testing.assert_allclose(measured.stress[:, k], exact, atol=STATIC * exact.max())


def test_a_strip_stretches_where_it_is_measured(tests):
    """Without Poisson's ratio the strip keeps its width: true stress is S lambda, strain is that of the clamps."""
    measured = tests["strip"]
    strain = measured.strain[:, 0]
    assert measured.curves == ("weft",)
    assert strain.max() == pytest.approx(0.05, rel=1e-3)
    exact = FABRIC.young_weft * green(strain) * np.exp(strain)
    np.testing.assert_allclose(measured.stress[:, 0], exact, atol=2 * STATIC * exact.max())


def test_picture_frame_obeys_its_force_formula(tests):
    """S9: the strain energy per area is G (m^2 sin(gamma))^2 / 2 for yarns mounted at stretch m, so T = G m^4 sin cos
    and F = T L t / (m sin(pi/4 - gamma/2))."""
    m = 1.0005
    measured = tests["frame"]
    angle = measured.strain[:, 0]
    exact = FABRIC.shear * m**4 * np.sin(angle) * np.cos(angle)
    np.testing.assert_allclose(measured.stress[:, 0], exact, atol=STATIC * exact.max())
    force = exact * FABRIC.thickness * 0.1 / m / np.sin(0.25 * np.pi - 0.5 * angle)
    np.testing.assert_allclose(measured.machine_force, force, atol=STATIC * force.max())
    small = run_test(PictureFrame(0.1, 0.02), FABRIC, 2e-3, duration=0.02)
    tension = FABRIC.shear * small.strain[:, 0].max() * FABRIC.thickness
    force = small.machine_force[np.argmax(small.strain[:, 0])]
    assert force == pytest.approx(np.sqrt(2.0) * tension * m**3 * 0.1, rel=STATIC)


def test_the_clamps_pay_for_everything(tests):
    """Work of the clamps = what is stored + what is lost; the trapezoid rule over a step is of second order."""
    for name, measured in tests.items():
        scale = max(measured.machine_force) * 0.05 * 0.1
        assert abs(measured.work - measured.stored - measured.lost) < 1e-4 * scale, name
        assert measured.kinetic_share < 2e-3, name
