"""Air fills the start shape evenly, at rest, with exactly its energy, however thin, folded or divided the bag is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.geometry.chambers import Chambers
from billow.parts.gas.corpuscular.initial_air import fill_with_air
from billow.parts.gas.corpuscular.inside_points import Enclosure, points_inside
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.particles import Particles, sum_particles
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant
from billow.parts.gas.supply.species import find_species, thermo_table

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def brick(low, high):
    """Closed, normals out."""
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    return np.array(triangles), np.array(low) + CORNERS * (np.array(high) - np.array(low))


def sheet(profile, gap, width):
    """A thin bag along a curve in x-z, (n, 2), gap thick at every point, straight in y."""
    n = len(profile)
    way = np.gradient(profile, axis=0)
    aside = np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1)[:, None]
    rows = [profile + 0.5 * gap * aside, profile - 0.5 * gap * aside]
    positions = np.array([[x, y, z] for y in (0.0, width) for row in rows for x, z in row])
    at = lambda far, below, i: (2 * far + below) * n + i  # noqa: E731
    quads = []
    for i in range(n - 1):
        quads.append([at(0, 0, i), at(0, 0, i + 1), at(1, 0, i + 1), at(1, 0, i)])  # top
        quads.append([at(0, 1, i), at(1, 1, i), at(1, 1, i + 1), at(0, 1, i + 1)])
        quads.append([at(0, 0, i), at(0, 1, i), at(0, 1, i + 1), at(0, 0, i + 1)])
        quads.append([at(1, 0, i), at(1, 0, i + 1), at(1, 1, i + 1), at(1, 1, i)])
    quads.append([at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)])
    quads.append([at(0, 0, n - 1), at(0, 1, n - 1), at(1, 1, n - 1), at(1, 0, n - 1)])
    return np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]), positions


def turned(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


@settings(max_examples=20)
@given(seed=st.integers(0, 1000), thin=st.floats(1e-4, 1.0))
def test_points_are_inside_and_even(seed, thin):
    triangles, positions = brick([0.0, 0.0, 0.0], [1.0, 0.7, thin])
    rotation = turned(seed)
    bag = Enclosure(triangles, positions @ rotation.T + 3.0, Chambers.single(len(triangles)))
    points, _, volumes = points_inside(bag, np.array([2000]), seed)
    assert volumes[0] == pytest.approx(0.7 * thin, rel=0.02)  # jittered columns; coarse where a thin brick stands askew
    local = (points - 3.0) @ rotation / [1.0, 0.7, thin]
    assert local.min() > -1e-9
    assert local.max() < 1.0 + 1e-9
    # Mean and variance of even points, four standard deviations of independent ones (these are more even).
    assert np.abs(local.mean(axis=0) - 0.5).max() < 4.0 * np.sqrt(1.0 / 12.0 / 2000)
    assert np.abs(local.var(axis=0) - 1.0 / 12.0).max() < 4.0 * np.sqrt(1.0 / 180.0 / 2000)


def test_a_folded_sheet():
    """2 mm thick, folded to and fro four times with 1 mm between the layers: points in all layers, none between."""
    layers, length, step = 5, 0.3, 0.003
    profile = []
    for k in range(layers):
        x = np.linspace(0.0, length, 20)
        profile += [(a, k * step) for a in (x if k % 2 == 0 else x[::-1])]
    triangles, positions = sheet(np.array(profile), 0.002, 0.2)
    room = Chambers.single(len(triangles))
    points, _, volumes = points_inside(Enclosure(triangles, positions, room), np.array([5000]), 0)
    assert volumes[0] == pytest.approx(room.volumes(triangles, positions)[0], rel=2e-3)
    middle = (points[:, 0] > 0.03) & (points[:, 0] < 0.27)  # away from the turns
    height = points[middle, 2] / step
    layer = np.rint(height)
    assert np.abs(height - layer).max() * step <= 0.001 + 1e-12
    counts = np.bincount(layer.astype(int), minlength=layers)
    assert counts == pytest.approx(counts.mean(), rel=0.05)


def test_chambers_get_their_own():
    """A brick with an inner wall: behind it chamber 0, ahead of it chamber 1; and a chamber without volume."""
    triangles, positions = brick([0.0, 0.0, 0.0], [1.0, 1.0, 1.0])
    other, further = brick([1.0, 0.0, 0.0], [1.5, 1.0, 1.0])
    wall = positions[triangles][:, :, 0].min(axis=1) == 1.0
    twin = further[other][:, :, 0].max(axis=1) == 1.0
    joined = np.concatenate([triangles, other[~twin] + 8])
    behind = np.repeat([0, 1], [12, 10]).astype(np.int32)
    ahead = np.where(np.concatenate([wall, np.zeros(10, bool)]), 1, -1).astype(np.int32)
    bag = Enclosure(joined, np.concatenate([positions, further]), Chambers(("0", "1", "2"), behind, ahead))
    points, chamber, volumes = points_inside(bag, np.array([300, 500, 10]), 1)
    assert volumes[:2] == pytest.approx([1.0, 0.5], rel=1e-3)
    assert volumes[2] == 0.0
    assert np.bincount(chamber, minlength=3).tolist() == [300, 500, 0]
    assert points[chamber == 0, 0].max() <= 1.0 <= points[chamber == 1, 0].min()


@pytest.mark.parametrize("count", [1, 2, 4000])
def test_air_is_at_rest_and_as_warm_as_it_says(count):
    names = {"N2": 0.79, "O2": 0.21}
    table = thermo_table([find_species(name, "test") for name in names])
    fractions = np.array(list(names.values())) / table[:, 0]
    fractions /= fractions.sum()
    triangles, positions = brick([0.0, 0.0, 0.0], [0.7, 0.7, 0.002])
    room = Chambers.single(len(triangles))
    volume = room.volumes(triangles, positions)
    mass = 101325.0 * volume[0] / (mixture_gas_constant(table, fractions) * 295.0)
    kinds = ParticleKinds.sharing(table, mass * fractions, count)
    particles = Particles.room_for(0)
    fill_with_air(particles, kinds, fractions, 101325.0, 295.0, volume, Enclosure(triangles, positions, room), 0)
    sums = sum_particles(particles, kinds.mass, 1)
    assert sums.particles.sum() == count
    assert sums.particles[0] == pytest.approx(count * np.array([0.79, 0.21]), abs=0.5)
    speed = np.sqrt(np.sum(sums.flight_energy) / mass)
    assert np.abs(sums.momentum).max() <= 1e-13 * mass * speed
    masses = sums.particles[0] * kinds.mass
    thermal = mixture_enthalpy(table, masses, 295.0) - mixture_gas_constant(table, masses) * 295.0
    assert sums.energy == pytest.approx(thermal, rel=1e-12)
    if count > 1:
        assert 2.0 / 3.0 * sums.flight_energy[0] / volume[0] == pytest.approx(101325.0, rel=1e-12)
    if count == 4000:
        scaled = particles.velocity / np.std(particles.velocity)
        assert np.mean(scaled**4) == pytest.approx(3.0, abs=0.2)  # 4 sigma: sqrt(24/12000); lighter species fly faster
