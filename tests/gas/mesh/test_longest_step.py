"""How long parts of a step of the mesh gas may be, and what steps of the structure it asks for."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.verification.mesh_gas import SCHEMES, SOUND, carry, mesh_in, moved
from billow.apps.verification.scenes import sphere
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh import mesh_gas
from billow.parts.gas.mesh.longest_step import parts_of, spread


def largest_eigenvalue(velocity: np.ndarray, sound: float) -> float:
    """Of sum_d |A_d|, from the matrices of the linear equations of p/(rho c) and the velocity."""
    whole = np.zeros((4, 4))
    for d in range(3):
        matrix = velocity[d] * np.eye(4)
        matrix[0, 1 + d] = matrix[1 + d, 0] = sound
        values, vectors = np.linalg.eigh(matrix)
        whole += (vectors * np.abs(values)) @ vectors.T
    return float(np.linalg.eigvalsh(whole)[-1])


def test_the_bound_is_the_largest_eigenvalue():
    random = np.random.default_rng(0)
    cases = [np.abs(random.normal(size=3)) * scale for scale in (0.0, 0.1, 1.0, 3.0) for _ in range(40)]
    cases += [np.ones(3), np.array([1.0, 1.0, 0.0]), np.array([2.0, 0.0, 0.0]), np.array([0.0, 1.0, 3.0])]
    for mach in cases:
        exact = largest_eigenvalue(mach, 1.0)
        assert spread(*mach, 1.0, 0.0) == pytest.approx(exact, rel=1e-5)
        assert spread(*mach, 1.0, 0.0) >= exact * (1.0 - 1e-13)
        assert spread(*mach, 1.0, 1.001 * exact) == 1.001 * exact
    assert spread(0.0, 0.0, 0.0, 1.0, 0.0) == pytest.approx(3.0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_noise_dies_at_the_bound_and_grows_beyond_it(scheme, monkeypatch):
    """Gas that flows at the speed of sound along a diagonal, with its bag; the sum of |u_d| + c is 1.29 times the bound
    there. Pressure in every other cell is 1e-5 higher; seen is what the walls have not reached."""
    monkeypatch.setattr(mesh_gas, "DRIFT", 10.0)
    shape, velocity, cell = sphere(0.25, 3), SOUND / np.sqrt(3.0) * np.ones(3), 0.0125
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))

    def noise(share: float) -> float:
        gas = mesh_in(bag, cell, scheme)
        state = gas.start(bag)
        sheet = state.sheets[0]
        hotter = 1.0 + 1e-5 * ((sheet.key + (sheet.key >> 21) + (sheet.key >> 42)) % 2)
        sheet.held[:, -1] *= hotter
        sheet.temperature, sheet.sound = sheet.temperature * hotter, sheet.sound * np.sqrt(hotter)
        carry(state, velocity)
        for _ in moved(gas, state, lambda now: shape.positions + velocity * now, 1.0, share / mesh_gas.COURANT):
            if state.parts == 20:
                break
        cells = gas.cells(state)
        about = np.linalg.norm(cells["centre"] - velocity * state.time, axis=1) < 0.25 - 13.0 * cell
        return float(np.ptp(cells["pressure"][about])) / 1e5

    assert noise(1.0) < 2e-5
    assert noise(1.25) > 1e-3


def test_the_gas_asks_for_steps_that_its_parts_fit_into():
    busy, flat = {"cells": 50_000, "fragments": 100_000}, {"cells": 0, "fragments": 100_000}
    # Two parts where one would nearly do: a step of one part, if parts are what costs.
    assert parts_of(1.3, 1.0, 4, **busy, triangles=30_000) == 1.0
    assert parts_of(1.3, 1.0, 4, **flat, triangles=30_000) == 1.3
    assert parts_of(1.9, 1.0, 4, **busy, triangles=30_000) == 1.9
    assert parts_of(2.1, 1.0, 4, **busy, triangles=30_000) == 2.0
    # One part that is as long as a step, or longer; and never more than a few parts.
    assert parts_of(0.7, 1.0, 4, **busy, triangles=30_000) == 0.7
    assert parts_of(9.0, 1.0, 4, **busy, triangles=30_000) == 4.0
    assert parts_of(1.0, np.inf, 4, **busy, triangles=30_000) == 1.0
    assert parts_of(np.inf, np.inf, 4, **busy, triangles=30_000) == np.inf
