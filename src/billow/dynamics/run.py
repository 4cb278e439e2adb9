"""The time loop: steps split evenly up to each output time, so that there are no sliver steps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from billow.dynamics.forces import evaluate_forces
from billow.dynamics.guards import check_state, check_step_size
from billow.dynamics.model import Model, State, start_state
from billow.dynamics.step import advance, close_ledger, stable_dt


@dataclass(frozen=True)
class Schedule:
    """end [s]; frames: number of output frames after the start; histories_per_frame: history rows between two frames;
    dt_scale: fraction of the stable step that is used [-]."""

    end: float
    frames: int
    histories_per_frame: int
    dt_scale: float = 1.0


class Recorder(Protocol):
    """Who listens to a run. `dynamics` knows no file formats."""

    def history(self, model: Model, state: State, dt: float) -> None:
        """Called at time zero and after every history interval."""

    def frame(self, model: Model, state: State) -> None:
        """Called at time zero and after every frame interval."""


def run(model: Model, schedule: Schedule, recorder: Recorder) -> State:
    """Run from the start to the end; returns the last state.

    Raises NumericalStop if the run becomes meaningless; the recorder then has everything up to that moment.
    """
    state = start_state(model)
    evaluate_forces(model, state, 0.0, 0.0)
    close_ledger(model, state)
    intervals = schedule.frames * schedule.histories_per_frame
    first_dt = schedule.dt_scale * stable_dt(model, state)
    recorder.history(model, state, first_dt)
    recorder.frame(model, state)
    for k in range(intervals):
        target = schedule.end * (k + 1) / intervals
        span = target - state.time
        limit = schedule.dt_scale * stable_dt(model, state)
        check_step_size(state, limit, first_dt)
        steps = math.ceil(span / limit)
        dt = span / steps
        for _ in range(steps):
            advance(model, state, dt)
            check_state(model, state, dt)
        state.time = target
        recorder.history(model, state, dt)
        if (k + 1) % schedule.histories_per_frame == 0:
            recorder.frame(model, state)
    return state
