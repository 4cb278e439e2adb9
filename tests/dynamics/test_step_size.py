"""Steps are as long as is stable, and shorter while the scheme loses energy."""

from __future__ import annotations

import pytest
from free_scene import free_model
from hypothesis import given
from hypothesis import strategies as st

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.solver import step_size
from billow.solver.model import Pace, start_state
from billow.solver.run import run
from billow.solver.step_size import FEWEST, LOSS, SHORTEST, look_back, stable_dt

MODEL = free_model()
STABLE, END = stable_dt(MODEL, start_state(MODEL)), 0.04


def after(lost: float, steps: int, largest: float = 10.0, pace: Pace | None = None, used: float = 1.0):
    """A state that has lost energy [J] in some steps, a part `used` of the stable one each, looked back on."""
    state = start_state(MODEL)
    state.pace, state.dt = pace or Pace(), used * STABLE
    state.step = state.pace.step + steps
    state.ledger.residual, state.ledger.largest_energy = state.pace.residual - lost, largest
    look_back(MODEL, state, END)
    return state.pace


def test_every_step_loses_the_same():
    """The error of a step grows with its length cubed: with the share chosen, each loses what it may."""
    allowed = LOSS * 10.0 * STABLE / END
    for times in (1.5, 2.0, 2.5):
        pace = after(times * allowed * FEWEST, FEWEST)
        assert times * allowed * pace.share**3 == pytest.approx(allowed, rel=1e-12)


def test_what_short_steps_lose_tells_what_stable_ones_would():
    """Also where it was the gas, or the user, that made them short."""
    allowed = LOSS * 10.0 * STABLE / END
    pace = after(2.0 * 0.3**3 * allowed * FEWEST, FEWEST, used=0.3)
    assert pace.share == pytest.approx(0.5 ** (1.0 / 3.0), rel=1e-9)


@given(
    lost=st.floats(-1e6, 1e6),
    steps=st.integers(0, 10_000),
    largest=st.floats(0.0, 1e6),
    share=st.floats(SHORTEST, 1.0),
)
def test_a_step_is_never_longer_than_stable_nor_shorter_than_it_must(lost, steps, largest, share):
    assert SHORTEST <= after(lost, steps, largest, Pace(share=share)).share <= 1.0


def test_a_step_is_long_again_soon_after_losses_end():
    pace = after(0.05, FEWEST)
    assert pace.share == SHORTEST
    for _ in range(20):  # what was seen last counts half as much each time
        pace = after(0.0, FEWEST, pace=pace)
    assert pace.share == 1.0


def test_nothing_is_judged_by_few_steps():
    assert after(1.0, FEWEST - 1).share == 1.0


def test_a_bag_that_snaps_open_loses_less_for_little_time(monkeypatch):
    """Of a driver bag that is filled: against the stable step all the time, and the shortest."""
    case = Case.from_dict({"bag": {"element_size": 0.03}, "run": {"end_time": 0.03, "frames": 30}})

    def steps_and_loss(allowed: float) -> tuple[int, float]:
        monkeypatch.setattr(step_size, "LOSS", allowed)
        state = run(build_model(case), build_schedule(case.run))
        return state.step, state.ledger.relative_error

    (steps, loss), (fewest, largest), (most, _) = map(steps_and_loss, (LOSS, 1.0, 0.0))
    assert loss < 0.8 * largest
    assert steps - fewest < 0.5 * (most - fewest)
    assert loss < 0.01
