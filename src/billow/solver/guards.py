"""A run that has become meaningless is stopped, with the place and the likely cause. A bad number anywhere reaches the
energy sums at once: every step checks a handful of scalars, and only when they trip is the first bad entity looked for.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.errors import NumericalStop
from billow.geometry.surface import area_vectors
from billow.solver.model import Model, State

NOT_FINITE = NumericalStop.declare(
    "E-NUM-001",
    "{quantity} is not a finite number",
    where="{place}, {when}",
    cause="a step too large for the smallest or stiffest element",
    remedy="reduce run.dt_scale, or check the moduli of the fabric and the slope of the obstacles",
)
ENERGY_CREATED = NumericalStop.declare(
    "E-NUM-003",
    "energy balance violated: {created:.3g} J created, the largest energy so far was {largest:.3g} J",
    where="most of the motion is at node {node}, part {part}, {when}",
    why="the step ({dt:.3g} s) is too large for the stiffest part, or a load changed its sign",
    cause="moduli in another unit, or gas that fills a very soft bag within a few steps",
    remedy="reduce run.dt_scale",
)
STEP_COLLAPSED = NumericalStop.declare(
    "E-NUM-004",
    "the stable step collapsed to {now:.3g} s (it began at {first:.3g} s)",
    where="{when}",
    why="the largest stretch of the fabric is {stretch:.3g}",
    cause="fabric that is far too soft, or far too much gas",
    remedy="check the moduli of the fabric and inflator.mass_flow",
)

SMALLEST_STEP = 1e-4
"""Of the first step."""

LARGEST_GAIN = 0.2
"""Of the largest energy so far."""

LARGE_ENERGY, SMALLEST_ENERGY = 1.0, 1e-9
"""Largest energies so far [J]: from the first on a gain is judged at once; between them only after FIRST_STEPS, because
in the first steps of a motion the error of the scheme is as large as the energy; below the second it is rounding."""

FIRST_STEPS = 1000


def check_state(model: Model, state: State, largest_gain: float = LARGEST_GAIN) -> None:
    """Raises NumericalStop: E-NUM-001 non-finite, E-NUM-003 energy created, and what parts find.

    largest_gain: of the largest energy so far [-].

    The gas, the first part, is asked first: what a chamber without volume does to pressures looks like anything else.
    """
    moment, ledger = state.moment, state.ledger
    (first, gas), *others = model.guarded
    gas.guard(state.of(first), moment)
    if not math.isfinite(ledger.residual):
        raise _non_finite(model, state)
    floor = LARGE_ENERGY if state.step <= FIRST_STEPS else SMALLEST_ENERGY
    if ledger.residual > largest_gain * ledger.largest_energy and ledger.largest_energy > floor:
        fastest = int(np.argmax(model.mass * np.sum(state.velocities**2, axis=1)))
        stop = ENERGY_CREATED(
            created=ledger.residual, largest=ledger.largest_energy, dt=state.dt,
            node=fastest, part=model.surface.parts_at(fastest), when=moment.when,
        )  # fmt: skip
        stop.nodes = (fastest,)
        raise stop
    for name, part in others:
        part.guard(state.of(name), moment)


def check_step_size(state: State, limit: float) -> None:
    """Raises NumericalStop E-NUM-004 when the stable step collapses."""
    if not limit > SMALLEST_STEP * state.first_dt:
        stretch = state.fabric.largest_stretch
        raise STEP_COLLAPSED(now=limit, first=state.first_dt, stretch=stretch, when=state.moment.when)


def _non_finite(model: Model, state: State) -> NumericalStop:
    """Names what went bad first, and where. Gas couples all nodes: within one step the whole bag is bad."""
    # A step moves nodes before it evaluates forces: a bad position is older than what it has spoiled since.
    when, gas = state.moment.when, state.gas.vitals
    bad = np.flatnonzero(~np.isfinite(state.positions).all(axis=1))
    if not len(bad) and not math.isfinite(gas.pressure + gas.temperature):
        why = "all positions are finite, so the gas went bad first"
        return NOT_FINITE(quantity="a state of the gas", place="gas", when=when, why=why)
    bad = bad if len(bad) else np.flatnonzero(~np.isfinite(state.velocities).all(axis=1))
    if not len(bad):
        why = "a state of the gas or of a rigid body is not finite"
        return NOT_FINITE(quantity="a state", place="gas or rigid body", when=when, why=why)
    around = np.flatnonzero((model.surface.triangles == bad[0]).any(axis=1))
    start_area = np.linalg.norm(area_vectors(model.surface.triangles[around], model.start), axis=1).min()
    stop = NOT_FINITE(
        quantity="a position or velocity",
        place=f"node {bad[0]} ({len(bad)} nodes in all), part {model.surface.parts_at(int(bad[0]))}",
        when=when,
        why=f"the step of {state.dt:.3g} s was too large there, or its elements are too small "
        f"(smallest {start_area:.3g} m^2)",
    )
    stop.nodes = tuple(int(node) for node in bad[:8])
    return stop
