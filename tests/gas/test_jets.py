"""Jets: thrust arrives along each jet's axis, on what the jet can see, and nowhere else."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from billow.geometry.chambers import Chambers
from billow.geometry.surface import Surface, area_vectors, check_closed
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.inflator import Inflator, JetRing
from billow.parts.gas.supply.jets import Jets, add_jet_force, aim, power_of_last_force
from billow.parts.gas.supply.outflow import jet_speed
from billow.parts.gas.supply.species import SPECIES, thermo_table
from billow.parts.gas.supply.supply import Source, Supply
from billow.parts.gas.uniform.uniform_pressure import UniformPressure
from billow.parts.part import Loads

COUNT, LEAN = 6, np.radians(45.0)
RING = JetRing(COUNT, ring_radius=0.04, hole_diameter=0.005, angle=LEAN)
AZIMUTH = 2.0 * np.pi * np.arange(COUNT) / COUNT
RADIAL = np.column_stack([np.cos(AZIMUTH), np.sin(AZIMUTH), np.zeros(COUNT)])
HOLES = 0.04 * RADIAL
DIRECTIONS = np.sin(LEAN) * RADIAL + np.cos(LEAN) * np.array([0.0, 0.0, 1.0])


def dome(rings=14, sectors=60, radius=0.3):
    """Half a ball on its flat floor, closed, unchanged by a turn of 60 degrees; node 0 is the middle of the floor."""
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1]  # from the top down the ball, then over the floor to the middle
    out = np.where(polar <= np.pi / 2, np.sin(polar), (np.pi - polar) / (np.pi / 2))
    up = np.where(polar <= np.pi / 2, np.cos(polar), 0.0)
    turn = 2.0 * np.pi * (np.arange(sectors) + 0.2) / sectors
    shell = [[r * np.cos(a), r * np.sin(a), z] for r, z in zip(out, up, strict=True) for a in turn]
    positions = radius * np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], *shell])
    at = lambda ring, k: 2 + ring * sectors + k % sectors  # noqa: E731
    triangles = []
    for k in range(sectors):
        triangles.append([1, at(0, k), at(0, k + 1)])
        triangles.append([0, at(rings - 2, k + 1), at(rings - 2, k)])
        for ring in range(rings - 2):
            triangles.append([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)])
            triangles.append([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)])
    return np.array(triangles, dtype=np.uint32), positions


TRIANGLES, POSITIONS = dome()
UP, X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
MOUTH = np.array([0])
JETS = Jets(RING, MOUTH, UP, X)


@cache
def lit_without_a_wall():
    return aim(JETS, TRIANGLES, POSITIONS).triangles


def nearest_jet(triangles, positions):
    middle = positions[triangles].mean(axis=1)
    return np.round(np.arctan2(middle[:, 1], middle[:, 0]) / (2.0 * np.pi / COUNT)).astype(int) % COUNT


def push(pattern, thrust, triangles, positions, velocities, node_force):
    arrays = triangles, positions, velocities, MOUTH, pattern.force, node_force
    return add_jet_force(pattern.triangles, pattern.share, thrust, *arrays)


def forces(pattern, triangles, positions, velocities=None, thrust=100.0):
    """Forces on the corners of all triangles [N], which are those on the nodes, and their power [W]."""
    node_force = np.zeros_like(positions)
    velocities = np.zeros_like(positions) if velocities is None else velocities
    _, power = push(pattern, thrust, triangles, positions, velocities, node_force)
    corner_force = on_corners(pattern, triangles)
    gathered = np.zeros_like(positions)
    np.add.at(gathered, np.asarray(triangles, np.int64), corner_force)
    assert node_force == pytest.approx(gathered, abs=1e-12 * thrust)
    return corner_force, power


def on_corners(pattern, triangles):
    """Last forces on the corners of all triangles [N], (triangles, 3, 3)."""
    corner_force = np.zeros((len(triangles), 3, 3))
    corner_force[pattern.triangles] = pattern.force[:, None, :]
    return corner_force


def along_each_jet(corner_force, triangles, positions):
    """Force [N] along the axis of each jet, of the triangles nearest to it."""
    per_triangle, jet = corner_force.sum(axis=1), nearest_jet(triangles, positions)
    return np.array([(per_triangle[jet == k] @ DIRECTIONS[k]).sum() for k in range(COUNT)])


def test_the_dome_is_a_bag():
    surface = Surface.build(TRIANGLES, np.zeros(len(TRIANGLES)), ("dome",), len(POSITIONS))
    check_closed(surface, POSITIONS, "dome")
    assert surface.volume(POSITIONS) == pytest.approx(2.0 / 3.0 * np.pi * 0.3**3, rel=0.03)


def test_each_jet_pushes_with_its_thrust_and_all_together_only_forward():
    pattern = aim(JETS, TRIANGLES, POSITIONS)
    corner_force, power = forces(pattern, TRIANGLES, POSITIONS)
    assert pattern.seen == COUNT
    assert power == 0.0
    assert along_each_jet(corner_force, TRIANGLES, POSITIONS) == pytest.approx(100.0, rel=1e-12)
    total = corner_force.sum(axis=(0, 1))
    assert np.abs(total[:2]).max() < 1e-9 * total[2]
    # It is a jet: what it presses on lies about its axis.
    middle = POSITIONS[TRIANGLES[pattern.triangles]].mean(axis=1)
    way = middle - HOLES[nearest_jet(TRIANGLES, POSITIONS)[pattern.triangles]]
    cosine = np.sum(way * DIRECTIONS[nearest_jet(TRIANGLES, POSITIONS)[pattern.triangles]], axis=1)
    assert (cosine / np.linalg.norm(way, axis=1)).min() > np.cos(np.radians(25.0))


def test_power_is_force_times_velocity_against_the_mouth():
    pattern = aim(JETS, TRIANGLES, POSITIONS)
    velocities = np.random.default_rng(0).normal(size=POSITIONS.shape)
    corner_force, power = forces(pattern, TRIANGLES, POSITIONS, velocities)
    assert power == pytest.approx(np.sum(corner_force * (velocities - velocities[0])[TRIANGLES]), rel=1e-12)


def plate(jet, distance, half, shift, away):
    """A square of four triangles across a jet, `distance` [m] from its hole, moved sideways by `shift` [m] (2).

    away: whether its normals point along the jet, so that the jet sees its inside.
    """
    side = np.cross([0.0, 0.0, 1.0], RADIAL[jet])
    other = np.cross(DIRECTIONS[jet], side)
    middle = HOLES[jet] + distance * DIRECTIONS[jet] + shift[0] * side + shift[1] * other
    corners = middle + half * np.array([side, other, -side, -other])
    triangles = np.array([[4, k, (k + 1) % 4] for k in range(4)])
    nodes = np.array([*corners, middle])
    if (np.sum(area_vectors(triangles, nodes) @ DIRECTIONS[jet]) > 0.0) != away:
        triangles = triangles[:, [0, 2, 1]]
    return triangles, nodes


def with_plate(*arguments):
    triangles, nodes = plate(*arguments)
    joined = np.concatenate([TRIANGLES, triangles + len(POSITIONS)]).astype(np.uint32)
    return joined, np.concatenate([POSITIONS, nodes])


def crossed(origin, targets, corners):
    """Which segments from origin to targets (n, 3) cross one of the triangles (m, 3, 3): brute force."""
    hit = np.zeros(len(targets), dtype=bool)
    for a, b, c in corners:
        systems = np.empty((len(targets), 3, 3))
        systems[:, :, 0], systems[:, :, 1], systems[:, :, 2] = b - a, c - a, origin - targets
        u, v, t = np.linalg.solve(systems, np.tile((origin - a)[:, None], (len(targets), 1, 1)))[..., 0].T
        hit |= (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < 1.0)
    return hit


def test_a_wall_in_the_way_hides_all_that_is_behind_it():
    triangles, positions = with_plate(2, 0.08, 0.05, (0.0, 0.0), False)
    pattern = aim(JETS, triangles, positions)
    assert pattern.seen == COUNT - 1
    thrust = along_each_jet(forces(pattern, triangles, positions)[0], triangles, positions)
    assert thrust == pytest.approx([100.0, 100.0, 0.0, 100.0, 100.0, 100.0], rel=1e-12)


def test_a_wall_seen_from_inside_hides_nothing_and_is_hit():
    triangles, positions = with_plate(2, 0.08, 0.03, (0.0, 0.0), True)
    pattern = aim(JETS, triangles, positions)
    assert set(range(len(TRIANGLES), len(triangles))) <= set(pattern.triangles)
    assert set(lit_without_a_wall()) <= set(pattern.triangles)


@given(
    jet=st.integers(0, COUNT - 1),
    distance=st.floats(0.03, 0.15),
    half=st.floats(0.004, 0.03),
    shift=st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)),
)
def test_exactly_what_lies_behind_a_small_wall_is_hidden(jet, distance, half, shift):
    triangles, positions = with_plate(jet, distance, half, shift, False)
    sector = nearest_jet(triangles, positions)
    assume((sector[len(TRIANGLES) :] == jet).all())  # a jet knows what lies in its own sector
    open_view = lit_without_a_wall()
    lit = open_view[sector[open_view] == jet]
    wall = positions[triangles[len(TRIANGLES) :].astype(int)]
    hidden = crossed(HOLES[jet], POSITIONS[TRIANGLES[lit].astype(int)].mean(axis=1), wall)
    assert set(aim(JETS, triangles, positions).triangles) == set(open_view) - set(lit[hidden])


def blown_dome(flow, steps, dt, *, wall):
    """A still dome of nitrogen blown into; flow: times and mass flow. Returns totals and the impulse of each jet."""
    species = thermo_table([SPECIES["N2"]])
    air = Ambient(101325.0, 295.0, np.ones(1))
    inflator = Inflator(*map(np.array, flow), np.array([0.0, 1.0]), np.array([600.0, 600.0]), np.ones(1))
    triangles, positions = with_plate(2, 0.08, 0.05, (0.0, 0.0), False) if wall else (TRIANGLES, POSITIONS)
    chambers = Chambers.single(len(triangles))
    gas = UniformPressure(Supply(species, ("N2",), (Source(inflator, JETS),), air, chambers))
    bag = Bag(Surface.build(triangles, np.zeros(len(triangles)), ("bag",), len(positions)), positions, 0.0 * positions)
    state = gas.start(bag)
    received = np.zeros(COUNT)
    for step in range(steps):
        loads = Loads(0, bag.surface)
        gas.advance(state, bag, step * dt, dt, loads)
        force = on_corners(state.pattern[0], triangles)
        assert loads.node_force.sum(axis=0) == pytest.approx(force.sum(axis=(0, 1)), abs=1e-9)
        received += dt * along_each_jet(force, triangles, positions)
    return gas.totals(state), received, jet_speed(species, np.ones(1), 600.0)


def test_impulse_is_booked():
    totals, received, speed = blown_dome(([0.0, 0.01], [1.0, 1.0]), 100, 5e-5, wall=True)  # five of six see fabric
    assert totals.jet_impulse_in == pytest.approx(speed * 5e-3, rel=1e-12)
    assert totals.jet_impulse_out == pytest.approx(5.0 / 6.0 * totals.jet_impulse_in, rel=1e-12)
    assert received.sum() == pytest.approx(totals.jet_impulse_out, rel=1e-9)
    assert totals.jet_work == 0.0


def test_jets_blow_only_while_gas_flows():
    """A curve that begins late and high: impulse is mass times speed, with nothing before and after."""
    totals, received, speed = blown_dome(([0.004, 0.006], [3.0, 1.0]), 160, 5e-5, wall=False)
    assert totals.injected == pytest.approx(0.004, rel=1e-12)
    assert totals.jet_impulse_in == pytest.approx(0.004 * speed, rel=0.03)
    assert received.sum() == pytest.approx(totals.jet_impulse_out, rel=1e-9)


def turned_by(angle, axis):
    """Rotation matrix (Rodrigues' formula)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across


FLOOR = np.concatenate([[0], np.arange(len(POSITIONS) - 60, len(POSITIONS))])
"""The middle of the floor and the ring of nodes about it: a mouth that knows how it stands."""


@pytest.mark.parametrize("time", [0.0, 0.003])
@pytest.mark.parametrize("angle", [0.3, 2.0, np.pi])
def test_jets_turn_with_their_mouth(angle, time):
    """A scene that is tilted, twisted and moved away gives the same jets in its own frame."""
    spinning = JetRing(COUNT, 0.04, 0.005, LEAN, spin=40.0)
    jets = Jets(spinning, FLOOR, UP, X, mouth_start=POSITIONS[FLOOR])
    turn = turned_by(angle, [0.4, -1.0, 0.7])
    there = POSITIONS @ turn.T + [0.3, -2.0, 1.0]
    assert jets.turn(there) == pytest.approx(turn, abs=1e-14)
    for here, moved in zip(jets.nozzles(POSITIONS, time)[1:], jets.nozzles(there, time)[1:], strict=True):
        assert moved == pytest.approx(here @ turn.T, abs=1e-13)
    here, moved = aim(jets, TRIANGLES, POSITIONS, time), aim(jets, TRIANGLES, there, time)
    assert (here.triangles == moved.triangles).all()
    same, _ = forces(here, TRIANGLES, POSITIONS)
    turned, _ = forces(moved, TRIANGLES, there)
    assert turned == pytest.approx(same @ turn.T, rel=1e-9, abs=1e-9)


def test_the_last_force_is_weighed_with_the_velocities_of_now():
    """Work is the mean of two powers, so the force of the step before meets the velocities of this one."""
    pattern, outwards = aim(JETS, TRIANGLES, POSITIONS), 3.0 * POSITIONS
    args = TRIANGLES, POSITIONS, outwards, np.zeros_like(POSITIONS)
    assert push(pattern, 100.0, *args)[0] == 0.0
    before = power_of_last_force(pattern.triangles, pattern.force, TRIANGLES, outwards, MOUTH)
    last, power = push(pattern, 250.0, *args)
    assert last == pytest.approx(before, rel=1e-14)
    assert last > 0.0
    assert power == pytest.approx(2.5 * last, rel=1e-12)


def test_a_mouth_that_stays_changes_no_digit():
    jets = Jets(RING, FLOOR, UP, X, mouth_start=POSITIONS[FLOOR])
    free = Jets(RING, FLOOR, UP, X)
    for held, never in zip(jets.nozzles(POSITIONS), free.nozzles(POSITIONS), strict=True):
        assert held.tobytes() == never.tobytes()


def two_rooms(chamber):
    """The dome as a room within a larger one, and jets into the inner room (0); normals point out of the inner room."""
    outer = 2.0 * POSITIONS
    triangles = np.concatenate([TRIANGLES, TRIANGLES + len(POSITIONS)])
    positions = np.concatenate([POSITIONS, outer])
    walls = np.arange(len(triangles)) if chamber else np.arange(len(TRIANGLES))
    return triangles, positions, walls


def test_jets_fall_on_the_walls_of_their_own_chamber():
    triangles, positions, walls = two_rooms(0)
    jets = Jets(RING, np.array([0]), UP, X, walls, np.zeros(len(walls), bool))
    alone, inside = aim(JETS, TRIANGLES, POSITIONS), aim(jets, triangles, positions)
    assert np.array_equal(inside.triangles, alone.triangles)
    assert np.array_equal(inside.share, alone.share)


def test_a_wall_whose_normal_points_into_the_chamber_is_pushed_out_of_it():
    """The same dome with some of its triangles turned round: the same forces on the same nodes."""
    turned = np.arange(len(TRIANGLES)) % 3 == 0
    triangles = TRIANGLES.copy()
    triangles[turned] = triangles[turned][:, ::-1]
    jets = Jets(RING, np.array([0]), UP, X, np.arange(len(triangles)), turned)
    pattern = aim(jets, triangles, POSITIONS)
    force, same = np.zeros_like(POSITIONS), np.zeros_like(POSITIONS)
    still = np.zeros_like(POSITIONS)
    push(pattern, 100.0, triangles, POSITIONS, still, force)
    push(aim(JETS, TRIANGLES, POSITIONS), 100.0, TRIANGLES, POSITIONS, still, same)
    assert pattern.seen == COUNT
    assert force == pytest.approx(same, rel=1e-12, abs=1e-12)
