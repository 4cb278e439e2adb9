"""One explicit step: velocity Verlet (central differences with velocities at full steps).

Half a kick, drift, forces, half a kick; contact is solved over the drift, between the two kicks (Strang splitting), so
that stiff obstacles neither limit the step nor heat the fabric. Every force, and everything else that happens, is a
line below, in the order in which it happens; every line that changes energy books it.
"""

from __future__ import annotations

import numpy as np

from billow.parts.bodies.contact import Nodes
from billow.parts.gas.gas_model import Bag
from billow.parts.part import DAMPING, GRAVITY_WORK, KINETIC, Booking
from billow.solver.model import Model, State
from billow.solver.nodes import gather_and_kick, twice_kinetic


def advance(model: Model, state: State, dt: float) -> None:
    """Advance by dt [s]. On return positions, velocities, forces, parts and ledger all belong to the new time."""
    positions, velocities, ledger = state.positions, state.velocities, state.ledger
    ledger.open()

    if model.driven is not None:  # nodes that no kick moves
        model.driven.drive(state.driven, positions, velocities, state.nodal_force, state.time, dt)
    model.bodies.drive(state.bodies, state.time, dt)
    nodes = Nodes(model.inverse_mass, state.nodal_force, positions, velocities, model.work.before)
    if model.layers is None:
        ledger.book(model.bodies.kick_touch_drift(state.bodies, nodes, dt))
    else:  # contact of layers and of bodies in the same sweeps
        rows = model.bodies.rows(state.bodies, nodes, dt)
        ledger.book(model.layers.part_layers(state.layers, positions, velocities, rows, state.time, dt))
        ledger.book(model.bodies.drift(state.bodies, rows))
    ledger.book(model.bodies.meet(state.bodies, dt))
    ledger.book(gravity_and_damping(model, state, dt))
    ledger.book(model.bodies.move(state.bodies, dt))

    evaluate_forces(model, state, dt)

    if model.driven is not None:
        pushes = state.bodies.contact.force.sum(axis=0)
        if model.layers is not None:
            pushes += state.layers.push / dt
        ledger.book(model.driven.work(state.driven, velocities, state.nodal_force, pushes, model.gravity, dt))
    state.time += dt
    state.step += 1
    ledger.close()


def evaluate_forces(model: Model, state: State, dt: float) -> None:
    """All forces at the end of a step of dt [s] from `state.time`, and the half kick that ends it; velocities are those
    of its middle, and then of its end."""
    positions, velocities, ledger = state.positions, state.velocities, state.ledger
    work, loads = model.work, model.work.loads
    ledger.book(model.fabric.add_forces(state.fabric, positions, velocities, state.time, dt, loads))
    touched = state.bodies.contact.touching
    if model.layers is not None:
        touched = np.vstack((touched, state.layers.touched))
    bag = Bag(model.surface, positions, velocities, touched, work.before, loads.volumes)
    ledger.book(model.gas.advance(state.gas, bag, state.time, dt, loads))
    if model.self_contact is not None:
        ledger.book(model.self_contact.add_forces(state.self_contact, positions, velocities, dt, loads))
    if model.layers is not None:
        ledger.book(model.layers.add_forces(state.layers, positions, velocities, state.time, dt, loads))
    ledger.book(model.straps.add_forces(state.straps, positions, velocities, dt, loads))
    if model.tear_seams is not None:
        ledger.book(model.tear_seams.add_forces(state.tear_seams, positions, velocities, state.time + dt, dt, loads))
    contact = state.bodies.contact
    twice = gather_and_kick(
        len(model.mass), work.gathering, loads.entries, loads.gauge, loads.node_force, work.corners,
        loads.corner_force.reshape(-1, 3), model.mass, model.inverse_mass, model.gravity, 2.0 * model.mass_damping,
        contact.touching, contact.force, 0.5 * dt, velocities, state.nodal_force,
    )  # fmt: skip
    loads.taken()
    ledger.book([(KINETIC, 0.5 * twice)])


def first_forces(model: Model, state: State) -> None:
    """Forces and energies at time zero."""
    model.work.loads.open()
    model.work.before[...] = state.positions[: len(model.work.before)]
    state.ledger.open()
    evaluate_forces(model, state, 0.0)
    state.ledger.book(model.bodies.kinetic_energy(state.bodies))
    state.ledger.close()


def gravity_and_damping(model: Model, state: State, dt: float) -> list[Booking]:
    """Work of gravity on the nodes and of mass damping over the step, from the velocities at its middle."""
    bookings = []
    if model.has_gravity:
        momentum = model.mass @ (state.velocities * (model.inverse_mass > 0.0)[:, None])
        bookings.append(Booking(GRAVITY_WORK, float(model.gravity @ momentum) * dt))
    if model.mass_damping:
        heat = 2.0 * model.mass_damping * twice_kinetic(len(model.mass), model.mass, state.velocities) * dt
        bookings.append(Booking(DAMPING, heat))
    return bookings
