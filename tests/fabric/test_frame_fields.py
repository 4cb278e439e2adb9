"""Stretch, strain and stress of the frames against closed forms, for every law and however the fabric is turned."""

import numpy as np
import pytest
from curves import fabric as curve_fabric

from billow.parts.fabric.frame_fields import BITS, fabric_fields, rounded
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane

FLAT = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.0, 0.2]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [1, 0, 2]], np.uint32)
"""The last one is a hole: no membrane covers it."""
TOLERANCE = 2.0**-BITS
MODULI = {"young_warp": 4e8, "young_weft": 4e8, "poisson": 0.25, "shear": 1.6e8}
ISOTROPIC = LinearFabric(density=800.0, thickness=3e-4, compression=True, damping=0.1, **MODULI)


def turn():
    """A rotation by no special angle."""
    q, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def fields_of(fabric, deformation, velocities=None):
    """Of a rectangle of fabric whose flat cut is deformed by a (2, 2) matrix, and turned in space."""
    membrane = Membrane.build(fabric, np.array([0, 1]), FLAT[TRIANGLES[:2].astype(int)])
    positions = np.column_stack([FLAT @ np.array(deformation, float).T, np.zeros(4)]) @ turn().T + 5.0
    velocities = np.zeros((4, 3)) if velocities is None else velocities
    history = membrane.fresh_history()
    found = fabric_fields([membrane], [history], TRIANGLES, positions, velocities)
    np.testing.assert_array_equal(history, membrane.fresh_history())
    return {name: values[:2] for name, values in found.items()}, {name: values[2] for name, values in found.items()}


def test_fabric_as_cut_has_neither_strain_nor_stress_and_holes_never_have():
    fabric, hole = fields_of(ISOTROPIC, np.eye(2))
    for found in (fabric["strain_warp"], fabric["strain_weft"], fabric["stress"] / 4e8):
        np.testing.assert_allclose(found, 0.0, atol=1e-12)
    np.testing.assert_allclose(fabric["stretch"], 1.0, rtol=1e-12)
    _, hole = fields_of(ISOTROPIC, [[1.2, 0.0], [0.0, 1.1]])
    assert hole == {"stretch": 1.0, "strain_warp": 0.0, "strain_weft": 0.0, "stress": 0.0}


def test_strains_are_those_along_warp_and_weft():
    found, _ = fields_of(ISOTROPIC, [[1.10, 0.0], [0.0, 1.04]])
    np.testing.assert_allclose(found["strain_warp"], 0.5 * (1.10**2 - 1.0), rtol=TOLERANCE)
    np.testing.assert_allclose(found["strain_weft"], 0.5 * (1.04**2 - 1.0), rtol=TOLERANCE)
    np.testing.assert_allclose(found["stretch"], 1.10, rtol=TOLERANCE)


def test_stress_of_biaxial_stretch_is_that_of_the_law():
    """True stress s1^2 S11 / (s1 s2), with S = c E and the thickness of the flat cut."""
    one, other = 1.06, 1.02
    c11 = 4e8 / (1.0 - 0.25**2)
    e11, e22 = 0.5 * (one**2 - 1.0), 0.5 * (other**2 - 1.0)
    found, _ = fields_of(ISOTROPIC, [[one, 0.0], [0.0, other]])
    np.testing.assert_allclose(found["stress"], one / other * c11 * (e11 + 0.25 * e22), rtol=TOLERANCE)


def test_pure_shear_pulls_along_one_diagonal():
    """Stretched by s along a diagonal and by 1/s across it: S = c E along both, area unchanged."""
    s = 1.05
    along = np.array([1.0, 1.0]) / np.sqrt(2.0)
    across = np.array([1.0, -1.0]) / np.sqrt(2.0)
    found, _ = fields_of(ISOTROPIC, s * np.outer(along, along) + np.outer(across, across) / s)
    c11 = 4e8 / (1.0 - 0.25**2)
    e1, e2 = 0.5 * (s**2 - 1.0), 0.5 * (s**-2 - 1.0)
    np.testing.assert_allclose(found["stress"], s**2 * c11 * (e1 + 0.25 * e2), rtol=TOLERANCE)
    np.testing.assert_allclose(found["stretch"], s, rtol=TOLERANCE)


def test_damping_is_no_stress():
    still, _ = fields_of(ISOTROPIC, [[1.05, 0.0], [0.0, 1.0]])
    moving, _ = fields_of(ISOTROPIC, [[1.05, 0.0], [0.0, 1.0]], np.random.default_rng(1).normal(size=(4, 3)))
    np.testing.assert_array_equal(still["stress"], moving["stress"])


def test_a_collapsed_triangle_has_no_stress_and_nothing_is_no_number():
    found, _ = fields_of(ISOTROPIC, [[1.5, 0.0], [0.0, 0.0]])
    assert all(np.isfinite(values).all() for values in found.values())
    np.testing.assert_array_equal(found["stress"], 0.0)


@pytest.mark.parametrize("angle", [0.5 * np.pi, 1.2])
def test_force_times_width_of_a_curve_law_is_what_its_edges_pull_with(angle):
    """Whatever the law: the traction on an edge is stress times thickness, summed from the corner forces."""
    fabric = curve_fabric(yarn_angle=angle)
    membrane = Membrane.build(fabric, np.array([0, 1]), FLAT[TRIANGLES[:2].astype(int)])
    positions = np.column_stack([FLAT * [1.08, 1.08], np.zeros(4)])
    still, history = np.zeros((4, 3)), membrane.fresh_history()
    nodes = np.zeros((4, 3))
    np.add.at(nodes, TRIANGLES[:2].astype(int), membrane.by_itself(TRIANGLES, positions, still, history)[0])
    right = -nodes[[1, 2], 0].sum() / (0.2 * 1.08 * fabric.thickness)
    top = -nodes[[2, 3], 1].sum() / (0.3 * 1.08 * fabric.thickness)
    sheared = -nodes[[1, 2], 1].sum() / (0.2 * 1.08 * fabric.thickness)
    expected = np.linalg.eigvalsh([[right, sheared], [sheared, top]])[1]
    found = fabric_fields([membrane], [membrane.fresh_history()], TRIANGLES, positions, still)
    np.testing.assert_allclose(found["stress"][:2], expected, rtol=2 * TOLERANCE)
    assert expected > 0.0


def test_rounding_keeps_eleven_bits():
    values = np.random.default_rng(0).normal(size=10000) * 10.0 ** np.random.default_rng(1).integers(-9, 9, 10000)
    short = rounded(values)
    assert np.abs(short / values - 1.0).max() <= 2.0**-BITS
    assert len(np.unique(np.frexp(short)[0])) <= 2 ** (BITS + 1)
    np.testing.assert_array_equal(rounded(np.array([0.0, 1.0, -2.5])), [0.0, 1.0, -2.5])
