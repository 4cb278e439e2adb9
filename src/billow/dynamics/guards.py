"""A run that has become meaningless is stopped, with the place and the likely cause.

The check of every step is a handful of scalars, because a bad number anywhere reaches the energy sums at once; only
when they trip is the first bad entity looked for.
"""

from __future__ import annotations

import math

import numpy as np

from billow.dynamics.model import Model, State
from billow.errors import NumericalStop
from billow.geometry.surface import area_vectors

COLDEST, HOTTEST = 150.0, 3000.0  # K, gas temperatures outside mean a wrong input
SMALLEST_STEP = 1e-4  # of the first step


def check_state(model: Model, state: State, dt: float) -> None:
    """Raises NumericalStop E-NUM-001 (non-finite), E-NUM-002 (gas temperature) or E-NUM-003 (energy gain)."""
    ledger = state.ledger
    if not math.isfinite(ledger.residual):
        _stop_non_finite(model, state, dt)
    totals = model.gas.totals(state.gas)
    if totals.mass > 0.0 and not COLDEST < totals.temperature < HOTTEST:
        raise NumericalStop(
            "E-NUM-002",
            f"the gas left its range: {totals.temperature:.1f} K (allowed {COLDEST:.0f} to {HOTTEST:.0f} K)",
            where=_when(state),
            why=f"pressure {totals.pressure:.4g} Pa, volume {totals.volume:.4g} m^3, mass {totals.mass:.4g} kg",
            remedy="check inflator.mass_flow (kg/s, seconds) and inflator.temperature (K)",
        )
    if ledger.residual > 0.2 * ledger.largest_energy and ledger.largest_energy > 1.0:
        raise NumericalStop(
            "E-NUM-003",
            f"energy appeared from nowhere: {ledger.residual:.3g} J of {ledger.largest_energy:.3g} J",
            where=_when(state),
            why="the step is too large for the stiffest part, or a contact is too stiff",
            remedy=f"reduce run.dt_scale (the step is {dt:.3g} s)",
        )


def check_step_size(state: State, limit: float, first: float) -> None:
    """Raises NumericalStop E-NUM-004 when the stable step collapses."""
    if not limit > SMALLEST_STEP * first:
        raise NumericalStop(
            "E-NUM-004",
            f"the stable step collapsed to {limit:.3g} s (it began at {first:.3g} s)",
            where=_when(state),
            why=f"the largest stretch of the fabric is {state.largest_stretch:.3g}",
            remedy="check the fabric's moduli and inflator.mass_flow",
        )


def _when(state: State) -> str:
    return f"t = {1e3 * state.time:.4f} ms, step {state.step}"


def _stop_non_finite(model: Model, state: State, dt: float) -> None:
    bad = np.flatnonzero(~np.isfinite(state.velocities).all(axis=1) | ~np.isfinite(state.positions).all(axis=1))
    place, why = "gas or rigid body", "a state of the gas or of a rigid body is not finite"
    if len(bad):
        around = np.flatnonzero((model.surface.triangles == bad[0]).any(axis=1))
        parts = {model.surface.part_names[p] for p in model.surface.part[around]}
        start_area = np.linalg.norm(area_vectors(model.surface.triangles[around], model.start), axis=1).min()
        place = f"node {bad[0]} ({len(bad)} nodes in all), part {', '.join(sorted(parts))}"
        why = (
            f"the step of {dt:.3g} s was too large there, or its elements are too small (smallest {start_area:.3g} m^2)"
        )
    raise NumericalStop(
        "E-NUM-001",
        "a position or velocity is not a finite number",
        where=f"{place}, {_when(state)}",
        why=why,
        remedy="reduce run.dt_scale, or check the moduli of the fabric and the slope of the obstacles",
    )
