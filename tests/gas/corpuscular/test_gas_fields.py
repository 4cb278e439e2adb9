"""Fields of a gas whose state is known: in boxes, on faces and at points, also near walls and in flat bags."""

from __future__ import annotations

import numpy as np
import pytest
from flights import box
from gas_in_a_box import SIDE, Box

from billow.geometry.chambers import Chambers
from billow.parts.gas.corpuscular import gas_fields
from billow.parts.gas.corpuscular.gas_fields import IN_A_BOX, IN_A_SPHERE, on_faces, read_boxes, read_points
from billow.parts.gas.corpuscular.initial_air import fill_with_air
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.species import find_species, thermo_table

PRESSURE, TEMPERATURE = 150e3, 600.0
NUMBER = 40_000
AIR = Ambient(101325.0, 295.0, np.array([1.0]))
NOISE = np.sqrt(1.4)
"""Of the pressure of one diatomic particle: its number, 1, and its temperature, 2/5, both squared."""


class Scene:
    """Nitrogen at rest in cubes side by side, or what a map makes of them."""

    def __init__(self, rooms=1, warp=lambda p: p):
        triangles, positions, behind, ahead = box(4, rooms)
        names = tuple(f"room_{k}" for k in range(rooms))
        chambers = Chambers(names, behind.astype(np.int32), ahead.astype(np.int32))
        self.bag = Enclosure(triangles, warp(positions), chambers)
        volumes = chambers.volumes(triangles, self.bag.positions)
        table = thermo_table([find_species("N2", "test")])
        mass = PRESSURE * volumes.sum() / (table[0, 0] * TEMPERATURE)
        self.kinds = ParticleKinds.sharing(table, np.array([mass]), NUMBER)
        self.density = mass / volumes.sum()
        self.particles = Particles.room_for(NUMBER + 10)
        fill_with_air(self.particles, self.kinds, np.array([1.0]), PRESSURE, TEMPERATURE, volumes, self.bag, 3)

    def boxes(self):
        return read_boxes(self.particles, self.kinds, self.bag)

    def at(self, places):
        return read_points(np.array(places), self.particles, self.kinds, self.bag, AIR)


def flat(positions):
    return positions * [1.0, 1.0, 0.004]


def sheared(positions):
    return positions @ np.array([[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.7, 0.0, 1.0]])


@pytest.mark.parametrize("warp", [lambda p: p, flat, sheared], ids=["cube", "flat", "sheared"])
def test_boxes_have_the_state_of_the_gas(warp):
    scene = Scene(warp=warp)
    arrays = scene.boxes().arrays()
    counts = arrays["particles"]
    assert counts.sum() == scene.particles.count
    assert 0.4 * IN_A_BOX < counts.mean() < 2.0 * IN_A_BOX
    whole = counts > 0.5 * IN_A_BOX
    # 5 sigma of the mean of the boxes, and 1 % for volumes found with a lattice of 4^3 points a box.
    within = 5.0 * NOISE / np.sqrt(counts[whole].sum()) + 0.01
    assert arrays["pressure"][whole].mean() == pytest.approx(PRESSURE, rel=within)
    assert arrays["density"][whole].mean() == pytest.approx(scene.density, rel=within)
    assert arrays["temperature"][whole].mean() == pytest.approx(TEMPERATURE, rel=within)
    # Never more noise than independent particles and 4^3 points of a volume have together.
    assert arrays["pressure"][whole].std() / PRESSURE < np.sqrt(NOISE**2 / 60 + 1.0 / 64)


def test_boxes_of_a_flat_bag_are_as_high_as_the_bag():
    arrays = Scene(warp=flat).boxes().arrays()
    np.testing.assert_allclose(arrays["size"][:, 2], 0.004, rtol=0.02)
    assert len(arrays["size"]) > 200


def test_chambers_have_their_own_boxes():
    scene = Scene(rooms=2)
    second = scene.particles.chamber[: scene.particles.count] == 1
    scene.particles.velocity[: scene.particles.count][second] += [40.0, 0.0, 0.0]
    boxes = scene.boxes()
    arrays = boxes.arrays()
    drift = np.where(boxes.chamber == 1, 40.0, 0.0)
    spread = np.sqrt(scene.kinds.heat * TEMPERATURE / scene.kinds.mass[0] / arrays["particles"])
    assert (np.abs(arrays["velocity"][:, 0] - drift) < 5.0 * spread).all()
    faces = on_faces(boxes, scene.bag, np.full(2, TEMPERATURE))
    assert faces["gas_velocity"][scene.bag.chambers.behind == 1, 0].mean() == pytest.approx(40.0, abs=20.0)
    assert faces["gas_velocity"][scene.bag.chambers.behind == 0, 0].mean() == pytest.approx(0.0, abs=20.0)
    assert faces["gas_temperature"].mean() == pytest.approx(TEMPERATURE, rel=0.05)
    assert faces["gas_density"].mean() == pytest.approx(scene.density, rel=0.05)


