"""Layers of fabric: nothing crosses at any speed, momentum and energy are kept, and no result depends on the search."""

import copy
import dataclasses

import numpy as np
import pytest
from folded_bags import folded_bag
from thrown_sheets import CELLS, EDGE, facing, model_of, sheet

from billow.case.build import build_model, build_schedule, keep_apart
from billow.case.schema import Case
from billow.geometry.closest_points import of_segments, on_triangle
from billow.geometry.crossings import CrossingCount, edges_of
from billow.geometry.surface import Surface
from billow.parts.layers import layers as settings
from billow.parts.layers.mesh import TouchMesh
from billow.parts.layers.new_paths import find_pairs_of, splice
from billow.parts.layers.pairs import EDGES, FIRST, Room
from billow.parts.layers.rings import Rings, Shapes, open_rings
from billow.parts.layers.search import Paths, find_pairs
from billow.parts.part import Loads
from billow.run.simulate import simulate
from billow.solver.checkpoint import flatten, restore
from billow.solver.model import start_state
from billow.solver.run import begin
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt


def thrown(kind, speed, **options):
    """Model and state of two sheets of which the second flies at the first."""
    model, of_sheet = model_of(facing(kind), **options)
    state = start_state(model)
    state.velocities[of_sheet == 1, 2] = -speed
    first_forces(model, state)
    return model, state


def moments(model, state):
    momentum = model.mass[:, None] * state.velocities
    return momentum.sum(axis=0), np.cross(state.positions, momentum).sum(axis=0)


@pytest.mark.parametrize("kind", ["angle", "edge", "corner"])
@pytest.mark.parametrize("speed", [5.0, 50.0, 150.0])
def test_sheets_thrown_at_each_other(kind, speed):
    """Faces 2 degrees apart, free edges across each other, a corner on an edge."""
    model, state = thrown(kind, speed)
    count, dt = CrossingCount(model.surface), 0.75 * stable_dt(model, state)
    energy, (momentum, spin), crossings = state.ledger["kinetic"], moments(model, state), 0
    while state.time < min(8e-3, 0.02 / speed + 1e-3):
        advance(model, state, dt)
        crossings += count.total(state.positions)
    assert crossings == 0
    assert max(state.ledger.largest_gain, -state.ledger.largest_loss) < 1e-3 * energy
    assert 1e-4 * energy < state.ledger["layer_impact"] < 0.5 * energy
    ends = moments(model, state)
    assert np.abs(ends[0] - momentum).max() < 1e-11 * np.abs(momentum).max()
    assert np.abs(ends[1] - spin).max() < 1e-11 * np.abs(spin).max()


@pytest.mark.parametrize("speed", [5.0, 50.0])
def test_sheets_turned_in_space_meet_alike(speed):
    """Impulses are solved to two microns, so that rounding shows, but no more than that."""
    turned, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    turned *= np.sign(np.linalg.det(turned))
    model, state = thrown("angle", speed)
    dt = 0.75 * stable_dt(model, state)
    start = model.start @ turned.T + [0.3, -0.2, 0.1]
    other = dataclasses.replace(model, start=start)
    there = start_state(other)
    there.velocities = thrown("angle", speed)[1].velocities @ turned.T
    first_forces(other, there)
    for _ in range(round(6e-3 / speed / dt)):
        advance(model, state, dt)
        advance(other, there, dt)
    assert state.ledger["layer_impact"] > 0.01 * state.ledger["kinetic"]
    assert there.ledger["layer_impact"] == pytest.approx(state.ledger["layer_impact"], rel=0.02)
    expected = state.positions @ turned.T + [0.3, -0.2, 0.1]
    assert np.abs(there.positions - expected).max() < 1e-4


def test_without_contact_they_cross():
    model, state = thrown("angle", 50.0)
    model = dataclasses.replace(model, layers=None)
    dt, count, crossings = 0.75 * stable_dt(model, state), CrossingCount(model.surface), 0
    for _ in range(20):
        advance(model, state, dt)
        crossings += count.total(state.positions)
    assert crossings > 0


def test_a_sheet_thrown_at_fixed_fabric():
    model, state = thrown("angle", 50.0, fixed=(0,))
    held = model.fixed
    dt, count = 0.75 * stable_dt(model, state), CrossingCount(model.surface)
    energy = state.ledger["kinetic"]
    for _ in range(100):
        advance(model, state, dt)
        assert count.total(state.positions) == 0
    assert np.array_equal(state.positions[held], model.start[held])
    assert state.velocities[~held, 2].max() > -50.0
    assert abs(state.ledger.residual) < 1e-3 * energy


