"""The units in which pictures show what is kept in SI."""

from __future__ import annotations

from collections.abc import Iterable

from billow.base.close_names import did_you_mean
from billow.base.errors import InputError
from billow.base.units import CONVERSIONS

UNKNOWN_UNIT = InputError.declare(
    "E-PIC-003",
    "no quantity can be shown in {unit!r}",
    where="--unit",
    why="units are {known}",
    remedy="{hint}name one of these",
)

SHOWN = {
    "s": ("ms",), "m": ("mm",), "m^2": ("cm^2",), "m^3": ("l",), "kg": ("g",), "Pa": ("kPa", "MPa"), "N": ("N", "kN"),
    "m/s^2": ("g",),
}  # fmt: skip
"""Units by those of SI; of two, the second from 1,000 of the first on."""

ALWAYS = 1000.0


def factor_of(unit: str, text: str) -> float:
    """How many of SI's `unit` one `text` is."""
    return CONVERSIONS.get(unit, {}).get(text, 1.0)


def shown_unit(unit: str, largest: float = 0.0, wanted: Iterable[str] = ()) -> str:
    """The unit to show values in. unit: of SI; largest: value [unit]; wanted: units a user asked for, if one fits."""
    for text in wanted:
        if text in CONVERSIONS.get(unit, {}):
            return text
    choices = SHOWN.get(unit, (unit,))
    return choices[0] if largest < ALWAYS * factor_of(unit, choices[0]) else choices[-1]


def check_units(wanted: Iterable[str]) -> None:
    """InputError E-PIC-003 if one is unknown."""
    known = sorted({text for texts in CONVERSIONS.values() for text in texts} - {"-"})
    for unit in wanted:
        if unit not in known:
            raise UNKNOWN_UNIT(unit=unit[:40], known=", ".join(known), hint=did_you_mean(unit, known))
