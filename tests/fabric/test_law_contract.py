"""What every fabric law promises (billow.parts.fabric.membrane), checked for every law there is.

A new law joins by a line in `LAWS`.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from cloth import FABRICS, FLAT, TRIANGLES, corner_forces, shaken
from curves import CURVE_FABRICS, first_time, owed, strained_further
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.parts.fabric.fabric import STEP_FACTOR
from billow.parts.fabric.linear_law import KEEP, PRINCIPAL, YARN, LinearFabric, Liner
from billow.parts.fabric.membrane import ENERGY, HYSTERESIS, POWER, SQUARED_RATE, Membrane

LINED = LinearFabric(800.0, 3e-4, 0.4e9, 0.3e9, 0.25, 2e7, False, 0.05, Liner(0.03, 0.05e9, 0.3))
LAWS = {
    "linear, compression": FABRICS[KEEP],
    "linear, tension field": FABRICS[PRINCIPAL],
    "linear, yarns": FABRICS[YARN],
    "linear, liner": LINED,
    **CURVE_FABRICS,
}
"""Name -> fabric."""

WITHOUT_RATE = [name for name in LAWS if name not in ("curves", "curves, oblique")]
laws = pytest.mark.parametrize("name", list(LAWS))


class Patch:
    """Four triangles of one fabric, with their history."""

    def __init__(self, name: str, history: np.ndarray | None = None):
        self.membrane = Membrane.build(LAWS[name], np.arange(4), FLAT[TRIANGLES])
        self.history = self.membrane.fresh_history() if history is None else history.copy()

    def feel(self, positions, velocities=None):
        """Corner forces [N] and sums; brings the history up to date."""
        velocities = np.zeros_like(positions) if velocities is None else velocities
        return corner_forces(self.membrane, TRIANGLES, positions, velocities, self.history)


def flat_patch(gradient) -> np.ndarray:
    """The patch under a deformation gradient (3, 2), [m], (5, 3)."""
    return FLAT @ np.asarray(gradient).T


@laws
@given(seed=st.integers(0, 10_000))
def test_rigid_motion_changes_nothing(name, seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved = Patch(name).feel(flat_patch(turn[:, :2]) + rng.normal(size=3))[0]
    # E t h = 400 N; strain of a turned patch is rounding.
    assert np.abs(moved).max() <= 1e-10 * 400.0

    positions, velocities = shaken(seed, 0.1), rng.normal(size=(5, 3))
    spin = rng.normal(size=(3, 3))
    spin -= spin.T
    turned = positions @ turn.T
    here, sums = Patch(name).feel(positions, velocities)
    there, sums_there = Patch(name).feel(turned + 0.3, velocities @ turn.T + turned @ spin + 7.0)
    assert there == pytest.approx(here @ turn.T, abs=1e-9 * np.abs(here).max())
    assert sums_there == pytest.approx(sums, rel=1e-8, abs=1e-12)


@laws
@given(seed=st.integers(0, 10_000), strain=st.sampled_from([0.01, 0.1, 1.0]), speed=st.sampled_from([0.0, 1.0, 300.0]))
def test_a_triangle_is_without_net_force_and_torque(name, seed, strain, speed):
    positions = shaken(seed, strain)
    velocities = speed * np.random.default_rng(seed + 1).normal(size=(5, 3))
    force, sums = Patch(name).feel(positions, velocities)
    scale = np.abs(force).max() + 1e-300
    assert np.abs(force.sum(axis=1)).max() <= 1e-14 * scale
    torque = np.cross(positions[TRIANGLES] - positions.mean(axis=0), force).sum(axis=1)
    assert np.abs(torque).max() <= 1e-13 * scale * np.ptp(positions, axis=0).max()
    assert sums[ENERGY] >= 0.0
    assert sums[POWER] >= 0.0
    assert sums[HYSTERESIS] >= -1e-15 * sums[ENERGY]


@laws
@pytest.mark.parametrize("remembered", [False, True], ids=["on the way up", "strained further before"])
@pytest.mark.parametrize("strain", [0.02, 0.1, 0.5])
def test_power_is_stored_or_turned_to_heat(name, remembered, strain):
    """Corner forces times velocities against the rate of what is stored and what was turned to heat, to 1e-8.

    Central differences over d = 2e-7 of an edge: rounding 1e-16/d of the energy over the work of a strain of one, a
    tenth of that. Where a curve has a kink within d, half the jump of its slope times d over the strain is left, up to
    1e-6; that is allowed for one place in ten.
    """
    errors = []
    for seed in range(30):
        positions, velocities = shaken(seed, strain), np.random.default_rng(seed).normal(size=(5, 3))
        patch = Patch(name)
        patch.feel(positions, velocities)
        history = (strained_further if remembered else first_time)(LAWS[name], patch.history)
        patch.history = history.copy()
        force, sums = patch.feel(positions, velocities)
        assert not remembered or (patch.history[1:] == history[1:]).all()
        d, rate = 1e-9, 0.0
        for sign in (1.0, -1.0):
            moved = Patch(name, history)
            _, there = moved.feel(positions + sign * d * velocities, velocities)
            booked = there[ENERGY] + there[HYSTERESIS] - owed(moved.membrane, moved.history)
            rate += sign * booked / (2.0 * d)
        each = force * velocities[TRIANGLES]
        assert np.abs(force).max() > 0.01  # something pulls
        errors.append(abs(each.sum() + rate + sums[POWER]) / np.abs(each).sum())
    assert np.quantile(errors, 0.9) <= 1e-8
    assert max(errors) <= 1e-6


angle = st.floats(0.0, 6.3)


def path(centre, radii, phases, turns, points):
    """A closed way through deformation gradients, (points + 1, 3, 2): loads, unloads and reloads `turns` times."""
    phase = 2.0 * np.pi * np.arange(points + 1) / points
    swing = np.stack([np.sin(k * phase + p) - np.sin(p) for k, p in zip(turns, phases, strict=True)], axis=1)
    values = np.asarray(centre) + swing * radii
    gradient = np.zeros((points + 1, 3, 2))
    gradient[:, 0, 0], gradient[:, 1, 1] = values[:, 0], values[:, 1]
    gradient[:, 0, 1], gradient[:, 1, 0] = values[:, 2], values[:, 3]
    return gradient


@pytest.mark.parametrize("name", WITHOUT_RATE)
@settings(max_examples=25)
@given(
    centre=st.tuples(st.floats(0.97, 1.08), st.floats(0.97, 1.08), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    radii=st.tuples(st.floats(0.0, 0.06), st.floats(0.0, 0.06), st.floats(0.0, 0.2), st.floats(0.0, 0.2)),
    phases=st.tuples(angle, angle, angle, angle),
    turns=st.tuples(*[st.sampled_from([1, 2, 3])] * 4),
)
def test_no_loop_creates_energy_and_all_of_it_is_booked(name, centre, radii, phases, turns):
    """Work of moving the corners along closed ways in 300 steps, by the midpoint rule. It and the trapezoidal rule are
    of second order and err to opposite sides, at kinks too: the sum of what sets them apart bounds the error."""
    patch = Patch(name)
    way = path(centre, radii, phases, turns, 300)
    force, sums = patch.feel(flat_patch(way[0]))
    begun, heat, work, error = sums[ENERGY] + sums[HYSTERESIS], sums[HYSTERESIS], 0.0, 1e-9
    for before, after in itertools.pairwise(way):
        moved, last = (flat_patch(after) - flat_patch(before))[TRIANGLES], force
        middle, _ = patch.feel(flat_patch(0.5 * (before + after)))
        force, sums = patch.feel(flat_patch(after))
        assert sums[HYSTERESIS] >= heat - 1e-12  # heat never comes back
        heat, work = sums[HYSTERESIS], work - float(np.sum(middle * moved))
        error += abs(float(np.sum((middle - 0.5 * (last + force)) * moved)))
    assert sums[ENERGY] + sums[HYSTERESIS] - begun == pytest.approx(work, abs=error)
    assert work >= -error


SHAPES = {
    "inverted": [[1.0, 0.0], [0.0, -1.0], [0.0, 0.0]],
    "on a line": [[1.0, 1.0], [0.0, 0.0], [0.0, 0.0]],
    "on a line, against each other": [[1.0, -1.0], [0.0, 0.0], [0.0, 0.0]],
    "warp without length": [[0.0, 0.0], [0.0, 1.0], [0.0, 0.0]],
    "both without length": [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
    "stretched on a line": [[1.2, 1.2], [0.0, 0.0], [0.0, 0.0]],
    "crumpled": [[0.01, 0.002], [-0.003, 1e-9], [0.0, 0.005]],
}


@laws
@pytest.mark.parametrize("shape", list(SHAPES))
def test_forces_are_finite_and_continuous_where_triangles_collapse(name, shape):
    gradient = np.array(SHAPES[shape])
    rng = np.random.default_rng(1)
    here = Patch(name).feel(flat_patch(gradient))[0]
    assert np.isfinite(here).all()
    for size in (1e-4, 1e-7, 1e-10):
        for _ in range(10):
            there = Patch(name).feel(flat_patch(gradient + size * rng.normal(size=(3, 2))))[0]
            # E t h = 400 N bounds the stiffness times h; shear on a line has a large factor, but has one.
            assert np.abs(there - here).max() <= 400.0 * 100.0 * size


@laws
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_show_in_the_sums(name, bad):
    positions = shaken(0, 0.1)
    positions[4, 1] = bad
    with np.errstate(all="ignore"):
        force, sums = Patch(name).feel(positions, np.ones((5, 3)))
    assert not np.isfinite(force).all()
    assert not np.isfinite(sums[[ENERGY, POWER]]).all()


@laws
@given(seed=st.integers(0, 10_000))
def test_evaluating_twice_changes_nothing(name, seed):
    patch, positions = Patch(name), shaken(seed, 0.2)
    first, sums = patch.feel(positions)
    history = patch.history.copy()
    second, again = patch.feel(positions)
    assert second == pytest.approx(first, rel=1e-12, abs=1e-12 * np.abs(first).max())
    assert again == pytest.approx(sums, rel=1e-11, abs=1e-16)
    assert patch.history == pytest.approx(history, rel=1e-12)


@laws
@pytest.mark.parametrize("shares", ["equal", "uneven"])
def test_the_stable_step_is_below_the_exact_bound(name, shares):
    """2/omega of lumped masses from eigenvalues of the tangent, by differences of forces, in many states: strained,
    sheared, slack, on the way up and back; with thirds of the mass at the corners, and with more and less."""
    rng = np.random.default_rng(5)
    fabric = LAWS[name]
    for trial in range(40):
        flat = np.array([[0.0, 0.0], [0.01, 0.0], [rng.uniform(0.002, 0.008), rng.uniform(0.003, 0.015)]])
        turn = rng.uniform(0.0, np.pi)
        flat = flat @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        membrane = Membrane.build(fabric, np.array([0]), flat[None])
        if shares == "uneven":
            membrane = membrane.sharing(np.exp(rng.uniform(-1.5, 1.5, (1, 3))))
        shear = rng.uniform(-0.5, 0.5)
        gradient = np.array([[rng.uniform(0.8, 1.2), shear], [rng.uniform(-0.3, 0.3), rng.uniform(0.8, 1.2)], [0, 0]])
        positions = flat @ gradient.T
        history = membrane.fresh_history()

        def feel(x, history, membrane=membrane):
            force, sums = corner_forces(membrane, np.array([[0, 1, 2]], np.uint32), x, np.zeros((3, 3)), history)
            return force.ravel(), sums

        if trial % 2:
            feel(rng.uniform(1.0, 1.3) * positions, history)
        _, sums = feel(positions, history.copy())
        step, tangent = 1e-7, np.zeros((9, 9))
        for k in range(9):
            up, down = positions.copy().ravel(), positions.copy().ravel()
            up[k] += step
            down[k] -= step
            change = feel(up.reshape(3, 3), history.copy())[0] - feel(down.reshape(3, 3), history.copy())[0]
            tangent[:, k] = -change / (2.0 * step)
        root = np.repeat(np.sqrt(3.0 * membrane.lightness[0] / membrane.mass[0]), 3)
        largest = np.linalg.eigvalsh(root[:, None] * 0.5 * (tangent + tangent.T) * root).max()
        exact = 2.0 / np.sqrt(max(largest, 1e-300))
        assert STEP_FACTOR / np.sqrt(sums[SQUARED_RATE]) <= exact
