"""The cushion: soft springs between layers that lie on each other. They carry static load and keep layers that are
pressed for long from creeping together; they keep nothing from crossing, which is the filter's work."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import inlined, kernel

STIFFNESS = 0.05, 0.01
"""Of a node and a triangle, and of two edges, in the mass of the lightest node over the square of the fabric's stable
step. A node of layers that lie node on node is in two dozen pairs with triangles, and in three times as many of edges:
a tenth in all of them makes the step unstable (docs/theory.md, Layers)."""


@inlined
def stiffness_of(k, edges_from, nodes, mass, inverse_mass, spring):
    """Of the spring of pair k [N/m]."""
    lightest = np.inf
    for i in range(4):
        if inverse_mass[nodes[k, i]] > 0.0:
            lightest = min(lightest, mass[nodes[k, i]])
    return (spring[1] if k >= edges_from else spring[0]) * lightest


@kernel
def press(
    n, awake, edges_from, nodes, weight, normal, distance, near, full_gap, growth, mass, inverse_mass, spring, dt,
    gap_out, force_out, sums_out,
):  # fmt: skip
    """Add the forces of springs k (g - d)^2/2 to force_out [N], (nodes, 3).

    The own gap of a pair is the distance at which it was first seen, and grows as the pair parts, to the full one once
    it is no longer near: distances of a node and a triangle, and of two edges [m]. g is this gap, while it is near.
    growth: speed [m/s] at which it grows by itself, which takes work. spring: STIFFNESS over dt^2 [1/s^2].
    sums_out: energy in the springs, and work that growing gaps did on them in this step of dt [s], [J].
    """
    stored, work = 0.0, 0.0
    for i in range(n):
        k = awake[i]
        most, d = near[1] if k >= edges_from else near[0], distance[k]
        g, grows = min(most, gap_out[k]), growth > 0.0 and gap_out[k] < full_gap
        if d > g and gap_out[k] < full_gap:
            g = min(most, d)
            gap_out[k] = g if g < most else full_gap
        pressed = g - d
        if pressed <= 0.0 and not grows:
            continue
        stiffness = stiffness_of(k, edges_from, nodes, mass, inverse_mass, spring)
        if grows:
            g = min(most, g + growth * dt)
            gap_out[k] = g if g < most else full_gap
            work += 0.5 * stiffness * (max(0.0, g - d) ** 2 - max(0.0, pressed) ** 2)
            pressed = g - d
            if pressed <= 0.0:
                continue
        force = stiffness * pressed
        stored += 0.5 * force * pressed
        for corner in range(4):
            j = nodes[k, corner]
            share = force * weight[k, corner]
            force_out[j, 0] += share * normal[k, 0]
            force_out[j, 1] += share * normal[k, 1]
            force_out[j, 2] += share * normal[k, 2]
    sums_out[0], sums_out[1] = stored, work
