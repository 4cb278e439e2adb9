"""Forces of membrane triangles: minus the gradient of the energy, objective, and without net force or torque."""

from __future__ import annotations

import numpy as np
import pytest
from cloth import FABRICS, FLAT, TRIANGLES, forces, nodal, patch, shaken
from hypothesis import assume, given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.parts.fabric.linear_law import KEEP, PRINCIPAL, YARN, LinearFabric
from billow.parts.fabric.membrane import Membrane

RULES = pytest.mark.parametrize("rule", [KEEP, PRINCIPAL, YARN])


@RULES
@pytest.mark.parametrize("strain", [0.02, 0.3])
def test_force_is_minus_the_gradient_of_the_energy(rule, strain):
    membrane, step = patch(rule), 1e-8
    for seed in range(5):
        positions = shaken(seed, strain)
        force = nodal(forces(membrane, positions)[0])
        slope = np.zeros_like(force)
        for node, axis in np.ndindex(5, 3):
            for sign in (1.0, -1.0):
                moved = positions.copy()
                moved[node, axis] += sign * step
                slope[node, axis] += sign * forces(membrane, moved)[1] / (2.0 * step)
        assert np.abs(force).max() > 0.1  # something pulls
        assert np.abs(force + slope).max() <= 1e-6 * np.abs(force).max()


@RULES
@given(seed=st.integers(0, 10_000), strain=st.sampled_from([0.01, 0.1, 1.0]), speed=st.sampled_from([0.0, 1.0, 300.0]))
def test_each_triangle_is_without_net_force_and_torque(rule, seed, strain, speed):
    positions = shaken(seed, strain)
    velocities = speed * np.random.default_rng(seed + 1).normal(size=(5, 3))
    corner_force, energy, power = forces(patch(rule), positions, velocities)
    scale = np.abs(corner_force).max() + 1e-300
    assert np.abs(corner_force.sum(axis=1)).max() <= 1e-14 * scale
    torque = np.cross(positions[TRIANGLES] - positions.mean(axis=0), corner_force).sum(axis=1)
    assert np.abs(torque).max() <= 1e-13 * scale * np.ptp(positions, axis=0).max()
    assert energy >= 0.0
    assert power >= 0.0
    assert (power > 0.0) == (speed > 0.0)


@RULES
def test_damping_takes_the_power_it_books(rule):
    positions, velocities = shaken(3, 0.05), np.random.default_rng(4).normal(size=(5, 3))
    elastic = nodal(forces(patch(rule), positions)[0])
    both, _, power = forces(patch(rule), positions, velocities)
    assert -np.sum((nodal(both) - elastic) * velocities) == pytest.approx(power, rel=1e-10)


@RULES
def test_rigid_motion_changes_nothing(rule):
    rng = np.random.default_rng(0)
    for seed in range(5):
        positions, velocities = shaken(seed, 0.1), rng.normal(size=(5, 3))
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        spin = rng.normal(size=(3, 3))
        spin -= spin.T
        here, energy, power = forces(patch(rule), positions, velocities)
        turned, drift = positions @ turn.T, rng.normal(size=3)
        there, energy_there, power_there = forces(
            patch(rule), turned + drift, velocities @ turn.T + turned @ spin + 7.0
        )
        assert energy_there == pytest.approx(energy, rel=1e-11)
        assert power_there == pytest.approx(power, rel=1e-9)
        assert there == pytest.approx(here @ turn.T, abs=1e-10 * np.abs(here).max())


def strain_matrix(membrane):
    """Strain (11, 22, 2 x 12) of the displacements (x, y) of three corners: (3, 6)."""
    rows = membrane.reference_inverse[:, 0].reshape(2, 2)
    slopes = np.array([-rows[0] - rows[1], rows[0], rows[1]])
    strain_of = np.zeros((3, 6))
    strain_of[0, 0::2], strain_of[1, 1::2] = slopes[:, 0], slopes[:, 1]
    strain_of[2, 0::2], strain_of[2, 1::2] = slopes[:, 1], slopes[:, 0]
    return strain_of