def test_holes_are_not_touched():
    """A vent may pass through fabric."""
    model, state = thrown("angle", 50.0)
    surface = model.surface
    hole = Surface.build(
        surface.triangles, surface.part, surface.part_names, surface.node_count, ("vent", "fabric"), surface.chambers
    )
    model = dataclasses.replace(model, surface=hole)
    model = dataclasses.replace(model, layers=keep_apart(model))
    state = start_state(model)
    first_forces(model, state)
    state.velocities[surface.node_count // 2 :, 2] = -50.0
    for _ in range(30):
        advance(model, state, 0.5 * stable_dt(model, state))
    assert state.ledger["layer_impact"] == 0.0


def layered(apart):
    """Model and state at rest of two sheets that lie `apart` [m] on each other."""
    model, _ = model_of(
        [sheet((0, 0, 0), [1, 0, 0], [0, 1, 0]), sheet((0.3 * EDGE, 0.2 * EDGE, apart), [1, 0, 0], [0, 1, 0])]
    )
    state = start_state(model)
    first_forces(model, state)
    return model, state


def test_layers_at_rest_within_the_gap_are_not_pushed():
    """A folded bag starts with its layers closer than the gap; no energy may come from that."""
    _, state = layered(1e-4)
    assert len(state.layers) > CELLS
    assert state.ledger["self_contact"] == 0.0
    assert np.abs(state.nodal_force).max() < 1e-9  # the rounding of the fabric


def test_cushion_is_the_gradient_of_its_energy():
    model, state = layered(2.9e-4)
    upper = np.arange(len(model.start)) >= len(model.start) // 2
    random = np.random.default_rng(1)

    def cushion(positions):
        """Energy and nodal forces at these positions, with own gaps as they are."""
        pairs, loads = copy.deepcopy(state.layers), Loads(0, model.surface)
        pairs.moment += 1
        booked = model.layers.add_forces(pairs, positions, np.zeros_like(positions), 0.0, 0.0, loads)
        return booked[0].energy, loads.node_force

    positions = model.start + random.normal(0.0, 1e-5, model.start.shape)
    positions[upper, 2] -= 1.2e-4
    stored, nodal = cushion(positions)
    direction, step = random.normal(size=positions.shape), 1e-10
    slope = (cushion(positions + step * direction)[0] - cushion(positions - step * direction)[0]) / (2.0 * step)
    assert stored > 0.0
    assert slope == pytest.approx(-float((nodal * direction).sum()), rel=1e-5)
    size = np.abs(nodal).sum()
    assert np.abs(nodal.sum(axis=0)).max() < 1e-13 * size
    assert np.abs(np.cross(positions, nodal).sum(axis=0)).max() < 1e-13 * size * np.abs(positions).max()


@pytest.mark.parametrize(("apart", "touch"), [(2.5e-4, True), (1e-3, False)])
def test_layers_touch_within_the_thickness_of_the_fabric(apart, touch):
    """Nodes above or below the other sheet, and no others."""
    model, state = layered(apart)
    advance(model, state, 1e-6)
    x, y = (state.positions[:, k] for k in (0, 1))
    lower = np.arange(len(x)) < len(x) // 2
    over = np.where(lower, (x > 0.301 * EDGE) & (y > 0.201 * EDGE), (x < 7.999 * EDGE) & (y < 7.999 * EDGE))
    assert np.array_equal(state.layers.touched, over & touch)


@pytest.mark.parametrize("place", [np.nan, np.inf, 1e200])
def test_a_bag_that_has_left_is_left_to_the_guards(place):
    """No search over half the universe: the energy is not a number, and the guards say what is wrong."""
    model, state = layered(1e-4)
    state.positions[5] = place
    advance(model, state, 1e-6)
    assert not np.isfinite(state.ledger.residual)


# --- search -----------------------------------------------------------------------------------------------------------


class Soup:
    """Triangles at random on their way, at up to `speed` [m/s], and all pairs of them: key, closest points, members."""

    nodes, near, time = 90, (0.03, 0.02), 0.01

    def __init__(self, seed, speed):
        self.random = random = np.random.default_rng(seed)
        triangles = np.array([random.choice(self.nodes, 3, replace=False) for _ in range(60)])
        self.positions = random.uniform(0.0, 1.0, (self.nodes, 3))
        self.velocities = speed * random.normal(size=(self.nodes, 3)) + 5.0
        self.skin, self.free = random.uniform(0.0, 0.02, self.nodes), random.random(self.nodes) < 0.8
        surface = Surface.build(triangles, np.zeros(len(triangles)), ("cloth",), self.nodes)
        self.mesh = TouchMesh.of(surface, self.free)
        triangles, edges = self.mesh.triangles, self.mesh.edges[:, :2]
        self.pairs = [
            (int(p) * FIRST + t, on_triangle, [p, *corners])
            for p in np.unique(triangles)
            for t, corners in enumerate(triangles)
            if p not in corners
        ] + [
            (EDGES + e * FIRST + g, of_segments, [*one, *other])
            for e, one in enumerate(edges)
            for g, other in enumerate(edges[e + 1 :], e + 1)
            if not np.isin(one, other).any()
        ]

    def came_near(self, moments):
        """Keys of the pairs that come near at one of these moments [s], each node straying within its skin."""
        near = set()
        for moment in moments:
            strayed = self.random.normal(size=(self.nodes, 3))
            strayed *= (self.skin / np.linalg.norm(strayed, axis=1))[:, None]
            places = self.positions + moment * self.velocities + strayed
            for key, closest, members in self.pairs:
                reach = self.near[1] if key >= EDGES else self.near[0]
                if self.free[members].any() and np.linalg.norm(closest(*places[members].ravel())[2:]) < reach:
                    near.add(key)
        return near


@pytest.mark.parametrize(("seed", "speed"), [(0, 1.0), (1, 1.0), (2, 20.0)])
def test_search_finds_every_pair_that_comes_near(seed, speed):
    """All against all, at several times. The fast ones pass through each other and are far apart again."""
    soup = Soup(seed, speed)
    found = find_pairs(soup.mesh, Paths(soup.positions, soup.velocities, soup.skin, *soup.near, soup.time))
    assert len(np.unique(found.key)) == len(found.key)
    came_near = soup.came_near(np.linspace(0.0, soup.time, 4 if speed == 1.0 else 8))
    assert len(came_near) > 100
    assert came_near <= set(found.key.tolist())
    assert len(found.key) < 0.7 * len(soup.pairs)


@pytest.mark.parametrize("strays", [0, 1, 12, 90])
@pytest.mark.parametrize("is_restarted", [False, True])
def test_a_list_with_new_paths_of_some_nodes_has_every_pair_that_comes_near(strays, is_restarted):
    """Half way some nodes go another way, in a wider skin. What is spliced into the list is all that they need, in the
    order of a list that is made anew."""
    soup = Soup(5, 20.0)
    room, half = Room(), 0.5 * soup.time
    old = find_pairs(soup.mesh, Paths(soup.positions, soup.velocities, soup.skin, *soup.near, soup.time), room)
    strayed = np.zeros(soup.nodes, bool)
    strayed[soup.random.choice(soup.nodes, strays, replace=False)] = True
    soup.positions = soup.positions + half * soup.velocities
    soup.velocities = np.where(strayed[:, None], -soup.velocities, soup.velocities)
    soup.skin = np.where(strayed, 1.5 * soup.skin, soup.skin)
    paths = Paths(soup.positions, soup.velocities, soup.skin, *soup.near, half)
    found = find_pairs_of(soup.mesh, paths, strayed, Room() if is_restarted else room)
    assert strayed[found.nodes].any(axis=1).all()
    count = len(old.key) + len(found.key)
    parts = [
        (one.key, one.nodes, one.normal, one.level, np.zeros(len(one.key)), np.zeros(len(one.key)))
        for one in (old, found)
    ]
    begin, spliced = np.empty_like(old.begin), tuple(np.empty((count, *a.shape[1:]), a.dtype) for a in parts[0])
    total = splice(len(begin) - 1, old.begin, parts[0], strayed, found.begin, parts[1], begin, spliced)
    key, nodes, normal, level = (array[:total] for array in spliced[:4])
    assert soup.came_near(np.linspace(0.0, half, 6)) <= set(key.tolist())
    anew = find_pairs(soup.mesh, paths, Room())
    anew_of, of = strayed[anew.nodes].any(axis=1), strayed[nodes].any(axis=1)
    for one, other in ((anew.key, key), (anew.nodes, nodes), (anew.normal, normal), (anew.level, level)):
        assert np.array_equal(one[anew_of], other[of])
    for group in range(len(begin) - 1):
        assert (np.diff(key[begin[group] : begin[group + 1]]) > 0).all()
    assert begin[-1] == total == len(np.unique(key))


def test_search_in_a_crowd_is_the_same_with_any_number_of_threads(threads):
    """Large triangles of which nearly all are near each other, so that lists of neighbours have to grow."""
    random = np.random.default_rng(3)
    triangles = random.permutation(1800)[:1500].reshape(-1, 3)
    triangles = np.vstack([triangles, random.permuted(triangles, axis=0), random.permuted(triangles, axis=0)])
    triangles = triangles[(np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)]
    positions, velocities = random.uniform(0.0, 1.0, (1800, 3)), random.normal(size=(1800, 3))
    surface = Surface.build(triangles, np.zeros(len(triangles)), ("cloth",), 1800)
    mesh = TouchMesh.of(surface, np.full(1800, True))
    paths = Paths(positions, velocities, np.full(1800, 0.001), 0.01, 0.005, 1e-3)
    expected, room = find_pairs(mesh, paths), Room()
    threads(2)
    for _ in range(3):
        found = find_pairs(mesh, paths, room)
        assert len(found.key) > 20000
        assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))


