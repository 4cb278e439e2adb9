"""The step in a few passes over memory against a plain one: each force by itself, summed up by NumPy."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from plain_loads import on_nodes

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.parts.bodies.contact import Nodes
from billow.parts.gas.gas_model import Bag
from billow.parts.part import Loads
from billow.solver.run import begin
from billow.solver.step import advance
from billow.solver.step_size import stable_dt

BAG = {"element_size": 0.05}
OBSTACLES = [
    {"shape": "plate"},
    {"shape": "super-ellipsoid", "name": "head", "radii": [0.1, 0.08, 0.09], "clearance": 0.005, "locked": False},
]
CASES = {
    "linear": {"fabric": {"permeability": 0.02}},
    "compression": {"fabric": {"compression": True}},
    "curves": {"fabric": {"law": "curves"}},
    "curves-shear": {"fabric": {"law": "curves-shear"}},
    "straps": {"bag": {**BAG, "straps": {"count": 2}}},
    "chambers": {"bag": {"shape": "rectangular", "chambers": 2, "element_size": 0.05, "vents": {"chambers": [2]}}},
    "self-contact": {"fabric": {"self_contact": True}},
    "layers": {"fabric": {"self_contact": "layers"}},
    "particles": {"gas": {"model": "corpuscular", "particles": 2000}},
    "gravity": {"run": {"gravity": [0.0, 0.0, -9.81]}},
}


def plain_step(model, state, dt):
    """As `advance`, without books."""
    positions, velocities = state.positions, state.velocities
    half = 0.5 * dt * model.inverse_mass[:, None]
    before = positions.copy()
    velocities += half * state.nodal_force
    # Contact by itself: a kick without force.
    nodes = Nodes(model.inverse_mass, np.zeros_like(positions), positions, velocities, np.empty_like(positions))
    if model.layers is None:
        model.bodies.kick_touch_drift(state.bodies, nodes, dt)
    else:
        rows = model.bodies.rows(state.bodies, nodes, dt)
        model.layers.part_layers(state.layers, positions, velocities, rows, state.time, dt)
        model.bodies.drift(state.bodies, rows)
    model.bodies.meet(state.bodies, dt)
    model.bodies.move(state.bodies, dt)
    contact = state.bodies.contact
    of_fabric = model.fabric.corner_forces(state.fabric, positions, velocities)
    unused = Loads(len(model.fabric.assembly.entry), model.surface)
    model.fabric.add_forces(state.fabric, positions, velocities, state.time, dt, unused)  # brings histories up to date
    force = np.zeros_like(positions)
    np.add.at(force, model.surface.triangles.astype(np.int64), of_fabric)
    loads = Loads(0, model.surface)
    bag = Bag(model.surface, positions, velocities, contact.touching, before)
    model.gas.advance(state.gas, bag, state.time, dt, loads)
    if model.self_contact is not None:
        model.self_contact.add_forces(state.self_contact, positions, velocities, dt, loads)
    if model.layers is not None:
        model.layers.add_forces(state.layers, positions, velocities, state.time, dt, loads)
    model.straps.add_forces(state.straps, positions, velocities, dt, loads)
    force += on_nodes(loads, model.surface, positions) + model.mass[:, None] * model.gravity
    state.nodal_force[...] = force
    velocities += half * (force + contact.force.sum(axis=0))
    state.time += dt
    state.step += 1


def relative(one, other):
    return np.abs(one - other).max() / np.abs(other).max()


@pytest.mark.parametrize("name", list(CASES))
def test_the_step_agrees_with_each_force_by_itself(name):
    case = Case.from_dict({"bag": BAG, "obstacles": OBSTACLES, **CASES[name]})
    model = build_model(case)
    state = begin(model, build_schedule(case.run))
    while state.time < 0.008:
        advance(model, state, stable_dt(model, state))
    plain = deepcopy(state)
    for _ in range(20):
        dt = stable_dt(model, state)
        advance(model, state, dt)
        plain_step(model, plain, dt)
    assert state.bodies.contact.touching.any()
    assert relative(state.positions, plain.positions) < 1e-12
    assert relative(state.velocities, plain.velocities) < 1e-9
    assert relative(state.nodal_force, plain.nodal_force) < 1e-9
    assert relative(state.bodies.motion[1].velocity, plain.bodies.motion[1].velocity) < 1e-9
