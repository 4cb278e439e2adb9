"""Polynomials of a design: constant, linear, and squares and products."""

from __future__ import annotations

import functools

import numpy as np


def count(parameters: int, quadratic: bool) -> int:
    """Number of terms."""
    return 1 + parameters + quadratic * parameters * (parameters + 1) // 2


def terms(centred: np.ndarray, quadratic: bool) -> np.ndarray:
    """Constant, linear, and with `quadratic` squares and products, (runs, terms). centred: (runs, parameters), every
    range from -1 to 1."""
    one, other = _pairs(centred.shape[1])
    further = [centred[:, one] * centred[:, other]] if quadratic else []
    return np.column_stack([np.ones(len(centred)), centred, *further])


_pairs = functools.cache(np.triu_indices)
