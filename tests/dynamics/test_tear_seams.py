"""Tear seams: they tear at strength times length, in the order in which they are loaded, and the books close."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.bag.build_tear_seams import tear_line
from billow.case.build import build_model as model_of_case
from billow.case.schema import Case
from billow.geometry.chambers import OUTSIDE
from billow.geometry.rectangle_mesh import mesh_rectangle
from billow.geometry.surface import Surface, nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.driven_nodes import DrivenNodes
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.parts.tear_seams import NOT_YET, TORN_AT, TearSeams
from billow.run.check import describe
from billow.solver.model import Model
from billow.solver.run import Recorder, Schedule, run

FABRIC = LinearFabric(800.0, 0.3e-3, 0.40e9, 0.40e9, 0.0, 10e6, compression=False, damping=0.05)
WIDTH, HALF, SIZE, STRENGTH = 0.06, 0.06, 0.01, 3000.0


def sewn_strip(path, rate=(0.0,), strength=(STRENGTH,), stiffness=4e7, mass_damping=0.0):
    """Two pieces of fabric, joined by a tear seam across the strip; the left end is held, the right end follows
    path(time, y) [m]."""
    x, y = np.linspace(0.0, HALF, 7), np.linspace(0.0, WIDTH, 7)
    panel = mesh_rectangle(x, y, SIZE)
    n = len(panel.points)
    flat = np.concatenate([panel.points, panel.points + np.array([HALF, 0.0])])
    triangles = np.concatenate([panel.triangles, panel.triangles + n])
    surface = Surface.build(triangles, np.zeros(len(triangles), int), ("strip",), 2 * n)
    ties = np.column_stack([panel.grid[-1], n + panel.grid[0]])
    length = np.full(7, SIZE)
    length[[0, -1]] = 0.5 * SIZE
    seam = TearSeams(
        ("seam",), ties, np.zeros(7, int), length, np.zeros(7), stiffness * length, np.zeros(7),
        np.array([rate]), np.array([strength]),
    )  # fmt: skip
    membrane = Membrane.build(FABRIC, np.arange(len(triangles)), flat[triangles])
    mass = nodal_share(surface.triangles.astype(np.int64), membrane.mass, 2 * n)
    start, held = np.column_stack([flat, np.zeros(2 * n)]), np.concatenate([panel.grid[0], n + panel.grid[-1]])
    fixed = np.zeros(2 * n, bool)
    fixed[held] = True

    def places(time):
        now = start[held].copy()
        now[7:, 0] += path(time, now[7:, 1])
        return now

    return Model(
        surface=surface, start=start, mass=mass, fixed=fixed, gravity=np.zeros(3),
        gas=GasPart(NoGas(), surface, start), fabric=Fabric(surface, (membrane,)), straps=NO_STRAPS,
        bodies=Bodies((), np.zeros(2 * n), np.zeros(3)), driven=DrivenNodes(held, mass[held], places),
        tear_seams=seam, mass_damping=mass_damping,
    )  # fmt: skip


class Force(Recorder):
    """Largest force of the seam so far, and the force at the held end; state after some steps."""

    def __init__(self, keep=-1):
        self.seam, self.clamp, self.keep, self.kept, self.energy = [], [], keep, None, 0.0

    def step(self, model, state):
        self.seam.append(state.tear_seams[:, 0].sum())
        self.clamp.append(state.nodal_force[model.driven.nodes[:7], 0].sum())
        self.energy = max(self.energy, state.ledger["tear_seam"])
        if state.step == self.keep:
            self.kept = copy.deepcopy(state)


def even(speed):
    return lambda time, y: speed * time


def test_a_strip_pulled_at_a_constant_speed_tears_at_strength_times_width():
    model = sewn_strip(even(0.3), mass_damping=200.0)
    forces = Force()
    state = run(model, Schedule(0.012, 1, 20), forces)
    assert max(forces.seam) == pytest.approx(STRENGTH * WIDTH, rel=0.02)
    assert max(forces.clamp) == pytest.approx(STRENGTH * WIDTH, rel=0.03)
    # Springs in a row: fabric E t W / 2 L and seam k W.
    stretch = STRENGTH * (2.0 * HALF / (0.40e9 * 0.3e-3) + 1.0 / 4e7)
    assert state.tear_seams[:, TORN_AT] == pytest.approx(stretch / 0.3, rel=0.04)
    assert state.ledger["tearing"] == pytest.approx(0.5 * STRENGTH**2 / 4e7 * WIDTH, rel=0.04)
    assert state.ledger["tear_seam"] == 0.0
    assert state.ledger.relative_error < 0.01
    assert forces.seam[-1] == 0.0


def test_strength_grows_with_the_rate_of_loading():
    """Twice the speed, twice the rate; the curve asks for 1.5 times the force between the two rates."""
    torn = []
    slow = 0.2 / (2.0 * HALF / (0.40e9 * 0.3e-3) + 1.0 / 4e7)
    for speed in (0.2, 0.4):
        forces = Force()
        curve = {"rate": (slow, 2.0 * slow), "strength": (2000.0, 3000.0)}
        run(sewn_strip(even(speed), mass_damping=200.0, **curve), Schedule(0.013, 1, 20), forces)
        torn.append(max(forces.seam))
    assert torn[0] == pytest.approx(2000.0 * WIDTH, rel=0.03)
    assert torn[1] == pytest.approx(3000.0 * WIDTH, rel=0.03)


def test_a_seam_pulled_at_one_edge_unzips_from_there_tie_by_tie():
    model = sewn_strip(lambda time, y: 1.5 * time * y / WIDTH)
    state = run(model, Schedule(0.006, 1, 20), Force())
    torn_at = state.tear_seams[:, TORN_AT]
    assert (torn_at != NOT_YET).sum() >= 4
    torn = np.where(torn_at == NOT_YET, np.inf, torn_at)
    assert (np.diff(torn[::-1][torn[::-1] < np.inf]) > 0.0).all()  # from the pulled edge, y = WIDTH, inwards
    told = model.tear_seams.remarks(state.tear_seams)[0]
    assert "in the order 7, 6, 5" in told
    quantities = {q.name: q.value for q in model.tear_seams.quantities(state.tear_seams, state.moment)}
    assert 0.5 < quantities["torn"] <= 1.0
    assert state.ledger.relative_error < 0.01


def test_a_seam_that_never_tears_keeps_the_books_and_its_energy():
    model = sewn_strip(lambda time, y: 5e-4 * np.sin(np.pi * time / 0.01) ** 2, strength=(1e6,))
    forces = Force()
    state = run(model, Schedule(0.01, 1, 20), forces)
    assert (state.tear_seams[:, TORN_AT] == NOT_YET).all()
    assert state.ledger["tearing"] == 0.0
    assert forces.energy > 1e-4
    assert state.ledger.relative_error < 0.01


def test_a_run_resumed_while_the_seam_tears_gives_the_same_bits():
    model = sewn_strip(lambda time, y: 1.5 * time * y / WIDTH)
    schedule, forces = Schedule(0.006, 1, 20), Force(keep=600)
    state = run(model, schedule, forces)
    assert (forces.kept.tear_seams[:, TORN_AT] != NOT_YET).sum() > 0 or forces.kept.ledger["tear_seam"] > 0.0
    again = run(model, schedule, Recorder(), forces.kept)
    np.testing.assert_array_equal(state.positions, again.positions)
    np.testing.assert_array_equal(state.tear_seams, again.tear_seams)
    assert state.ledger.energies == again.ledger.energies


BAG = {"shape": "square", "side": 0.3, "element_size": 0.02, "mouth_radius": 0.03}
SEAM = {"name": "zip", "begin": [-0.12, 0.1], "end": [0.12, 0.1], "strength": "4 kN/m"}


def test_a_seam_of_a_ready_made_bag_joins_its_panels_along_the_line():
    shape = build_shape(Case.from_dict({"bag": BAG | {"tear_seams": [SEAM]}}).bag)
    (line,) = shape.tear_lines
    front, rear = shape.positions[line.ties[:, 0]], shape.positions[line.ties[:, 1]]
    assert len(line.ties) >= 11
    np.testing.assert_allclose(front[:, :2], rear[:, :2], atol=1e-12)
    assert (np.abs(front[:, 1] - 0.1) <= 0.01 + 1e-12).all()
    assert (np.diff(front[:, 0]) > 0.0).all()
    assert (front[:, 2] > rear[:, 2]).all()
    assert line.length.sum() == pytest.approx(np.ptp(front[:, 0]), rel=0.05)
    assert line.strength.tolist() == [4000.0]


@pytest.mark.parametrize("y", [0.10, 0.11, 0.13, -0.05])
def test_a_seam_is_as_long_as_its_line_between_rows_of_nodes_too(y):
    """Half way between two rows both are tied; there the seam once stood for the zigzag, 2.5 times its length."""
    bag = {"shape": "square", "side": 0.6, "element_size": 0.02}
    seam = SEAM | {"begin": [-0.12, y], "end": [0.12, y]}
    case = Case.from_dict({"bag": bag | {"tear_seams": [seam]}})
    (line,) = build_shape(case.bag).tear_lines
    assert line.length.sum() == pytest.approx(0.24, rel=1e-9)
    assert (line.length > 0.0).all()
    assert f"seam      zip: {len(line.ties)} ties over 240 mm" in describe(case)


def test_a_seam_holds_a_bag_together_until_it_tears():
    """Volume with a strong seam is smaller; a weak one tears, and everything it held is booked."""
    volumes, seam = {}, SEAM | {"begin": [-0.12, 0.06], "end": [0.12, 0.06]}
    for name, strength in (("strong", 1e6), ("weak", 200.0)):
        case = Case.from_dict(
            {
                "bag": BAG | {"tear_seams": [seam | {"strength": strength}]},
                "inflator": {"mass_flow": {"time": [0.0, 0.005, 0.012], "value": [0.0, 0.6, 0.0]}},
                "obstacles": [],
            }
        )
        model = model_of_case(case)
        state = run(model, Schedule(0.015, 1, 20, 0.8))  # a bag this coarse loses 1.1 % at the full step, as its square
        volumes[name] = model.surface.volume(state.positions)
        torn = state.tear_seams[:, TORN_AT] != NOT_YET
        assert not torn.any() if name == "strong" else torn.all()
        assert (state.ledger["tearing"] > 0.0) == (name == "weak")
        assert state.ledger.relative_error < 0.01
    assert volumes["strong"] < 0.9 * volumes["weak"]


def test_nodes_in_one_place_are_refused_since_contact_would_not_let_them_part():
    bag = Case.from_dict({"bag": BAG | {"tear_seams": [SEAM]}}).bag
    shape = build_shape(bag)
    ties = np.repeat(shape.tear_lines[0].ties[:, :1], 2, axis=1)
    with pytest.raises(InputError, match="lie in one place"):
        tear_line(bag.tear_seams[0], ties, shape)


def test_flaps_of_a_cover_part_where_their_seam_has_torn():
    """Nothing holds them but the seam: nor contact, nor a gas on either side."""
    cover = {"place": [0.0, 0.0, 0.05], "length": 0.2, "width": 0.1, "element_size": 0.02, "strength": 500.0}
    case = Case.from_dict(
        {
            "bag": BAG | {"element_size": 0.03, "covers": [cover]},
            "gas": {"model": "none"},
            "fabric": {"self_contact": "layers"},
            "obstacles": [
                {
                    "shape": "super-ellipsoid", "name": "ram", "radii": 0.03, "clearance": 0.06,
                    "motion": {"kind": "speed", "speed": 15.0, "direction": [0.0, 0.0, -1.0]},
                }
            ],
            "run": {"gravity": [0.0, 0.0, 0.0]},
        }
    )  # fmt: skip
    model = model_of_case(case)
    assert (model.surface.chambers.behind[model.surface.triangles_of("cover")] == OUTSIDE).all()
    state = run(model, Schedule(0.004, 1, 20))
    assert (state.tear_seams[:, TORN_AT] != NOT_YET).all()
    rows = state.positions[model.tear_seams.ties]
    middle = np.abs(rows[:, 0, 1]).argmin()
    assert np.linalg.norm(rows[middle, 1] - rows[middle, 0]) > 0.02
    assert state.ledger["drive_work"] > state.ledger["tearing"] > 0.0
    assert state.ledger.relative_error < 0.01


def test_jets_and_gas_leave_a_cover_alone():
    """By uniform pressure jets push on what they see, but not on what lies outside their bag."""
    cover = {"place": [0.0, 0.0, 0.05], "length": 0.2, "width": 0.1, "element_size": 0.02, "strength": 500.0}
    case = Case.from_dict(
        {
            "bag": BAG | {"element_size": 0.03, "covers": [cover]},
            "inflator": {"jets": {"angle": 20.0, "ring_radius": 0.02}},
            "gas": {"heat_transfer": 10.0},
            "fabric": {"permeability": 0.01},
            "obstacles": [],
        }
    )
    model = model_of_case(case)
    state = run(model, Schedule(0.002, 1, 5))
    there = np.unique(model.surface.triangles[model.surface.triangles_of("cover")])
    assert np.abs(state.positions[there] - model.start[there]).max() < 1e-9
    assert np.abs(state.positions - model.start).max() > 1e-3


def test_a_seam_outside_the_bag_is_refused():
    lost = SEAM | {"begin": [1.0, 1.0], "end": [2.0, 1.0]}
    with pytest.raises(InputError, match="has no length"):
        build_shape(Case.from_dict({"bag": BAG | {"tear_seams": [lost]}}).bag)


def test_a_seam_across_the_mouth_is_refused_since_ties_at_its_rim_would_stand_for_the_hole():
    across = SEAM | {"begin": [-0.12, 0.0], "end": [0.12, 0.0]}
    with pytest.raises(InputError, match=r"E-GEO-010(.|\n)*zip is interrupted between .-37.5, 0. and .37.5, 0. mm"):
        build_shape(Case.from_dict({"bag": BAG | {"tear_seams": [across]}}).bag)
    beside = [across | {"end": [-0.04, 0.0]}, across | {"name": "other", "begin": [0.04, 0.0]}]
    one, other = build_shape(Case.from_dict({"bag": BAG | {"tear_seams": beside}}).bag).tear_lines
    assert one.length.sum() == pytest.approx(other.length.sum())
