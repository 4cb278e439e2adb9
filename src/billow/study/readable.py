"""Whether the runs of a study will hold what its responses are read off: asked before the first run is made."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from billow.base.errors import InputError
from billow.injury.criteria import HEAD_CLASS
from billow.injury.filters import require_samples
from billow.results.histories import History
from billow.study.response_units import UNIT_OF_CURVE, factor, factor_of_curve, natural_unit
from billow.study.responses import INJURIES, OF_FRAMES, OF_OBSTACLE, StudyResponse

if TYPE_CHECKING:
    from billow.run.check import Recorded

NOT_RECORDED = InputError.declare(
    "E-STU-042",
    "response {name} could not be read off any run",
    where="{where}",
    why="{why}",
    cause="a misspelt name or quantity, or a quantity that this case does not record",
    remedy="correct the entry of [[responses]]; docs/histories.md lists the quantities",
)

OF_WHOLE_CURVE = {"vented_mass": "vented", "fill_time": "volume"}
"""Measures of a curve that they name themselves."""


def require_readable(path: Path, responses: Sequence[StudyResponse], recorded: Recorded) -> None:
    """Try each response on what a run will hold.

    path: of the study file. InputError E-STU-042: no run will hold it; E-DES-002: its unit is of another quantity;
    E-INJ-003: the histories have too few rows for its filter.
    """
    history = History((column, np.zeros(1)) for column in recorded.columns)
    for number, response in enumerate(responses, start=1):
        where = f"{path}: [[responses]] number {number} ({response.name})"
        if why := _lacking(response, recorded, history):
            raise NOT_RECORDED(name=response.name, where=where, why=why)
        try:
            _require_unit_and_samples(response, recorded, history)
        except InputError as error:
            error.where = where
            raise


def _lacking(response: StudyResponse, recorded: Recorded, history: History) -> str:
    """What a run will lack for a response; empty if nothing."""
    of = response.of
    if response.measure in OF_OBSTACLE and of not in recorded.obstacles:
        return f"the case has no obstacle {of!r}{_like(of, recorded.obstacles)}"
    if response.measure in INJURIES and history.find(of, "velocity") is None:
        return f"{of} is locked, so it has no acceleration"
    if response.measure in OF_FRAMES and of and of not in recorded.parts:
        return f"the mesh has no part {of!r}{_like(of, recorded.parts)}"
    quantity, axis = _quantity(response)
    if quantity is None:
        return ""
    if unit := _unit(of, quantity, history):
        if response.measure == "energy_share" and unit != "J":
            return f"{quantity!r} is no energy"
        made_of = "velocity" if quantity == "acceleration" else quantity
        known = not axis or any(history.find(of, f"{name}_{axis}") is not None for name in (quantity, made_of))
        return "" if known else f"{quantity} has no axis {axis!r}"
    names = [column.rpartition(" [")[0] for column in recorded.columns]
    wanted = f"{of}_{quantity}" if of else quantity
    return f"the histories of a run have no column {wanted!r}{_like(wanted, names)}"


def _like(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), 1)
    return f"; did you mean {near[0]!r}?" if near else f"; known are {', '.join(known)}"


def _quantity(response: StudyResponse) -> tuple[str | None, str]:
    """The quantity of the histories that a response is read off, None for others, and its axis."""
    if response.measure in OF_WHOLE_CURVE:
        return OF_WHOLE_CURVE[response.measure], ""
    if response.quantity is None:
        return None, ""
    quantity, _, axis = response.quantity.partition(".")
    return quantity, axis


def _unit(of: str, quantity: str, history: History) -> str:
    """Unit of a quantity in the histories, empty if they lack it; accelerations and pressures are made of others."""
    if quantity == "acceleration" and history.find(of, "velocity") is not None:
        return "m/s^2"
    if quantity in ("absolute_pressure", "gauge_pressure"):
        return "Pa" if history.find(of, "pressure") is not None or of == "bag" else ""
    base = f"{of}_{quantity}" if of else quantity
    if history.find(of, quantity) is None:
        return ""
    return next(
        column.rpartition(" [")[2].rstrip("]") for column in history if column.startswith((f"{base} [", f"{base}_x ["))
    )


def _require_unit_and_samples(response: StudyResponse, recorded: Recorded, history: History) -> None:
    """InputError E-DES-002 and E-INJ-003."""
    quantity, _ = _quantity(response)
    of_curve = _unit(response.of, quantity, history) if quantity else ""
    if response.measure in UNIT_OF_CURVE:
        factor_of_curve(response, of_curve)
    factor(response, natural_unit(response, of_curve))
    if response.measure in INJURIES:
        require_samples(HEAD_CLASS, recorded.interval)
    if response.channel_class is not None:
        require_samples(response.channel_class, recorded.interval)
