"""One explicit step: velocity Verlet (central differences with velocities at full steps).

Half a kick, drift, forces, half a kick; contact is solved over the drift, between the two kicks (Strang splitting), so
that stiff obstacles neither limit the step nor heat the fabric.
"""

from __future__ import annotations

from billow.parts.bodies import rigid_body
from billow.solver.forces import evaluate_forces, push_apart
from billow.solver.model import Model, State
from billow.solver.nodes import drift, half_kick, kinetic_energy, last_kick


def advance(model: Model, state: State, dt: float) -> None:
    """Advance by dt [s]. On return positions, velocities, forces, gas and ledger all belong to the new time."""
    half_kick(state.inverse_mass, state.nodal_force, dt, state.velocities)
    push_apart(model, state, dt)
    drift(dt, state.velocities, state.positions)

    book_motion(model, state, dt)
    evaluate_forces(model, state, state.time, dt)

    contact = state.contact
    state.ledger.kinetic = last_kick(
        model.mass, state.inverse_mass, state.nodal_force, contact.touching, contact.force, dt, state.velocities
    )
    state.time += dt
    state.step += 1
    close_ledger(model, state)


def book_motion(model: Model, state: State, dt: float) -> None:
    """Work of gravity and mass damping over the step, from the velocities at its middle."""
    ledger = state.ledger
    if model.has_gravity:
        momentum = model.mass @ (state.velocities * (state.inverse_mass > 0.0)[:, None])
        ledger.gravity_work += float(model.gravity @ momentum) * dt
        for obstacle, body in zip(model.obstacles, state.bodies, strict=True):
            if not obstacle.body.locked:  # the body has its new velocity already
                middle = body.velocity - 0.5 * dt * (body.force / obstacle.body.mass + model.gravity)
                ledger.gravity_work += float(obstacle.body.mass * model.gravity @ middle) * dt
    if model.mass_damping:
        ledger.damping += 4.0 * model.mass_damping * kinetic_energy(model.mass, state.velocities) * dt


def close_ledger(model: Model, state: State) -> None:
    """The bodies' kinetic energy, the work of the gas, and the balance at the current time."""
    ledger = state.ledger
    ledger.body_kinetic = sum(
        rigid_body.kinetic_energy(o.body, b) for o, b in zip(model.obstacles, state.bodies, strict=True)
    )
    totals = model.gas.totals(state.gas)
    ledger.gas_work, ledger.gas_temperature = totals.work_on_fabric, totals.temperature
    if totals.energy:  # without gas a chamber may have any volume
        rooms = zip(totals.chambers or (totals,), model.start_volumes, strict=True)
        ledger.gas_volume = min(room.volume / start for room, start in rooms)
    ledger.close()


def stable_dt(model: Model, state: State) -> float:
    """Largest step [s] every part tolerates at the present stretch.

    Fabric: 0.75 h_min/c (sqrt(1 + xi^2) - xi); 0.75 lies below the exact bound of a lumped-mass triangle, 0.827 h/c
    for an equilateral one. Strap springs add to a node's stiffness: their squared frequencies add. Contact sets no
    limit; the gas has its own.
    """
    fabric = min((0.75 * m.stable_dt(state.largest_stretch) for m in model.membranes), default=float("inf"))
    stiffness = model.straps.nodal_stiffness(len(model.mass))
    squared_frequency = float((stiffness * state.inverse_mass).max())
    squared = 1.0 / fabric**2 + 0.25 * squared_frequency / 0.9**2
    structure = squared**-0.5 if squared > 0.0 else float("inf")
    return min(structure, model.gas.stable_dt(state.gas))
