"""The impulse bank: every impulse arrives, and what strikes the walls is the pressure of the gas."""

from __future__ import annotations

import numpy as np
import pytest
from flights import MASS, Scene, box, flock_of

from billow.base.compiled import CHUNK
from billow.parts.gas.corpuscular.impact_bank import Hits, ImpactBank


def test_hits_are_added_in_order_and_keep_their_impulse():
    """Corners share an impulse by their weights and add up to it; both sides count what struck them."""
    bank, hits = ImpactBank.empty(2), Hits.empty(2 * CHUNK)
    hits.count[:] = [1, 2]
    hits.triangle[0, 0], hits.triangle[1, 0], hits.triangle[1, 1] = 1, ~1, 0
    hits.numbers[0, 0] = [1.0, 2.0, 3.0, 0.5, 0.3, 7.0, 0.1]
    hits.numbers[1, 0] = [-4.0, 0.0, 1.0, 0.25, 0.25, 5.0, 0.2]
    hits.numbers[1, 1] = [0.0, 0.0, 0.0, 0.1, 0.1, 3.0, 0.3]
    bank.collect(hits)
    assert bank.held[1] == pytest.approx(
        np.outer([0.5, 0.3, 0.2], [1.0, 2.0, 3.0]) + np.outer([0.25, 0.25, 0.5], [-4.0, 0.0, 1.0]), abs=1e-15
    )
    assert not bank.held[0].any()
    assert bank.struck.tolist() == [[[3.0, 0.3], [0.0, 0.0]], [[7.0, 0.1], [5.0, 0.2]]]
    assert not hits.count.any()


def test_smoothed_pressure_and_mass_flux_settle_at_those_of_the_gas():
    """p = n m c^2, incident flux n m cbar / 4 of a Maxwell gas; noise 1.13 / sqrt(hits) (cases T16, T19)."""
    rng = np.random.default_rng(2)
    triangles, positions, _, _ = box()
    n, c, dt = 40_000, 400.0, 1e-4
    scene = Scene(triangles, positions, flock_of(rng.uniform(0.01, 0.99, (n, 3)), rng.normal(0.0, c, (n, 3))))
    area = np.full(len(triangles), 1.0 / 32.0)
    for _ in range(60):
        scene.advance(dt)
        scene.bank.smooth(area, dt, 1e-3)
    # A mean over 1 ms counts the hits of about 2 ms; all six walls together.
    density = n * MASS
    flux = density * c * np.sqrt(2.0 / np.pi) / 2.0
    noise = 1.13 / np.sqrt(6.0 * flux / MASS * 2e-3)
    settled = 1.0 - np.exp(-6.0)
    assert scene.bank.pressure[:, 0].mean() == pytest.approx(settled * density * c**2, rel=4.0 * noise)
    assert scene.bank.mass_flux[:, 0].mean() == pytest.approx(settled * flux, rel=4.0 * noise)
    assert not scene.bank.pressure[:, 1].any()
    assert not scene.bank.struck.any()
