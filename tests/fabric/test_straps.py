"""Straps: bars that pull and never push."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.fabric.straps import Straps, add_strap_forces


def strap(viscosity=0.0):
    """Two bars of 0.3 m in a row over three nodes."""
    return Straps(
        bars=np.array([[0, 1], [1, 2]]),
        length=np.full(2, 0.3),
        stiffness=np.full(2, 5000.0),
        viscosity=np.full(2, viscosity),
        mass=np.full(2, 0.002),
        strap=np.zeros(2, np.int64),
    )


def pull(straps, positions, velocities=None):
    force, bar = np.zeros((3, 3)), np.zeros((2, 3))
    add_strap_forces(straps, positions, np.zeros((3, 3)) if velocities is None else velocities, force, bar)
    return force, bar


@given(seed=st.integers(0, 10_000), stretch=st.floats(0.8, 1.3), speed=st.sampled_from([0.0, 10.0, 1000.0]))
def test_a_strap_pulls_its_ends_together_and_never_pushes(seed, stretch, speed):
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(2, 3))
    way *= 0.3 * stretch / np.linalg.norm(way, axis=1)[:, None]
    positions = np.concatenate([[np.zeros(3)], np.cumsum(way, axis=0)])
    force, bar = pull(strap(3.0), positions, speed * rng.normal(size=(3, 3)))
    tension, energy, power = bar.T
    assert (tension >= 0.0).all()
    assert (energy >= 0.0).all()
    assert (power >= 0.0).all()
    assert np.abs(force.sum(axis=0)).max() <= 1e-12 * (tension.max() + 1.0)
    assert force[0] == pytest.approx(tension[0] * way[0] / np.linalg.norm(way[0]), abs=1e-9 * tension.max() + 1e-12)
    if stretch < 1.0 - 1e-9:
        assert not force.any()
    elif speed == 0.0:
        assert tension == pytest.approx(5000.0 * (stretch - 1.0), abs=1e-8)


def test_force_is_minus_the_gradient_of_the_energy():
    positions = np.array([[0.0, 0.0, 0.0], [0.31, 0.02, 0.01], [0.5, 0.26, -0.1]])
    force, bar = pull(strap(), positions)
    assert (bar[:, 0] > 0.0).all()
    for node, axis in np.ndindex(3, 3):
        step = np.zeros((3, 3))
        step[node, axis] = 1e-6
        gain = pull(strap(), positions + step)[1][:, 1].sum() - pull(strap(), positions - step)[1][:, 1].sum()
        assert force[node, axis] == pytest.approx(-gain / 2e-6, abs=1e-6 * np.abs(force).max())
