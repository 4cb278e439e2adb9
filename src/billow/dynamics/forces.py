"""All forces, in the order they act. Who wants to know what pushes on the fabric reads this file.

Contact is solved over the drift of a step (`push_apart`); everything else is evaluated at its end (`evaluate_forces`).
"""

from __future__ import annotations

import numpy as np

from billow.contact.rigid_contact import push
from billow.dynamics.model import Model, State
from billow.dynamics.nodes import gather
from billow.fabric import straps
from billow.fabric.fabric import ENERGY, HYSTERESIS, POWER, STRETCH
from billow.fabric.membrane import Membrane
from billow.gas.gas_model import Bag
from billow.impactor import rigid_body
from billow.impactor.rigid_body import spin


def evaluate_forces(model: Model, state: State, time: float, dt: float) -> None:
    """Forces at the new positions of a step from `time` to `time + dt` [s]; velocities are those of its middle."""
    state.corner_force.fill(0.0)
    touched = state.contact.touching.any(axis=0)
    bag = Bag(model.surface, state.positions, state.velocities, touched)
    model.gas.advance(state.gas, bag, time, dt, state.corner_force)
    add_membrane_forces(model, state, dt)
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
        total = sums.sum(axis=0)
        state.ledger.strain += float(total[ENERGY])
        state.ledger.damping += float(total[POWER]) * dt
        state.ledger.hysteresis += float(total[HYSTERESIS])
        largest = max(largest, float(sums[:, STRETCH].max()))
    state.largest_stretch = float(np.sqrt(largest))


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


def add_straps(model: Model, state: State, dt: float) -> None:
    """Strap tensions on the nodes; books their energy, damping, and what torn bars held."""
    straps.add_strap_forces(model.straps, state.positions, state.velocities, state.nodal_force, state.bar)
    if len(state.bar):
        state.ledger.strap = float(state.bar[:, straps.ENERGY].sum())
        state.ledger.damping += float(state.bar[:, straps.POWER].sum()) * dt
        state.ledger.hysteresis += float(state.bar[:, straps.LOST].sum())


def push_apart(model: Model, state: State, dt: float) -> None:
    """Contact with every obstacle over the coming drift: half of each impulse on the nodes, all of it on the bodies.

    Books the energy in the contact springs, and what friction and contact damping take.
    """
    if not model.obstacles:
        return
    motion = np.array(
        [
            [*body.centre, *body.velocity, *spin(obstacle.body, body), *body.rotation.ravel()]
            for obstacle, body in zip(model.obstacles, state.bodies, strict=True)
        ]
    )
    reaction = push(
        model.obstacle_table, motion, model.contact_area, state.inverse_mass, state.positions, state.velocities, dt,
        state.contact,
    )  # fmt: skip
    for obstacle, body, back in zip(model.obstacles, state.bodies, reaction, strict=True):
        body.force, body.torque = back[:3].copy(), back[3:].copy()
        rigid_body.advance(obstacle.body, body, model.gravity, dt)
    state.ledger.contact = float(state.contact.stored.sum())
    state.ledger.friction += float(state.contact.dissipated.sum())
