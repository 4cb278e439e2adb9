"""The time loop: steps split evenly up to each output time, so that there are no sliver steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

from billow.solver.guards import LARGEST_GAIN, check_state, check_step_size
from billow.solver.model import Model, State, start_state
from billow.solver.step import advance, first_forces
from billow.solver.step_size import look_back, stable_dt
from billow.solver.team import Team


@dataclass(frozen=True)
class Schedule:
    """end [s]; frames: number of output frames after the start; histories_per_frame: history rows between two frames;
    dt_scale: fraction of the step that `step_size` gives [-]. largest_gain: energy created, of the largest energy so
    far [-], that stops the run."""

    end: float
    frames: int
    histories_per_frame: int
    dt_scale: float = 1.0
    largest_gain: float = LARGEST_GAIN


class Recorder:
    """Who listens to a run; this one hears everything and keeps nothing. The solver knows no file formats."""

    def history(self, model: Model, state: State) -> None:
        """Called at time zero and after every history interval."""

    def frame(self, model: Model, state: State) -> None:
        """Called at time zero and after every frame interval."""

    def step(self, model: Model, state: State) -> None:
        """Called after every step; may save the state, or raise to stop the run."""


SILENT = Recorder()


def run(model: Model, schedule: Schedule, recorder: Recorder = SILENT, state: State | None = None) -> State:
    """Run from the start, or on from a state between two steps, to the end; returns the last state.

    A run that continues from a saved state gives the same bits as one that never stopped.
    Raises NumericalStop if the run becomes meaningless; the recorder then has everything up to that moment.
    """
    if state is None:
        state = begin(model, schedule)
        recorder.history(model, state)
        recorder.frame(model, state)
    with Team() as team:
        _go_on(model, schedule, recorder, state, team)
    return state


def _go_on(model: Model, schedule: Schedule, recorder: Recorder, state: State, team: Team) -> None:
    """From a state between two steps to the end."""
    model.work.loads.open()  # a run before this one may have ended within a step
    intervals = schedule.frames * schedule.histories_per_frame
    while state.interval < intervals:
        target = schedule.end * (state.interval + 1) / intervals
        if state.steps_left == 0:  # split the way to the target into equal steps within the stable one
            look_back(model, state, schedule.end)
            limit = schedule.dt_scale * stable_dt(model, state)
            check_step_size(state, limit)
            state.steps_left = math.ceil((target - state.time) / limit)
            state.dt = (target - state.time) / state.steps_left
        while state.steps_left > 0:
            team.take(lambda: advance(model, state, state.dt))
            state.steps_left -= 1
            check_state(model, state, schedule.largest_gain)
            if state.steps_left > 0:
                recorder.step(model, state)
        state.time = target  # the sum of the steps differs in the last digit
        state.interval += 1
        recorder.history(model, state)
        if state.interval % schedule.histories_per_frame == 0:
            recorder.frame(model, state)
        recorder.step(model, state)


def begin(model: Model, schedule: Schedule) -> State:
    """State at time zero with its forces and energies."""
    state = start_state(model)
    first_forces(model, state)
    state.first_dt = state.dt = schedule.dt_scale * stable_dt(model, state)
    return state
