"""How much fabric lies against a body, told so that millimetres of error do not matter.

The solver's penalty law turns micrometres of penetration into kilonewtons; a surrogate errs by millimetres. Its shape
can say where fabric lies within reach of the body, and which way it faces. For each reach d the area vector is

    a_d = - sum_i A_i exp(-max(0, distance_i) / d) n_i

with the nodes' fabric areas A_i and outward normals n_i of the body. Fabric that lies on the body under a pressure p
would push it with p a_d for a small d.
"""

from __future__ import annotations

import numpy as np

from billow.rom.coupled.impactor_of_design import Impactor

REACHES = (5e-3, 20e-3)
"""[m]: about the error of a surrogate, and well beyond it."""

FARTHEST = 7.0
"""Reaches beyond which fabric does not count: its weight is below 1e-3."""


def area_vectors(nodes: np.ndarray, area: np.ndarray, body: Impactor, centre: np.ndarray) -> np.ndarray:
    """Area vectors of all `REACHES`: [m^2], (reaches, 3).

    nodes: [m], (nodes, 3); area: fabric of each node [m^2], (nodes,); centre: of the body now [m], (3,)
    """
    # |y_k| <= a_k G along each axis: a node so far outside its box is out of reach before any power is taken.
    far = FARTHEST * max(REACHES)
    outside = np.abs((nodes - centre) @ body.rotation) - body.radii
    near = (outside < far).all(axis=1)
    nodes, area = nodes[near], area[near]
    distance, normal = distance_to(nodes, body, centre)
    weights = area * np.exp(-np.maximum(distance, 0.0) / np.array(REACHES)[:, None])
    return -weights @ normal


def distance_to(nodes: np.ndarray, body: Impactor, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the surface, negative inside: [m], (nodes,), to first order, and outward normals (nodes, 3).

    With G = (sum |y_k / a_k|^n)^(1/n), homogeneous of degree one, the distance is (G - 1) / |grad G|, exact for a
    sphere and on the surface of any body.
    """
    y = (nodes - centre) @ body.rotation / body.radii
    size = np.abs(y)
    # Scaled by its largest entry, no power overflows or vanishes; a node in the centre has no direction.
    largest = np.maximum(size.max(axis=1, keepdims=True), 1e-12)
    power = (size / largest) ** (body.degree - 1.0)
    sum_of_powers = np.maximum((power * size / largest).sum(axis=1), 1e-300)
    gauge = largest[:, 0] * sum_of_powers ** (1.0 / body.degree)
    gradient = np.sign(y) * power / body.radii * (sum_of_powers ** (1.0 / body.degree - 1.0))[:, None]
    steepness = np.maximum(np.linalg.norm(gradient, axis=1), 1e-12)
    return (gauge - 1.0) / steepness, (gradient / steepness[:, None]) @ body.rotation.T


def node_area(reference: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Fabric of each node in the start shape: [m^2], (nodes,), a third of each of its triangles."""
    a, b, c = (reference[triangles[:, k]].astype(float) for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(triangles.ravel(), np.repeat(third, 3), minlength=len(reference))