def creased(angle):
    """Positions and triangles of a sheet of four strips, each turned by an angle against its neighbours."""
    flat, triangles, _ = sheet((0.0, 0.0, 0.0), [1, 0, 0], [0, 1, 0], cells=(4, 3))
    turned = angle * (np.arange(4) % 2)
    rows = EDGE * np.vstack([[0.0, 0.0], np.cumsum(np.column_stack([np.cos(turned), np.sin(turned)]), axis=0)])
    row = np.rint(flat[:, 0] / EDGE).astype(int)
    return np.column_stack([rows[row, 0], flat[:, 1], rows[row, 1]]), triangles


def within_rings(triangles, nodes, positions):
    """Least distance within the ring of each node, of what shares no node, by looking at everything."""
    least = np.full(nodes, np.inf)
    for c in range(nodes):
        ring = triangles[(triangles == c).any(axis=1)]
        edges = edges_of(ring)
        for p in np.unique(ring):
            for corners in ring[~(ring == p).any(axis=1)]:
                way = on_triangle(*positions[[p, *corners]].ravel())[2:]
                least[c] = min(least[c], np.linalg.norm(way))
        for i, one in enumerate(edges):
            for other in edges[i + 1 :]:
                if not np.isin(one, other).any():
                    least[c] = min(least[c], np.linalg.norm(of_segments(*positions[[*one, *other]].ravel())[2:]))
    return least


