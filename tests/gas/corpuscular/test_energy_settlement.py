"""Settlement gives exactly the energy asked for, no momentum, all of it thermal."""

from __future__ import annotations

import numpy as np
import pytest
from gas_in_a_box import Box

from billow.parts.gas.corpuscular.energy_settlement import LARGEST_SHARE, settle, thermal_energy


@pytest.mark.parametrize("share", [-0.04, -1e-6, 0.0, 0.03])
def test_energy_is_given_and_momentum_kept(share):
    box = Box(["N2", "He"], [3000, 2000], [300.0, 900.0])
    box.particles.velocity += [40.0, -20.0, 10.0]
    before = box.sums()
    mass = box.kinds.mass
    pool = share * thermal_energy(before, mass)
    given = settle(box.particles, before, mass, pool)
    after = box.sums()
    assert given == pytest.approx(pool, rel=1e-14)
    assert after.energy - before.energy == pytest.approx(given.sum(), rel=1e-11, abs=1e-12 * before.energy)
    scale = np.sum(box.mass * np.linalg.norm(box.particles.velocity, axis=1))
    assert np.abs(after.momentum - before.momentum).max() < 1e-13 * scale
    assert after.internal_energy == pytest.approx(before.internal_energy * (1.0 + share), rel=1e-12)


def test_no_more_than_the_largest_share_at_once():
    box = Box(["N2"], [2000], [300.0])
    thermal = thermal_energy(box.sums(), box.kinds.mass)
    for sign in (-1.0, 1.0):
        given = settle(box.particles, box.sums(), box.kinds.mass, sign * thermal)
        assert np.abs(given) == pytest.approx(LARGEST_SHARE * thermal, rel=0.11)
        assert given * sign > 0.0


def test_thermal_energy_does_not_see_the_mean_motion():
    box = Box(["N2", "He"], [1500, 1500], [300.0, 300.0])
    before = thermal_energy(box.sums(), box.kinds.mass)
    box.particles.velocity += [300.0, -200.0, 500.0]
    assert thermal_energy(box.sums(), box.kinds.mass) == pytest.approx(before, rel=1e-12)


def test_same_bits_with_the_parallel_compilation(threads):
    """numba may lose what a parallel loop writes to the arrays of a group."""

    def settled(count):
        threads(count)
        box = Box(["N2", "He"], [8000, 4000], [300.0, 900.0])
        settle(box.particles, box.sums(), box.kinds.mass, 0.03 * thermal_energy(box.sums(), box.kinds.mass))
        return box.particles.velocity.tobytes() + box.particles.internal_energy.tobytes()

    assert settled(1) == settled(2)
