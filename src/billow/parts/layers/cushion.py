"""The cushion: soft springs between layers that lie on each other. They carry static load and keep layers that are
pressed for long from creeping together; they keep nothing from crossing, which is the filter's work."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import inlined, kernel

STIFFNESS = 0.01
"""Of a pair, in the mass of its lightest node over the square of the fabric's stable step. A node has tens of pairs: a
tenth makes the step unstable (docs/theory.md, Layers)."""


@inlined
def stiffness_of(k, nodes, mass, inverse_mass, per_square_dt):
    """Of the spring of pair k [N/m]."""
    lightest = np.inf
    for i in range(4):
        if inverse_mass[nodes[k, i]] > 0.0:
            lightest = min(lightest, mass[nodes[k, i]])
    return per_square_dt * lightest


@kernel
def press(
    n, awake, nodes, weight, normal, distance, full_gap, growth, mass, inverse_mass, per_square_dt, dt, gap_out,
    force_out, sums_out,
):  # fmt: skip
    """Add the forces of springs k (g - d)^2/2 to force_out [N], (nodes, 3).

    The own gap g of a pair is the distance at which it was first seen, and grows to the full one as the pair parts.
    growth: speed [m/s] at which it grows by itself, which takes work. per_square_dt: STIFFNESS over dt^2 [1/s^2].
    sums_out: energy in the springs, and work that growing gaps did on them in this step of dt [s], [J].
    """
    stored, work = 0.0, 0.0
    for i in range(n):
        k = awake[i]
        g, d = gap_out[k], distance[k]
        if g < full_gap and d > g:
            g = min(full_gap, d)
            gap_out[k] = g
        near = g - d
        grows = growth > 0.0 and g < full_gap
        if near <= 0.0 and not grows:
            continue
        stiffness = stiffness_of(k, nodes, mass, inverse_mass, per_square_dt)
        if grows:
            g = min(full_gap, g + growth * dt)
            gap_out[k] = g
            work += 0.5 * stiffness * (max(0.0, g - d) ** 2 - max(0.0, near) ** 2)
            near = g - d
            if near <= 0.0:
                continue
        force = stiffness * near
        stored += 0.5 * force * near
        for corner in range(4):
            j = nodes[k, corner]
            share = force * weight[k, corner]
            force_out[j, 0] += share * normal[k, 0]
            force_out[j, 1] += share * normal[k, 1]
            force_out[j, 2] += share * normal[k, 2]
    sums_out[0], sums_out[1] = stored, work