def test_rings_are_open_while_nothing_in_them_comes_near():
    """A sheet is creased further and further, its nodes straying within their skins: no ring counts as open in which
    anything is near, and most of those far from a crease do, measured once or anew."""
    random, near, skin = np.random.default_rng(4), 0.1 * EDGE, 0.02 * EDGE
    shapes, closed = None, 0
    for angle in np.linspace(0.0, 3.1, 9):
        positions, triangles = creased(angle)
        after = creased(angle + 0.02)[0]
        nodes = len(positions)
        rings = Rings.of(triangles, nodes)
        shapes = shapes or Shapes(rings)
        ways = np.column_stack([positions, after, np.full(nodes, skin), np.zeros(nodes)])
        is_open = open_rings(rings, shapes, ways, near)
        for places in (positions, 0.5 * (positions + after), after):
            strayed = random.normal(size=(nodes, 3))
            strayed *= skin / np.linalg.norm(strayed, axis=1)[:, None]
            assert (within_rings(triangles, nodes, places + strayed)[is_open] > near).all()
        assert is_open.all() or angle > 1.5
        closed += (~is_open).sum()
    assert closed > 10


# --- folded bags ------------------------------------------------------------------------------------------------------

GAS = {
    "mass_flow": {"time": [0, 1e-3, 3e-3, 4e-3, 8e-3], "value": [0, 2.5, 1.8, 5.4, 3.0]}, "temperature": 650.0,
    "jets": {"count": 0},
}  # fmt: skip


