"""A run uses all its threads where they are faster, and one where they are not."""

import numba
import pytest

from billow.solver.team import PERIOD, TRIAL, Team


@pytest.fixture(autouse=True)
def two_threads():
    before = numba.get_num_threads()
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread")
    numba.set_num_threads(2)
    yield
    numba.set_num_threads(before)


def threads_of(steps, cost):
    """Threads of each step on a machine where a step takes cost(step, threads): time and processor time [s]."""
    now, used = [0.0, 0.0], []
    with Team(lambda: (now[0], now[1])) as team:
        for k in range(steps):

            def step(k=k):
                used.append(numba.get_num_threads())
                for clock, took in enumerate(cost(k, used[-1])):
                    now[clock] += took

            team.take(step)
    assert numba.get_num_threads() == 2
    return used


def idle(k, threads):
    return 1.0 / threads, 1.3 if threads > 1 else 1.0


def crowded(k, threads):
    return 1.0 * threads, 2.0 if threads > 1 else 1.0


def test_the_right_number_of_threads_is_used_after_a_trial():
    assert set(threads_of(200, idle)[2 * TRIAL :]) == {2}
    assert set(threads_of(200, crowded)[2 * TRIAL :]) == {1}
    assert set(threads_of(200, lambda k, threads: (idle(k, threads)[0], crowded(k, threads)[1]))[2 * TRIAL :]) == {1}


def test_a_core_that_is_free_again_is_used_after_the_next_trial():
    used = threads_of(2 * PERIOD, lambda k, threads: (crowded if k < PERIOD else idle)(k, threads))
    assert set(used[2 * TRIAL : PERIOD]) == {1}
    assert set(used[PERIOD + 2 * TRIAL :]) == {2}


def test_a_core_that_is_taken_is_left_before_the_next_trial():
    used = threads_of(PERIOD, lambda k, threads: (idle if k < 300 else crowded)(k, threads))
    assert set(used[2 * TRIAL : 300]) == {2}
    assert set(used[300 + 2 * TRIAL :]) == {1}


def test_the_threads_are_given_back_when_a_step_fails():
    def fail():
        raise ValueError("a step")

    with Team() as team:
        for _ in range(TRIAL + 1):
            team.take(lambda: None)
        assert numba.get_num_threads() == 1
        with pytest.raises(ValueError, match="a step"):
            team.take(fail)
    assert numba.get_num_threads() == 2
