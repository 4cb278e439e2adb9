"""Straps: bars that pull and never push."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.apps.verification.scenes import disc, fabric_model, isotropic
from billow.case.bag.build_bag import build_straps, strap_line
from billow.case.bag.schema_bag import StrapCloth
from billow.parts.straps import ENERGY, LOST, TENSION, TORN, Straps, add_strap_forces
from billow.solver.run import Schedule, run


def strap(viscosity=0.0, failure=np.inf):
    """Two bars of 0.3 m in a row over three nodes."""
    return Straps(
        bars=np.array([[0, 1], [1, 2]]),
        length=np.full(2, 0.3),
        stiffness=np.full(2, 5000.0),
        viscosity=np.full(2, viscosity),
        mass=np.full(2, 0.002),
        strap=np.zeros(2, np.int64),
        failure=np.full(2, failure),
    )


def pull(straps, positions, velocities=None):
    force, bar = np.zeros((3, 3)), straps.start(None)
    add_strap_forces(straps, positions, np.zeros((3, 3)) if velocities is None else velocities, force, bar)
    return force, bar


@given(seed=st.integers(0, 10_000), stretch=st.floats(0.8, 1.3), speed=st.sampled_from([0.0, 10.0, 1000.0]))
def test_a_strap_pulls_its_ends_together_and_never_pushes(seed, stretch, speed):
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(2, 3))
    way *= 0.3 * stretch / np.linalg.norm(way, axis=1)[:, None]
    positions = np.concatenate([[np.zeros(3)], np.cumsum(way, axis=0)])
    force, bar = pull(strap(3.0), positions, speed * rng.normal(size=(3, 3)))
    tension, energy, power, elongation, *_ = bar.T
    assert elongation == pytest.approx(0.3 * (stretch - 1.0), abs=1e-12)
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


def test_a_bar_tears_once_and_loses_what_it_held():
    """5000 N per strain, 0.3 m: at 300 N the strain is 6 % and the energy 0.5 F^2 L / EA = 2.7 J."""
    torn, force = strap(failure=300.0), np.zeros((3, 3))
    bar = torn.start(None)
    for stretch, tension in ((1.05, 250.0), (1.0599, 299.5), (1.0601, 0.0), (1.2, 0.0), (1.05, 0.0)):
        force[:] = 0.0
        positions = 0.3 * stretch * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        add_strap_forces(torn, positions, np.zeros((3, 3)), force, bar)
        assert bar[:, TENSION] == pytest.approx(tension, rel=1e-9)
        assert force[0, 0] == pytest.approx(tension, rel=1e-9)
    assert (bar[:, TORN] == 1.0).all()
    assert not bar[:, ENERGY].any()
    assert bar[:, LOST] == pytest.approx(0.5 * 300.0**2 * 0.3 / 5000.0, rel=1e-2)


def cloth(**settings):
    shape = disc(0.2, 0.05)
    bars = np.array([[0, 9], [1, 8]])
    line = strap_line(StrapCloth(**settings), bars, shape.positions)
    apart = np.linalg.norm(shape.positions[bars[:, 0]] - shape.positions[bars[:, 1]], axis=1)
    fabric = isotropic(4e8, 0.2, 800.0, 3e-4, damping=0.05)
    return build_straps(dataclasses.replace(shape, straps=(line,)), fabric), apart


def test_a_strap_is_as_long_stiff_and_strong_as_its_cloth_says():
    straps, apart = cloth(width=0.06)
    assert straps.length == pytest.approx(apart, rel=1e-15)
    assert straps.stiffness.sum() == pytest.approx(4e8 * 3e-4 * 0.06, rel=1e-12)
    assert straps.mass.sum() == pytest.approx(800.0 * 3e-4 * 0.03 * apart.sum(), rel=1e-12)
    # xi rho c A l per rate of strain, as in a membrane.
    assert straps.viscosity == pytest.approx(0.05 * np.sqrt(4e8 * 800.0) * 3e-4 * 0.03 * apart, rel=1e-12)
    assert np.isinf(straps.failure).all()
    straps, apart = cloth(slack=0.05, stiffness=2e4, failure=3000.0)
    assert straps.length == pytest.approx(apart + 0.05, rel=1e-15)
    assert straps.stiffness == pytest.approx([1e4, 1e4])
    assert straps.failure == pytest.approx([1500.0, 1500.0])
    assert cloth(length=0.4)[0].length == pytest.approx([0.4, 0.4])


def test_the_energy_balance_closes_when_a_strap_tears():
    """A disc held at one side is thrown sideways; its strap holds, or tears: what it held is lost, and no more."""
    shape = disc(0.2, 0.05)
    bars = np.array([[0, len(shape.positions) - 1]])
    for failure in (np.inf, 5.0):
        model = fabric_model(
            dataclasses.replace(shape, fixed=np.arange(len(shape.positions)) < 6),
            isotropic(4e8, 0.2, 800.0, 3e-4),
            gravity=(0.0, 0.0, -9e3),
        )
        length = np.linalg.norm(shape.positions[bars[0, 0]] - shape.positions[bars[0, 1]])
        straps = Straps(
            bars,
            np.array([length]),
            np.array([2e3]),
            np.zeros(1),
            np.zeros(1),
            np.zeros(1, np.int64),
            np.array([failure]),
        )
        state = run(dataclasses.replace(model, straps=straps), Schedule(4e-3, 1, 20))
        assert (state.straps[0, TORN] == 1.0) == np.isfinite(failure)
        assert (state.ledger["hysteresis"] > 0.0) == np.isfinite(failure)
        assert abs(state.ledger.residual) < 2e-3 * state.ledger.largest_energy


@pytest.mark.parametrize("inverse_mass", [(1.0, 1.0, 1.0), (1.0, 50.0, 2.0), (0.0, 1.0, 0.0), (1.0, 0.0, 3.0)])
def test_the_step_of_straps_is_below_the_exact_bound_between_free_nodes_too(inverse_mass):
    """Stable up to 2/omega, omega^2 the largest eigenvalue of stiffness over mass, along a line."""
    straps, root = strap(), np.sqrt(inverse_mass)
    stiffness = np.zeros((3, 3))
    for (a, b), k in zip(straps.bars, straps.stiffness / straps.length, strict=True):
        stiffness[np.ix_([a, b], [a, b])] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    largest = np.linalg.eigvalsh(root[:, None] * stiffness * root).max()
    assert straps.squared_rate(np.array(inverse_mass)) >= 0.25 * largest / 0.9**2
