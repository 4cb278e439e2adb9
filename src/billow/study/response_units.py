"""In what unit a response is told: its own, or that of what is measured."""

from __future__ import annotations

from billow.base.errors import InputError
from billow.base.units import CONVERSIONS
from billow.study.responses import StudyResponse

WRONG_UNIT = InputError.declare(
    "E-DES-002",
    "response {name} is not in {unit}",
    where="[[responses]] {name}",
    why="it is in {natural}; units that fit are {known}",
    cause="a unit of another quantity",
    remedy="write one of these, or leave unit out",
)

UNIT_OF_CURVE = ("time_to", "rating")
"""Measures whose unit is that of the level or the reference, and not that of the response."""
FIXED_UNITS = {
    "time_of_peak": "s", "time_to": "s", "hic15": "-", "hic36": "-", "clip3ms": "m/s^2", "penetration": "m",
    "first_contact": "s", "contact_duration": "s", "energy_share": "-", "vented_mass": "kg", "fill_time": "s",
    "height": "m", "width": "m", "distance": "m", "section_area": "m^2", "contact_area": "m^2", "rating": "-",
}  # fmt: skip
"""Units of measures that do not depend on the curve."""


def natural_unit(response: StudyResponse, of_curve: str) -> str:
    """Unit that a response has by itself. of_curve: that of its curve, for those that have one."""
    if response.measure in FIXED_UNITS:
        return FIXED_UNITS[response.measure]
    return of_curve + (" s" if response.measure == "integral" else "")


def factor(response: StudyResponse, natural: str) -> float:
    """What one of the response's unit is in the natural one. InputError E-DES-002 as `factor_of_curve`."""
    return 1.0 if response.measure in UNIT_OF_CURVE else factor_of_curve(response, natural)


def factor_of_curve(response: StudyResponse, natural: str) -> float:
    """What one of the response's unit is in that of its curve. InputError E-DES-002: it is one of another quantity."""
    if response.unit in (None, natural):
        return 1.0
    known = CONVERSIONS.get(natural, {natural: 1.0})
    if response.unit not in known:
        raise WRONG_UNIT(name=response.name, unit=response.unit, natural=natural, known=", ".join(known))
    return known[response.unit]
