"""Sweeps: impulses push only, reach every speed that is wanted, and keep momentum, though few pairs are visited."""

from types import SimpleNamespace

import numpy as np
import pytest

from billow.parts.layers.sweeps import CONVERGED, Constraints

LAYERS, WIDE, DT, TOLERANCE = 24, 6, 1e-5, 1e-6


def pressed_stack(seed):
    """Nodes of a stack of layers that fly at each other, each against three of the layer below."""
    rng = np.random.default_rng(seed)
    n = LAYERS * WIDE
    above = np.arange(WIDE, n)
    below = (above // WIDE - 1)[:, None] * WIDE + (above[:, None] + [0, 1, 2]) % WIDE
    m = len(above)
    nodes = np.column_stack([above, below]).astype(np.int32)
    weight = np.column_stack([np.ones(m), -rng.dirichlet(np.ones(3), m)])
    normal = rng.normal([0.0, 0.0, 1.0], 0.1, (m, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    distance = rng.uniform(1e-4, 4e-4, m)
    pairs = SimpleNamespace(nodes=nodes, weight=weight, normal=normal, distance=distance, gap=np.full(m, 5e-4))
    limits = SimpleNamespace(floor=(0.33, 1.6e-4, 1e-8), tolerance=TOLERANCE)
    velocities = np.zeros((n, 3))
    velocities[:, 2] = np.linspace(5.0, -5.0, n) + rng.normal(scale=0.5, size=n)
    step = SimpleNamespace(positions=np.zeros((n, 3)), inverse_mass=rng.uniform(0.5, 2.0, n), dt=DT)
    step.velocities = velocities
    aim = rng.uniform(-0.5, 0.0, m)
    per = 1.0 / (weight**2 * step.inverse_mass[nodes]).sum(axis=1)
    return pairs, limits, step, aim, per


def speeds(pairs, velocities):
    along = np.einsum("mk,mik->mi", pairs.normal, velocities[pairs.nodes])
    return (pairs.weight * along).sum(axis=1)


@pytest.mark.parametrize("seed", range(3))
def test_every_pair_is_fast_enough_and_only_those_that_push_are_not_faster(seed):
    pairs, limits, step, aim, per = pressed_stack(seed)
    momentum = (step.velocities / step.inverse_mass[:, None]).sum(axis=0)
    assert (aim - speeds(pairs, step.velocities) > 0.0).any()
    total = np.zeros(len(aim))
    constraints = Constraints(len(aim), np.arange(len(aim)), aim, per, total, pairs, limits, step)
    assert constraints.sweep(5000) < CONVERGED
    short = (aim - speeds(pairs, step.velocities)) * DT / TOLERANCE
    assert short.max() < 2.0 * CONVERGED
    assert np.abs(short[total > 0.0]).max() < 2.0 * CONVERGED
    assert total.min() >= 0.0
    assert (total == 0.0).any()
    assert (total > 0.0).any()
    assert (step.velocities / step.inverse_mass[:, None]).sum(axis=0) == pytest.approx(momentum, abs=1e-9)


def test_pairs_are_visited_again_when_something_else_has_moved_their_nodes():
    pairs, limits, step, aim, per = pressed_stack(0)
    constraints = Constraints(len(aim), np.arange(len(aim)), aim, per, np.zeros(len(aim)), pairs, limits, step)
    constraints.sweep(5000)
    for _ in range(500):  # until nothing waits
        constraints.sweep(1)
    before = step.velocities.copy()
    step.velocities[:WIDE, 2] += 9.0
    assert ((aim - speeds(pairs, step.velocities)) * DT / TOLERANCE).max() > 10.0
    constraints.note_others(before)
    constraints.sweep(5000)
    assert ((aim - speeds(pairs, step.velocities)) * DT / TOLERANCE).max() < 2.0 * CONVERGED
