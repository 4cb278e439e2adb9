"""Groups of neighbours: an order of items in which those near each other are beside each other."""

from __future__ import annotations

import numpy as np

GROUP = 8
"""Items of a group."""


def by_halves(coordinates: np.ndarray) -> np.ndarray:
    """Order of items with coordinates (n, dimensions), (n,) int64: GROUP successive ones are neighbours, and so
    are GROUP successive groups."""
    n = len(coordinates)
    size = GROUP
    while size < n:
        size *= 2
    order = np.full(size, n)
    order[:n] = np.arange(n)
    padded = np.vstack([coordinates, np.full(coordinates.shape[1], np.inf)])
    while size > GROUP:
        places = padded[order].reshape(-1, size, coordinates.shape[1])
        low = places.min(axis=1)
        high = np.where(np.isfinite(places), places, -np.inf).max(axis=1)
        along = np.argmax(np.where(np.isfinite(low), high - low, 0.0), axis=1)
        keys = np.take_along_axis(places, along[:, None, None], axis=2)[:, :, 0]
        order = np.take_along_axis(order.reshape(-1, size), np.argsort(keys, axis=1, kind="stable"), axis=1).ravel()
        size //= 2
    return order[:n]