def folded(folder, size=0.02, directions=1, gas=True, **run):
    """The case of a folded bag."""
    data = {"bag": folded_bag(folder, size, directions), "fabric": {"self_contact": "layers"}, "obstacles": []}
    data |= {"inflator": GAS} if gas else {"gas": {"model": "none"}}
    return Case.from_dict(data | {"run": run})


@pytest.fixture(scope="module")
def opening(tmp_path_factory):
    """Model and state of a folded bag after 20 steps of inflation, when its layers meet hard."""
    case = folded(tmp_path_factory.mktemp("folded"))
    model = build_model(case)
    state = begin(model, build_schedule(case.run))
    while state.time < 0.8e-3:
        advance(model, state, stable_dt(model, state))
    return model, state


def after(model, state, steps=12):
    for _ in range(steps):
        advance(model, state, stable_dt(model, state))
    assert state.ledger["layer_impact"] > 0.0
    return flatten(state)[0]


@pytest.fixture(scope="module")
def expected(opening):
    return after(opening[0], copy.deepcopy(opening[1]))


PHYSICAL = ("positions", "velocities", "nodal_force")


@pytest.mark.parametrize(
    "changed",
    [
        {"SKIN": 2.0}, {"SKIN": 0.2}, {"MOST_STEPS": 2.0}, {"READY": 0.6}, {"FARTHEST_WAY": 0.02},
        {"MOST_STRAYED": 0.0}, {"MOST_STRAYED": 1.0}, {"MOST_STRAYED": 1.0, "STRAYED": 0.02},
        {"MOST_STRAYED": 1.0, "SKIN_AGAIN": 1.0},
    ],
)  # fmt: skip
def test_same_bits_for_any_list(opening, expected, changed, monkeypatch):
    """However widely and however often pairs are searched for."""
    model, state = opening
    for name, value in changed.items():
        monkeypatch.setattr(settings, name, value)
    model = dataclasses.replace(model, layers=keep_apart(model))
    state = copy.deepcopy(state)
    state.layers.horizon = 0.0  # a new list at once
    found = after(model, state)
    assert all(np.array_equal(found[name], expected[name]) for name in PHYSICAL)


def test_same_bits_for_any_number_of_threads(opening, expected, threads):
    threads(2)
    found = after(opening[0], copy.deepcopy(opening[1]))
    assert all(np.array_equal(found[name], expected[name]) for name in expected)


def test_same_bits_after_a_restart(opening, expected):
    model, state = opening
    arrays, numbers = flatten(copy.deepcopy(state))
    found = after(model, restore(start_state(model), arrays, numbers))
    assert all(np.array_equal(found[name], expected[name]) for name in expected)


def test_a_folded_bag_stays_as_it_is_without_gas(tmp_path):
    case = folded(tmp_path, gas=False)
    model = build_model(case)
    state = begin(model, build_schedule(case.run))
    while state.time < 2e-3:
        advance(model, state, stable_dt(model, state))
        assert state.ledger["kinetic"] < 1e-4
    assert CrossingCount(model.surface).total(state.positions) == 0


def test_a_folded_bag_opens_without_crossings(tmp_path):
    case = folded(tmp_path, end_time=6e-3, frames=12, guard_crossings=True)
    result = simulate(case, tmp_path / "run")
    verdict = {line["name"]: line["verdict"] for line in result.record["quality"]["criteria"]}
    assert result.ledger["crossings_at_worst"] == 0.0
    assert verdict["crossings of fabric through fabric"] == "PASS"
    assert verdict["energy created by layers that meet, of peak internal"] == "PASS"
    assert result.histories["layer_impact [J]"][-1] > 1.0


@pytest.mark.parametrize("apart", ["layers", False])
def test_fabric_under_another_layer_does_not_leak(tmp_path, apart):
    """Where layers lie on each other, and only there: none do at the start, and none are felt without contact."""
    leakage = {"law": "graefe", "pressure_factor": 0.02, "blockage": True}
    case = Case.from_dict(
        {
            "bag": folded_bag(tmp_path, 0.02, 1), "fabric": {"self_contact": apart}, "obstacles": [], "inflator": GAS,
            "leakage": leakage, "run": {"end_time": 1e-3, "frames": 2},
        }
    )  # fmt: skip
    blocked, whole = simulate(case, tmp_path / "run").histories["blocked_area [m^2]"], build_model(case).fabric.area
    assert blocked[0] == 0.0
    assert (0.05 * whole < max(blocked) < whole) if apart else max(blocked) == 0.0
