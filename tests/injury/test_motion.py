"""Injury metrics from velocities, and of a run."""

from types import SimpleNamespace

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.injury.criteria import GRAVITY, assess, assess_run, mean_acceleration
from billow.results.histories import History

TIMES = np.arange(501) * 1e-4


def half_sine(height, length):
    """Velocity [m/s] after a half-sine acceleration of height [m/s^2] from 10 ms on."""
    phase = np.clip((TIMES - 0.010) / length, 0.0, 1.0)
    return height * length / np.pi * (1.0 - np.cos(np.pi * phase))


def histories(velocity):
    columns = {"time [s]": TIMES, "head_centre_x [m]": 0.0 * TIMES}
    return History(columns | {f"head_velocity_{a} [m/s]": velocity[:, k] for k, a in enumerate("xyz")})


def test_half_sine_pulse_in_any_direction():
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    injury = assess(TIMES, half_sine(80.0 * GRAVITY, 20e-3)[:, None] * direction)
    # The pulse is slow against CFC 1000 and loses less than 1e-3. Its best window, 13.4 ms, fits into 15 and 36 ms.
    assert injury.hic36.value == pytest.approx(0.41465 * 80.0**2.5 * 20e-3, rel=2e-3)
    assert injury.hic15.value == pytest.approx(injury.hic36.value, rel=1e-9)
    assert injury.peak == pytest.approx(80.0 * GRAVITY, rel=1e-3)
    assert injury.peak_time == pytest.approx(0.020, abs=1e-4)
    assert injury.clip == pytest.approx(80.0 * GRAVITY * np.cos(np.pi * 3.0 / 40.0), rel=2e-3)
    assert injury.contiguous_clip == pytest.approx(injury.clip, rel=1e-6)


def test_mean_acceleration_keeps_the_velocity():
    velocity = np.random.default_rng(1).standard_normal((501, 3)).cumsum(axis=0)
    middles, acceleration = mean_acceleration(TIMES, velocity)
    assert middles[0] == pytest.approx(0.5e-4)
    assert acceleration.sum(axis=0) * 1e-4 == pytest.approx(velocity[-1] - velocity[0], rel=1e-9)


def test_every_free_obstacle_of_a_run_and_none():
    velocity = half_sine(500.0, 10e-3)[:, None] * np.array([0.0, 0.0, 1.0])
    curves = histories(velocity)
    run = SimpleNamespace(histories=curves, free_obstacles=("head",), body=curves.of, folder="RUN")
    assert assess_run(run)["head"].peak == pytest.approx(500.0, rel=3e-3)
    with pytest.raises(InputError, match="E-INJ-005"):
        assess_run(SimpleNamespace(histories=curves, free_obstacles=(), folder="RUN"))


def test_coarse_histories_are_refused():
    with pytest.raises(InputError, match="E-INJ-003"):
        assess(TIMES[::2], np.zeros((251, 3)))