young = st.floats(1e8, 1e9)


@given(
    warp=young,
    weft=young,
    poisson=st.floats(0.0, 0.45),
    shear=st.floats(1e6, 1e8),
    corner=st.tuples(st.floats(0.2, 0.8), st.floats(0.3, 1.5)),
    turn=st.floats(0.0, np.pi),
)
def test_the_stable_step_is_the_exact_bound(warp, weft, poisson, shear, corner, turn):
    """2/omega of a lumped-mass triangle from its eigenvalues, for any fabric softer in shear than along its yarns."""
    assume(poisson**2 * weft < 0.9 * warp)
    fabric = LinearFabric(800.0, 3e-4, warp, weft, poisson, shear, compression=True, damping=0.0)
    c, s = np.cos(turn), np.sin(turn)
    flat = np.array([[0.0, 0.0], [1.0, 0.0], corner]) @ [[c, s], [-s, c]]
    membrane = Membrane.build(fabric, np.array([0]), flat[None])
    strain_of = strain_matrix(membrane)
    c11, c22, c12, c66 = fabric.stiffness
    moduli = np.array([[c11, c12, 0.0], [c12, c22, 0.0], [0.0, 0.0, c66]])
    stiffness = membrane.volume[0] * strain_of.T @ moduli @ strain_of
    exact = 2.0 / np.sqrt(np.linalg.eigvalsh(stiffness).max() / (membrane.mass[0] / 3.0))
    assert membrane.squared_rate[0] == pytest.approx(exact**-2, rel=1e-9)


@given(corner=st.tuples(st.floats(0.2, 0.8), st.floats(0.3, 1.5)), damping=st.floats(0.0, 1.0))
def test_a_damped_element_alone_is_stable_at_its_step_and_not_far_beyond(corner, damping):
    """Spectral radius of a step with damping taken from the last half step: v += dt a(x, v), x += dt v."""
    fabric = LinearFabric(800.0, 3e-4, 4e8, 4e8, 0.3, 4e8 / 2.6, compression=True, damping=damping)
    membrane = Membrane.build(fabric, np.array([0]), np.array([[[0.0, 0.0], [1.0, 0.0], corner]]))
    strain_of, mass = strain_matrix(membrane), membrane.mass[0] / 3.0
    c11, c22, c12, c66 = fabric.stiffness
    moduli = np.array([[c11, c12, 0.0], [c12, c22, 0.0], [0.0, 0.0, c66]])
    stiffness = membrane.volume[0] * strain_of.T @ moduli @ strain_of / mass
    drag = membrane.viscosity[0] * membrane.volume[0] * strain_of.T @ np.diag([1.0, 1.0, 0.5]) @ strain_of / mass
    same = np.eye(6)

    def radius(dt):
        velocity = np.hstack([-dt * stiffness, same - dt * drag])
        return np.abs(np.linalg.eigvals(np.vstack([np.hstack([same, 0 * same]) + dt * velocity, velocity]))).max()

    dt = 1.0 / np.sqrt(membrane.squared_rate[0])
    assert radius(0.999 * dt) <= 1.0 + 1e-6
    assert radius(1.25 * dt) > 1.0 + 1e-3


def test_mass_and_stretch():
    membrane = patch(KEEP)
    area = 0.5 * np.linalg.det([FLAT[2] - FLAT[0], FLAT[3] - FLAT[1]])  # of its diagonals
    assert membrane.mass.sum() == pytest.approx(area * 3e-4 * 800.0, rel=1e-14)
    assert FABRICS[PRINCIPAL].is_isotropic
    assert not FABRICS[YARN].is_isotropic


def test_a_flat_triangle_without_area_is_refused():
    flat = FLAT[TRIANGLES].copy()
    flat[2, 2] = 0.5 * (flat[2, 0] + flat[2, 1])
    with pytest.raises(InputError, match="E-GEO-004") as caught:
        Membrane.build(FABRICS[KEEP], np.arange(10, 14), flat)
    assert "triangle 12" in caught.value.where