@pytest.mark.parametrize("depth", [0.3, 0.01, 0.0001])
def test_a_sensor_reads_the_state_however_near_the_wall(depth):
    scene = Scene()
    rng = np.random.default_rng(5)
    places = np.column_stack([rng.uniform(0.3, 0.7, (20, 2)), np.full(20, depth)])
    found = scene.at(places)
    within = 5.0 * np.sqrt(NOISE**2 / IN_A_SPHERE + 1.0 / 1000) / np.sqrt(20)  # 5 sigma of the mean of 20
    assert found["pressure"].mean() == pytest.approx(PRESSURE, rel=within)
    assert found["density"].mean() == pytest.approx(scene.density, rel=within)
    assert found["temperature"].mean() == pytest.approx(TEMPERATURE, rel=within)


def test_a_sensor_in_a_flat_bag_and_one_in_the_other_room():
    assert Scene(warp=flat).at([[0.5, 0.5, 0.002]])["pressure"][0] == pytest.approx(PRESSURE, rel=0.35)
    scene = Scene(rooms=2)
    scene.particles.velocity[: scene.particles.count][scene.particles.chamber[: scene.particles.count] == 1] += 300.0
    found = scene.at([[0.98, 0.5, 0.5], [1.02, 0.5, 0.5]])["velocity"]
    spread = 5.0 * np.sqrt(scene.kinds.heat * TEMPERATURE / scene.kinds.mass[0] / IN_A_SPHERE)
    np.testing.assert_allclose(found, [[0.0] * 3, [300.0] * 3], atol=spread)


def test_boxes_of_a_mixture_in_motion():
    """Mean velocity by mass, mean temperature by degrees of freedom; a single particle has no temperature."""
    triangles, positions, behind, ahead = box(4, 1)
    chambers = Chambers(("room",), behind.astype(np.int32), ahead.astype(np.int32))
    gas = Box(["N2", "CO2"], [40_000, 20_000], [600.0, 600.0])
    gas.particles.velocity += [100.0, 0.0, -50.0]
    bag = Enclosure(triangles, SIDE * positions, chambers)
    boxes = read_boxes(gas.particles, gas.kinds, bag)
    assert boxes.count.sum() == gas.particles.count
    mass = boxes.density * boxes.size.prod(axis=1)
    assert mass.sum() == pytest.approx(gas.mass.sum(), rel=1e-3)  # boxes at the walls are cut
    assert np.average(boxes.velocity, axis=0, weights=mass) == pytest.approx([100.0, 0.0, -50.0], abs=5.0)
    many = boxes.count > 1
    assert np.average(boxes.temperature[many], weights=boxes.count[many] - 1) == pytest.approx(600.0, rel=0.01)
    gas.particles.count = 1
    assert np.isnan(read_boxes(gas.particles, gas.kinds, bag).temperature).all()


def test_outside_is_still_air():
    found = Scene().at([[0.5, 0.5, -0.1]])
    assert found["pressure"][0] == AIR.pressure
    assert found["temperature"][0] == AIR.temperature
    assert found["density"][0] == pytest.approx(101325.0 / (296.8 * 295.0), rel=1e-3)
    assert not found["velocity"].any()


def test_no_gas_gives_no_boxes():
    scene = Scene()
    scene.particles.count = 0
    boxes = scene.boxes()
    assert len(boxes.size) == 0
    assert on_faces(boxes, scene.bag, np.array([295.0]))["gas_temperature"].mean() == 295.0


def test_a_bag_without_volume_has_a_bounded_number_of_boxes():
    """A slanted sheet with a billionth of the volume about it: 4e11 boxes of a hundred particles' volume, and no memory
    has room for them."""
    boxes = Scene(warp=lambda places: places * [1.0, 1.0, 1e-9] + [0.0, 0.0, 1.0] * places[:, :1]).boxes()
    count = boxes.count
    assert 0 < len(count) <= 0.2 * count.sum()
    assert np.isfinite(boxes.pressure[count > 1]).all()


def test_testing_lattices_in_parts_changes_nothing(monkeypatch):
    whole = Scene().boxes()
    monkeypatch.setattr(gas_fields, "BOXES_AT_ONCE", 7)
    parts = Scene().boxes()
    assert (whole.pressure == parts.pressure).all()
