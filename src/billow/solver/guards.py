"""A run that has become meaningless is stopped, with the place and the likely cause.

The check of every step is a handful of scalars, because a bad number anywhere reaches the energy sums at once; only
when they trip is the first bad entity looked for.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.errors import NumericalStop
from billow.geometry.surface import area_vectors
from billow.solver.model import Model, State

SMALLEST_STEP = 1e-4
"""Of the first step."""

LARGEST_GAIN = 0.2
"""Of the largest energy so far."""

LARGE_ENERGY, SMALLEST_ENERGY = 1.0, 1e-9
"""Largest energies so far [J]: from the first on a gain is judged at once; between them only after FIRST_STEPS, because
in the first steps of a motion the error of the scheme is as large as the energy; below the second it is rounding."""

FIRST_STEPS = 1000


def check_state(model: Model, state: State) -> None:
    """Raises NumericalStop: E-NUM-001 non-finite, E-NUM-003 energy created, and what parts find.

    The gas, the first part, is asked first: what a chamber without volume does to pressures looks like anything else.
    """
    moment, ledger = state.moment, state.ledger
    (first, gas), *others = model.parts
    gas.guard(state.of(first), moment)
    if not math.isfinite(ledger.residual):
        raise _non_finite(model, state)
    floor = LARGE_ENERGY if state.step <= FIRST_STEPS else SMALLEST_ENERGY
    if ledger.residual > LARGEST_GAIN * ledger.largest_energy and ledger.largest_energy > floor:
        raise _energy_created(model, state)
    for name, part in others:
        part.guard(state.of(name), moment)


def check_step_size(state: State, limit: float) -> None:
    """Raises NumericalStop E-NUM-004 when the stable step collapses."""
    if not limit > SMALLEST_STEP * state.first_dt:
        raise NumericalStop(
            "E-NUM-004",
            f"the stable step collapsed to {limit:.3g} s (it began at {state.first_dt:.3g} s)",
            where=state.moment.when,
            why=f"the largest stretch of the fabric is {state.fabric.largest_stretch:.3g}",
            remedy="check the fabric's moduli and inflator.mass_flow",
        )


def _energy_created(model: Model, state: State) -> NumericalStop:
    ledger = state.ledger
    fastest = int(np.argmax(model.mass * np.sum(state.velocities**2, axis=1)))
    stop = NumericalStop(
        "E-NUM-003",
        f"energy balance violated: {ledger.residual:.3g} J created, {ledger.largest_energy:.3g} J were there at most",
        where=f"most of the motion is at node {fastest}, part {model.surface.parts_at(fastest)}, {state.moment.when}",
        why=f"the step ({state.dt:.3g} s) is too large for the stiffest part, or a load changed its sign",
        remedy="reduce run.dt_scale",
    )
    stop.nodes = (fastest,)
    return stop


def _non_finite(model: Model, state: State) -> NumericalStop:
    what, place, why, bad = _first_bad(model, state)
    stop = NumericalStop(
        "E-NUM-001",
        f"{what} is not a finite number",
        where=f"{place}, {state.moment.when}",
        why=why,
        remedy="reduce run.dt_scale, or check the moduli of the fabric and the slope of the obstacles",
    )
    stop.nodes = tuple(int(node) for node in bad[:8])
    return stop


def _first_bad(model: Model, state: State) -> tuple[str, str, str, np.ndarray]:
    """What went bad first, where, why, and its nodes. Gas couples all nodes: within one step the whole bag is bad."""
    # A step moves nodes before it evaluates forces: a bad position is older than what it has spoiled since.
    bad = np.flatnonzero(~np.isfinite(state.positions).all(axis=1))
    totals = state.gas.totals
    if not len(bad) and not math.isfinite(totals.pressure + totals.temperature):
        return "a state of the gas", "gas", "all positions are finite, so the gas went bad first", bad
    if not len(bad):
        bad = np.flatnonzero(~np.isfinite(state.velocities).all(axis=1))
    if not len(bad):
        return "a state", "gas or rigid body", "a state of the gas or of a rigid body is not finite", bad
    around = np.flatnonzero((model.surface.triangles == bad[0]).any(axis=1))
    start_area = np.linalg.norm(area_vectors(model.surface.triangles[around], model.start), axis=1).min()
    return (
        "a position or velocity",
        f"node {bad[0]} ({len(bad)} nodes in all), part {model.surface.parts_at(int(bad[0]))}",
        f"the step of {state.dt:.3g} s was too large there, or its elements are too small "
        f"(smallest {start_area:.3g} m^2)",
        bad,
    )
