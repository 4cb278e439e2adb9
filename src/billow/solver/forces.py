"""All forces, in the order they act. Who wants to know what pushes on the fabric reads this file.

Contact is solved over the drift of a step (`push_apart`); everything else is evaluated at its end (`evaluate_forces`).
"""

from __future__ import annotations

import math

import numpy as np

from billow.parts import straps
from billow.parts.bodies import rigid_body
from billow.parts.bodies.rigid_body import spin
from billow.parts.bodies.rigid_contact import push
from billow.parts.fabric.fabric_law import ENERGY, HYSTERESIS, POWER, STRETCH
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_model import Bag
from billow.solver.model import Model, State
from billow.solver.nodes import gather


def evaluate_forces(model: Model, state: State, time: float, dt: float) -> None:
    """Forces at the new positions of a step from `time` to `time + dt` [s]; velocities are those of its middle."""
    state.corner_force.fill(0.0)
    touched = state.contact.touching.any(axis=0)
    bag = Bag(model.surface, state.positions, state.velocities, touched)
    model.gas.advance(state.gas, bag, time, dt, state.corner_force)
    add_membrane_forces(model, state, dt)
    keep_layers_apart(model, state, dt)
    gather(
        model.surface.corner_start, model.surface.corners, state.corner_force,
        model.mass, model.gravity, 2.0 * model.mass_damping, state.velocities, state.nodal_force,
    )  # fmt: skip
    add_straps(model, state, dt)


def add_membrane_forces(model: Model, state: State, dt: float) -> None:
    """Fabric stress on the corners; books strain energy, damping, hysteresis and the largest stretch."""
    state.ledger.strain = state.ledger.hysteresis = 0.0
    largest = 0.0
    membranes = model.membranes if model.birth is None else membranes_at_birth(model, state, dt)
    for membrane, history, sums in zip(membranes, state.membrane_history, state.membrane_sums, strict=True):
        membrane.fabric.add_forces(
            membrane, model.surface.triangles, state.positions, state.velocities, history, state.corner_force, sums
        )
        columns = sums.T.tolist()
        state.ledger.strain += sum(columns[ENERGY])
        state.ledger.damping += sum(columns[POWER]) * dt
        state.ledger.hysteresis += sum(columns[HYSTERESIS])
        largest = max([largest, *columns[STRETCH]])
    state.largest_stretch = math.sqrt(largest)


def membranes_at_birth(model: Model, state: State, dt: float) -> tuple[Membrane, ...]:
    """The membranes with the reference of the step's end; books the work of the reference that moved."""
    before, now = model.birth.fraction(state.time), model.birth.fraction(state.time + dt)
    membranes = model.birth.membranes(model.membranes, now)
    if before < 1.0:
        slope = model.birth.energy_slope(
            model.membranes, now, model.surface.triangles, state.positions, state.membrane_history
        )
        state.ledger.birth_work += 0.5 * (state.ledger.birth_slope + slope) * (now - before)
        state.ledger.birth_slope = slope
    return membranes


def keep_layers_apart(model: Model, state: State, dt: float) -> None:
    """Contact of fabric with fabric; books the energy in its springs and what its damping takes."""
    if model.self_contact is None:
        return
    state.ledger.self_contact, heat = model.self_contact.add_forces(
        state.pairs, state.positions, state.velocities, dt, state.corner_force
    )
    state.ledger.friction += heat


def add_straps(model: Model, state: State, dt: float) -> None:
    """Strap tensions on the nodes; books their energy, damping, and what torn bars held."""
    straps.add_strap_forces(model.straps, state.positions, state.velocities, state.nodal_force, state.bar)
    if len(state.bar):
        columns = state.bar.T.tolist()
        state.ledger.strap = sum(columns[straps.ENERGY])
        state.ledger.damping += sum(columns[straps.POWER]) * dt
        state.ledger.hysteresis += sum(columns[straps.LOST])


def push_apart(model: Model, state: State, dt: float) -> None:
    """Contact with every obstacle over the coming drift: half of each impulse on the nodes, all of it on the bodies.

    Books the energy in the contact springs, and what friction and contact damping take.
    """
    if not model.obstacles:
        return
    motion = np.empty((len(model.obstacles), 18))
    for row, obstacle, body in zip(motion, model.obstacles, state.bodies, strict=True):
        row[:3], row[3:6], row[6:9] = body.centre, body.velocity, spin(obstacle.body, body)
        row[9:] = body.rotation.ravel()
    reaction = push(
        model.obstacle_table, motion, model.contact_area, state.inverse_mass, state.positions, state.velocities, dt,
        state.contact,
    )  # fmt: skip
    for obstacle, body, back in zip(model.obstacles, state.bodies, reaction, strict=True):
        body.force, body.torque = back[:3].copy(), back[3:].copy()
        rigid_body.advance(obstacle.body, body, model.gravity, dt)
    state.ledger.contact = sum(state.contact.stored.tolist())
    state.ledger.friction += sum(state.contact.dissipated.tolist())
