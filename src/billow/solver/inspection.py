"""Signs of ill health that no energy shows: nodes that shoot off, elements that stay turned inside out."""

from __future__ import annotations

import numpy as np

from billow.geometry.surface import area_vectors
from billow.solver.model import Model, State

SHOOTING = 0.5
"""Part of the smallest element altitude that a node may travel in one step."""


def shooting_nodes(model: Model, state: State) -> int:
    """Number of nodes that travel more than half the smallest altitude in one step."""
    altitude = min(membrane.altitude.min() for membrane in model.membranes)
    speed = np.sqrt(np.max(np.sum(state.velocities**2, axis=1)))
    if speed * state.dt <= SHOOTING * altitude:
        return 0
    return int(np.count_nonzero(np.linalg.norm(state.velocities, axis=1) * state.dt > SHOOTING * altitude))


def inverted_elements(model: Model, state: State) -> int:
    """Number of fabric triangles that face against every one of their neighbours.

    Fabric without compression folds through zero area while it crumples, and unfolds again: that is no fault. A
    triangle that still lies the wrong way round in an inflated bag is.
    """
    normals = area_vectors(model.surface.triangles, state.positions)
    first, second = _neighbours(model.surface.triangles.astype(np.int64))
    agree = np.zeros(len(normals), dtype=bool)
    same = np.einsum("ij,ij->i", normals[first], normals[second]) > 0.0
    agree[first[same]] = agree[second[same]] = True
    elements = np.concatenate([membrane.elements for membrane in model.membranes])
    return int(np.count_nonzero(~agree[elements]))


def _neighbours(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of triangles that share an edge."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    shared = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    return owner[shared], owner[shared + 1]
