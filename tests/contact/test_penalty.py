"""One node against one surface: energy is neither made nor lost, nothing sticks, friction keeps to Coulomb."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.parts.bodies.penalty import contact_force, normal_contact

MASS, STIFFNESS = 2e-5, 2e5
OMEGA = np.sqrt(STIFFNESS / MASS)
# In units of the stability limit 2/omega of sampled penalty forces: from far below to ten times it.
steps = st.floats(-4.0, 1.0).map(lambda power: 2.0 / OMEGA * 10.0**power)
depths = st.one_of(st.just(0.0), st.floats(-2e-3, 2e-3), st.floats(-1e-9, 1e-9))
speeds = st.one_of(st.just(0.0), st.floats(-100.0, 100.0))


def spring(depth):
    return 0.5 * STIFFNESS * max(0.0, depth) ** 2


@settings(max_examples=400)
@given(depth=depths, closing=speeds, dt=steps)
def test_undamped_contact_keeps_energy_whatever_the_step(depth, closing, dt):
    force, after = normal_contact(depth, closing, STIFFNESS, 1.0 / MASS, 0.0, dt)
    closing_after = closing - dt * force / MASS
    before = 0.5 * MASS * closing**2 + spring(depth)
    assert 0.5 * MASS * closing_after**2 + spring(after) == pytest.approx(before, rel=1e-9, abs=1e-25)
    # Position and velocity tell the same story.
    assert after == pytest.approx(depth + 0.5 * dt * (closing + closing_after), rel=1e-9, abs=1e-15)
    assert force >= 0.0
    if depth <= 0.0 and after <= 0.0:
        assert force == 0.0


@given(closing=st.floats(0.01, 100.0), gap=st.floats(0.0, 1e-3), dt=steps)
def test_a_node_leaves_as_fast_as_it_came(closing, gap, dt):
    depth, speed, steps_taken = -gap, closing, 0
    while not (depth <= 0.0 and speed < 0.0):
        force, depth = normal_contact(depth, speed, STIFFNESS, 1.0 / MASS, 0.0, dt)
        speed -= dt * force / MASS
        steps_taken += 1
        if steps_taken > 2000:  # a step so small that the bounce takes longer than this test: still under way
            break
    else:
        assert speed == pytest.approx(-closing, rel=1e-8)


@settings(max_examples=400)
@given(depth=depths, closing=speeds, dt=steps, damping=st.floats(0.0, 1.0))
def test_damping_takes_energy_and_never_holds_back(depth, closing, dt, damping):
    force, after = normal_contact(depth, closing, STIFFNESS, 1.0 / MASS, damping, dt)
    before = 0.5 * MASS * closing**2 + spring(depth)
    left = 0.5 * MASS * (closing - dt * force / MASS) ** 2 + spring(after)
    assert force >= 0.0
    assert left <= before * (1.0 + 1e-9) + 1e-25


def test_a_fixed_node_is_pushed_too():
    """It does not move, but the obstacle must feel it."""
    force, after = normal_contact(1e-3, 0.0, STIFFNESS, 0.0, 0.1, 1e-6)
    assert (force, after) == (pytest.approx(STIFFNESS * 1e-3, rel=1e-14), 1e-3)


directions = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(lambda v: np.dot(v, v) > 0.01)
tangents = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))


@settings(max_examples=400)
@given(
    depth=depths, velocity=st.tuples(speeds, speeds, speeds), normal=directions, offset=tangents, dt=steps,
    damping=st.sampled_from([0.0, 0.1, 1.0]), friction=st.sampled_from([0.0, 0.2, 1.5]),
)  # fmt: skip
def test_a_contact_step_closes_its_books(depth, velocity, normal, offset, dt, damping, friction):
    """Kinetic energy, springs and what was dissipated add up; friction keeps to its limit and never drives."""
    n = np.array(normal) / np.linalg.norm(normal)
    side = np.cross(n, [1.0, 0.0, 0.0] if abs(n[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    # A sticking point that friction could hold at this depth.
    reach = friction * max(0.0, depth)
    stuck = reach * (offset[0] * side + offset[1] * np.cross(n, side)) / np.sqrt(2.0)
    velocity = np.array(velocity)
    answer = contact_force(depth, *n, *velocity, STIFFNESS, 1.0 / MASS, damping, friction, *stuck, dt)
    force, stuck_after, (stored, dissipated, after) = np.array(answer[:3]), np.array(answer[3:6]), answer[6:]
    normal_part = force @ n
    sliding = force - normal_part * n
    scale = 0.5 * MASS * velocity @ velocity + spring(depth) + 1e-25
    assert normal_part >= -1e-9 * np.linalg.norm(force)
    assert np.linalg.norm(sliding) <= friction * normal_part * (1.0 + 1e-9) + 1e-9 * np.linalg.norm(force)
    before = 0.5 * MASS * velocity @ velocity + spring(depth) + 0.5 * STIFFNESS * stuck @ stuck
    moved = velocity + dt * force / MASS
    assert 0.5 * MASS * moved @ moved + stored + dissipated == pytest.approx(before, abs=1e-8 * scale)
    assert dissipated >= -1e-9 * scale
    assert stored == pytest.approx(spring(after) + 0.5 * STIFFNESS * stuck_after @ stuck_after, abs=1e-9 * scale)


@pytest.mark.parametrize("share", [1e-3, 0.03, 1.0])
def test_the_books_close_over_a_damped_rubbing_bounce(share):
    """From first touch until the node is free again, at steps from far below to the stability limit."""
    dt, depth, stuck, given_off = share * 2.0 / OMEGA, -1e-6, np.zeros(3), 0.0
    velocity = np.array([3.0, 0.0, -5.0])
    start = 0.5 * MASS * velocity @ velocity
    for _ in range(100_000):
        answer = contact_force(depth, 0.0, 0.0, 1.0, *velocity, STIFFNESS, 1.0 / MASS, 0.1, 0.3, *stuck, dt)
        velocity = velocity + dt / MASS * np.array(answer[:3])
        stuck, stored, depth = np.array(answer[3:6]), answer[6], answer[8]
        given_off += answer[7]
        assert 0.5 * MASS * velocity @ velocity + stored + given_off == pytest.approx(start, rel=1e-10)
        if velocity[2] > 0.0 and depth < -1e-5:
            break
    assert stored == 0.0
    assert 0.0 < velocity[2] < 5.0
    assert 0.0 < velocity[0] < 3.0 - 0.3 * 5.0  # at least the impulse of stopping it, times the coefficient


def test_friction_holds_what_it_can_hold():
    """A node pressed with 1 N and pulled sideways with 0.19 N stays; with 0.21 N at a coefficient of 0.2 it slides."""
    dt = 0.5 / OMEGA
    ends = []
    for pull in (0.19, 0.21):
        depth, stuck, velocity, x = 1.0 / STIFFNESS, np.zeros(3), np.zeros(3), 0.0
        for _ in range(4000):
            velocity = velocity + dt / MASS * np.array([pull, 0.0, -1.0])
            answer = contact_force(depth, 0.0, 0.0, 1.0, *velocity, STIFFNESS, 1.0 / MASS, 0.5, 0.2, *stuck, dt)
            x += dt * (velocity[0] + 0.5 * dt / MASS * answer[0])
            velocity = velocity + dt / MASS * np.array(answer[:3])
            stuck, depth = np.array(answer[3:6]), answer[8]
        ends.append(x)
    assert ends[0] < 1e-5  # the spring of the sticking point, 1e-6 m, and a little slip while it is loaded
    assert ends[1] == pytest.approx(0.5 * 0.01 / MASS * (4000 * dt) ** 2, rel=0.05)
