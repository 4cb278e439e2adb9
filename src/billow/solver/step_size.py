"""How long the next steps are: no longer than is stable, and shorter while the scheme loses energy (docs/theory.md,
Length of a step).

What a step loses by its error grows with its length cubed. Of all ways to lose a given energy in a run, the one with
the fewest steps is that of steps that each lose the same.
"""

from __future__ import annotations

import math

from billow.solver.model import Model, State

LOSS = 0.01
"""What all steps together would lose, of the largest energy so far, if each lost as much as it may: where the verdict
of a run begins to doubt it. Most steps are stable just so, and lose next to nothing."""

SHORTEST = 0.7
"""Of the stable step: energy that is lost for other reasons must not make steps ever shorter."""

FEWEST = 64
"""Steps over which a loss is measured; over fewer, energy that swings from step to step hides it."""


def stable_dt(model: Model, state: State) -> float:
    """Largest step [s] that is stable now, or the share of it that is chosen; the gas takes that or less."""
    return model.gas.stable_dt(state.gas, state.pace.share * _structure_dt(model, state))


def look_back(model: Model, state: State, end: float) -> None:
    """Between two steps: choose the share of the stable step by what the last steps have lost. end: of the run [s].

    What a stable step would lose is taken from what these lost; while losses fade, half of what was seen before counts.
    """
    pace, ledger = state.pace, state.ledger
    steps, stable = state.step - pace.step, _structure_dt(model, state)
    if steps < FEWEST or not math.isfinite(stable):
        return
    lost = abs(ledger.residual - pace.residual) / steps
    pace.lost = max(lost * (stable / state.dt) ** 3, 0.5 * pace.lost)
    allowed = LOSS * ledger.largest_energy * stable / end
    pace.share = min(1.0, max(SHORTEST, (allowed / pace.lost) ** (1.0 / 3.0))) if pace.lost > 0.0 else 1.0
    pace.step, pace.residual = state.step, ledger.residual


def _structure_dt(model: Model, state: State) -> float:
    """Largest step [s] that all but the gas tolerates: squared frequencies of fabric and straps, which act on the same
    nodes, add; contact sets no limit."""
    squared = model.fabric.squared_rate(state.fabric) + model.rate_of_straps
    return squared**-0.5 if squared > 0.0 else math.inf
