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
    whole = np.ones((len(centred), centred.shape[1] + 1))
    whole[:, 1:] = centred
    if not quadratic:
        return whole
    one, other = _pairs(whole.shape[1])  # with the constant first, a product of two is every term
    return whole.take(one, axis=1) * whole.take(other, axis=1)


_pairs = functools.cache(np.triu_indices)
