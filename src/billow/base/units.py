"""Units at the edges: everything inside is SI; a text such as "0.3 mm" is converted where it enters.

A number without a unit is taken as SI. A text with a unit must be of the right dimension.
"""

from __future__ import annotations

import re

CONVERSIONS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254},
    "m^2": {"m^2": 1.0, "cm^2": 1e-4, "mm^2": 1e-6},
    "m^3": {"m^3": 1.0, "l": 1e-3, "cm^3": 1e-6},
    "J": {"J": 1.0, "kJ": 1e3},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3},
    "kg m^2": {"kg m^2": 1.0, "kg mm^2": 1e-6},
    "kg/s": {"kg/s": 1.0, "g/s": 1e-3, "g/ms": 1.0},
    "kg/m^3": {"kg/m^3": 1.0, "g/cm^3": 1e3},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "mbar": 1e2},
    "K": {"K": 1.0},
    "N": {"N": 1.0, "kN": 1e3},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3},
    "N/m/s": {"N/m/s": 1.0, "kN/m/s": 1e3},
    "N/m^2": {"N/m^2": 1.0, "N/mm^2": 1e6},
    "Hz": {"Hz": 1.0},
    "m/s": {"m/s": 1.0, "mm/ms": 1.0, "km/h": 1.0 / 3.6},
    "m/s^2": {"m/s^2": 1.0, "g": 9.80665},
    "s/m": {"s/m": 1.0},
    "kg/mol": {"kg/mol": 1.0, "g/mol": 1e-3},
    "J/(mol K)": {"J/(mol K)": 1.0},
    "W/(m^2 K)": {"W/(m^2 K)": 1.0},
    "rad/s": {"rad/s": 1.0, "deg/s": 0.017453292519943295},
    "deg": {"deg": 1.0, "rad": 57.29577951308232},
    "-": {"-": 1.0, "%": 1e-2},
}
"""Accepted unit texts by the unit a field is kept in, and their factors."""

_TEXT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*([^\s\d].{0,15})?\s*")


def in_unit(value: float | int | str, unit: str) -> float:
    """Number in a unit, SI or any other one such as kPa, from a number in it or a text such as "0.3 mm".

    Raises ValueError with a sentence for the user if the text is no number or its unit does not fit.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f"expected a number in {unit}")
    if not isinstance(value, str):
        try:
            return float(value)
        except OverflowError:  # TOML integers have no bounds
            raise ValueError("the number is too large") from None
    match = _TEXT.fullmatch(value)
    if match is None:
        raise ValueError(f'expected a number in {unit} or a text such as "1.5 {unit}"')
    number, text = float(match[1]), (match[2] or unit).strip()
    if text == unit:
        return number
    fitting = [factors for factors in CONVERSIONS.values() if unit in factors]  # a g is a mass, and an acceleration
    for factors in fitting:
        if text in factors:
            return number * factors[text] / factors[unit]
    known = ", ".join(dict.fromkeys(name for factors in fitting for name in factors)) or unit
    raise ValueError(f"unit {text!r} does not fit here; expected one of {known}")


def other_scales(value: float, unit: str, low: float, high: float) -> list[str]:
    """Readings of the number in other units that would be plausible, for example ["0.3 mm", "0.3 cm"]."""
    return [
        f"{value:g} {text}"
        for text, factor in CONVERSIONS[unit].items()
        if factor != 1.0 and low <= value * factor <= high
    ]
