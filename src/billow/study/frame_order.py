"""The order of frames from the numbers in their names: bag_9.vtk before bag_10.vtk, t0.005.csv before t0.01.csv."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

_DECIMAL = re.compile(r"\d+(?:[.,p]\d+)?(?:e[+-]?\d+)?", re.IGNORECASE)
_COUNT = re.compile(r"\d+")


def frame_order(names: Sequence[str], times: np.ndarray | None) -> list[int]:
    """Indices of the names (without suffix) in the order of their frames. times: [s], (n,), rising, or None.

    A point, a comma or a p between digits may be a decimal mark (0.005, 0p005) or stand between two counts (1.9, 1.10).
    If that makes a difference, the reading whose numbers are those of the times in some unit is meant.
    ValueError, with a sentence, if there is none, if names differ in more than numbers, or if two have the same number.
    """
    readings = [_order(names, _DECIMAL), _order(names, _COUNT)]
    if readings[0] is not None and readings[1] is not None and readings[0][0] == readings[1][0]:
        return readings[0][0]
    for order, values in filter(None, readings):
        if times is not None and len(times) == len(values) and any(_like(column, times) for column in values.T):
            return order
    if readings == [None, None]:
        odd = next((name for name in names[1:] if _COUNT.sub("", name) != _COUNT.sub("", names[0])), names[-1])
        why = f"the names {names[0]!r} and {odd!r} differ in more than a number, or have the same number"
    else:
        why = f"{names[0]!r} and the others can be read as decimals or as counts, and are not the times in any unit"
    raise ValueError(f"the order of its frames is in doubt: {why}; number them 1, 2, 3, ...")


def _order(names: Sequence[str], number: re.Pattern) -> tuple[list[int], np.ndarray] | None:
    """Order of the names by their numbers, and these in that order (n, numbers); None if it does not follow."""
    if len({number.sub("#", name) for name in names}) != 1:
        return None
    values = np.array([[_value(text) for text in number.findall(name)] for name in names], float)
    if len(np.unique(values, axis=0)) != len(names) or not values.size:
        return None
    order = np.lexsort(values.T[::-1])
    return order.tolist(), values[order]


def _value(text: str) -> float:
    return float(text.lower().replace(",", ".").replace("p", "."))


def _like(values: np.ndarray, times: np.ndarray) -> bool:
    """Whether values are the times in another unit, within the rounding that still tells neighbours apart."""
    if len(times) < 2 or not (values[-1] > 0.0 and times[-1] > 0.0 and np.isfinite(times).all()):
        return False
    off = np.abs(values / values[-1] - times / times[-1])
    return bool(off.max() < 0.2 * np.diff(times / times[-1]).min())
