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
    parts = [np.ones((len(centred), 1)), centred]
    if quadratic:
        one, other = _pairs(centred.shape[1])
        parts.append(centred.take(one, axis=1) * centred.take(other, axis=1))
    return np.concatenate(parts, axis=1)


_pairs = functools.cache(np.triu_indices)
