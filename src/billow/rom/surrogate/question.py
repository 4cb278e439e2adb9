"""What a surrogate is asked: designs and times, checked against what was trained."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter

BOUND_TOLERANCE = 1e-9
"""Part of a range by which a value may exceed it: the rounding of a unit conversion is no extrapolation."""


def design_rows(design, parameters: tuple[Parameter, ...]) -> tuple[np.ndarray, bool]:
    """Designs as (runs, parameters) float64, and whether a single one was given.

    design: {name: value or (runs,)} or (parameters,) or (runs, parameters)
    Raises InputError E-ROM-001 for wrong names, shapes, or values that are not finite numbers.
    """
    names = [parameter.name for parameter in parameters]
    if isinstance(design, Mapping):
        unknown = [f"unknown {name}" for name in design if name not in names]
        missing = [f"missing {name}" for name in names if name not in design]
        if unknown or missing:
            raise _misfit(names, ", ".join(unknown + missing))
        design = [design[name] for name in names]
        try:
            rows = np.stack(np.broadcast_arrays(*(np.asarray(value, float) for value in design)), axis=-1)
        except (TypeError, ValueError) as error:
            raise _misfit(names, str(error)) from error
    else:
        try:
            rows = np.asarray(design, float)
        except (TypeError, ValueError) as error:
            raise _misfit(names, str(error)) from error
    if rows.ndim not in (1, 2) or rows.shape[-1] != len(names):
        raise _misfit(names, f"values of shape {rows.shape} were given for {len(names)} parameters")
    if not np.isfinite(rows).all():
        raise _misfit(names, "a value is not a finite number")
    return np.atleast_2d(rows), rows.ndim == 1


def check_design(rows: np.ndarray, parameters: tuple[Parameter, ...]) -> None:
    """InputError E-ROM-002 if a value lies outside the range its parameter was trained on."""
    low, high = np.array([(parameter.low, parameter.high) for parameter in parameters]).T
    slack = BOUND_TOLERANCE * (high - low)
    outside = (rows < low - slack) | (rows > high + slack)
    if outside.any():
        row, column = np.argwhere(outside)[0]
        parameter = parameters[column]
        raise InputError(
            "E-ROM-002",
            f"{parameter.name} = {rows[row, column]:.6g} {parameter.unit} is outside what was trained",
            where=f"design {row}: {parameter.label}",
            why=f"the runs cover {parameter.low:g} to {parameter.high:g} {parameter.unit}; beyond, networks guess",
            remedy="choose a value inside, train on a wider study, or insist with extrapolate=True (--extrapolate)",
        )


def check_times(times: np.ndarray, trained: np.ndarray) -> None:
    """InputError E-ROM-003 if a time lies outside the trained ones or is no number. times, trained: [s], (times,)."""
    slack = BOUND_TOLERANCE * (trained[-1] - trained[0])
    outside = ~((times >= trained[0] - slack) & (times <= trained[-1] + slack))
    if outside.any():
        raise InputError(
            "E-ROM-003",
            f"time {times[outside.argmax()]:.6g} s is outside what was trained",
            where="times",
            why=f"the runs were recorded from {trained[0]:g} to {trained[-1]:g} s; beyond, networks guess",
            remedy="choose times inside, train on longer runs, or insist with extrapolate=True (--extrapolate)",
        )


def further_inputs(forces, model, shape: tuple[int, ...]) -> np.ndarray | None:
    """What a surrogate sees beside design and time: [-], (runs, times, further); None if it needs nothing.

    forces: [N], contact forces of the time before; model: the surrogate's `ForceInputs` or None; shape: (runs, times,
    nodes, 3) they must have, the first of which may be missing
    Raises InputError E-CPL-002 if forces are missing, superfluous, of another shape or not finite.
    """
    if model is None and forces is None:
        return None
    if model is None:
        why = "this surrogate was trained without them"
    elif forces is None:
        why = "this surrogate sees the contact forces of the time before, and none were given"
    else:
        forces = np.asarray(forces)
        if forces.shape in (shape, shape[1:]) and np.isfinite(forces).all():
            return np.broadcast_to(model(forces), (*shape[:2], model.width))
        why = f"forces have shape {forces.shape}, expected {shape}, or are not finite"
    raise InputError(
        "E-CPL-002",
        "contact forces do not fit the surrogate",
        where="previous_forces",
        why=why,
        remedy="give forces only to a surrogate trained with force_modes, one for each time and node",
    )


def _misfit(names, why) -> InputError:
    return InputError(
        "E-ROM-001",
        "the design does not fit the surrogate",
        where="design",
        why=why,
        remedy=f"give one number for each of: {', '.join(names)}",
    )
