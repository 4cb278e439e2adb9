"""How elements share the mass of the nodes between them, so that the step is long (docs/theory.md, Membrane step).

The highest mode of a mesh is no faster than that of its fastest element alone, with whatever share of the mass of each
node is that element's, as long as the shares add up to the whole. Equal thirds of the elements' own masses are one
choice of them. A fast element may have more, at the cost of its slow neighbours: the bound falls, and it remains one.
The mass itself, and so the motion, is not touched.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from billow.parts.fabric.membrane import Membrane

ROUNDS = 5
"""After this many a step gains next to nothing: on driver bags 1.34 of 1.36, and 1.22 of 1.24."""

LEAST = 0.1
"""Of what it has, that an element claims at least: one beside a sliver, a million times slower, must keep a mass."""


def share_mass(membranes: Sequence[Membrane], triangles: np.ndarray) -> tuple[Membrane, ...]:
    """The membranes with shares by which their fastest elements are slower. triangles: of the surface, (m, 3).

    In every round, elements claim mass in proportion to what they have and to their squared rate, and each node serves
    the claims in proportion. The result is that of the best round.
    """
    if not any(len(membrane.elements) for membrane in membranes):
        return tuple(membranes)
    nodes = [triangles[membrane.elements].astype(np.int64) for membrane in membranes]
    count = 1 + max(int(corners.max(initial=0)) for corners in nodes)

    def at_nodes(shares: Sequence[np.ndarray]) -> np.ndarray:
        sums = (np.bincount(c.ravel(), s.ravel(), count) for c, s in zip(nodes, shares, strict=True))
        return sum(sums, np.zeros(count))

    shares = [np.repeat(membrane.mass[:, None] / 3.0, 3, axis=1) for membrane in membranes]
    mass = at_nodes(shares)
    best = now = tuple(membranes)
    for _ in range(ROUNDS):
        highest = fastest(now)
        claims = [
            share * np.maximum(membrane.squared_rate / highest, LEAST)[:, None]
            for share, membrane in zip(shares, now, strict=True)
        ]
        served = mass / np.where(mass > 0.0, at_nodes(claims), 1.0)
        shares = [claim * served[corners] for claim, corners in zip(claims, nodes, strict=True)]
        now = tuple(
            membrane.sharing(membrane.mass[:, None] / (3.0 * share))
            for membrane, share in zip(membranes, shares, strict=True)
        )
        if fastest(now) < fastest(best):
            best = now
    return best


def fastest(membranes: Sequence[Membrane]) -> float:
    """Largest squared rate of any element [1/s^2]."""
    return max(float(membrane.squared_rate.max(initial=0.0)) for membrane in membranes)
