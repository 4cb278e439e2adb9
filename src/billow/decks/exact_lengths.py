"""Coordinates in metres as exact as their text: where a unit is a power of ten, the exponent of the text is shifted
before it becomes a number, so that what was written from metres comes back with the same bits."""

from __future__ import annotations

import math
import re
from decimal import Decimal

import numpy as np

from billow.decks.units import Units

_PARTS = re.compile(rb"([+-]?[0-9.]+)(?:[eEdD]?([+-]?\d+))?")


def metres(texts: np.ndarray | None, numbers: np.ndarray, scale: np.ndarray, units: Units) -> np.ndarray:
    """Coordinates (n, 3) [m]. texts: as the deck has them; numbers: what they are, times scale (n,)."""
    power = round(math.log10(units.length))
    if texts is None or units.length != float(f"1e{power}"):
        return numbers * units.length
    out = numbers * units.length
    plain = scale == 1.0
    out[plain] = _shifted(texts[plain].ravel(), power).reshape(-1, 3)
    return out


def _shifted(texts: np.ndarray, power: int) -> np.ndarray:
    """Numbers of texts times a power of ten, rounded once."""
    if power == 0 or not len(texts):
        return _read(texts)
    texts = np.strings.strip(texts)
    texts = np.where(texts == b"", b"0", texts)
    letter = np.zeros(len(texts), dtype=bool)
    for sign in (b"e", b"E", b"d", b"D"):
        letter |= np.strings.find(texts, sign) >= 0
    for sign in (b"+", b"-"):
        letter |= np.strings.find(texts, sign, 1) >= 1
    out = np.empty(len(texts))
    out[~letter] = np.strings.add(texts[~letter], f"e{power}".encode()).astype(float)
    out[letter] = [float(b"%se%d" % (m[1], int(m[2] or 0) + power)) for m in map(_PARTS.fullmatch, texts[letter])]
    return out


def _read(texts: np.ndarray) -> np.ndarray:
    texts = np.strings.strip(texts)
    return np.array(
        [float(b"%se%d" % (m[1], int(m[2] or 0))) for m in map(_PARTS.fullmatch, np.where(texts == b"", b"0", texts))]
    )


def written(value: float, units: Units, width: int) -> str:
    """Text of a length [m] in the units of a deck, which `metres` reads as the same bits where its unit is a power of
    ten; longer than width if it must be."""
    power = round(math.log10(units.length))
    if units.length != float(f"1e{power}"):
        return f"{value / units.length:.{width - 8}g}"
    decimal = Decimal(repr(float(value))).scaleb(-power)
    plain = f"{decimal:f}"
    if "." in plain:
        plain = plain.rstrip("0").rstrip(".")
    plain = plain.replace("0.", ".", 1) if plain.lstrip("-").startswith("0.") else plain
    short = f"{decimal.normalize():E}".replace("E+", "E")
    best = min((plain, short), key=len)
    return best if "." in best or "E" in best or len(best) >= width else f"{best}."
