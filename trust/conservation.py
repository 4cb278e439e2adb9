"""Momentum and energy of scenes that nothing outside acts on."""

from __future__ import annotations

import dataclasses

import numpy as np

from billow.apps.verification.scenes import fabric_model
from billow.case.build import build_schedule
from billow.case.fabric.build_fabric import build_fabric
from billow.case.gas.build_gas import build_gas
from billow.case.obstacles.obstacles import build_body
from billow.geometry.bag_shapes import round_bag
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.solver.model import State
from billow.solver.run import run
from trust.scenes import Listener, impact, impact_case


def momentum_error() -> tuple[float, float]:
    """(contact, scene).

    contact: largest unbalanced contact force over the forces themselves. scene: change of the momentum of a floating
    bag with its gas and a free impactor, over the momentum that changed hands.
    """
    case = impact_case().vary({"bag.vents.count": 0, "inflator.jets.count": 0, "obstacles.impactor.clearance": 0.03})
    shape = round_bag(0.35, 10, 0.02)
    gas = build_gas(case, shape).model
    model = fabric_model(shape, build_fabric(case.fabric), gas, bodies=(build_body(case.obstacles[1]),))
    body = model.bodies.bodies[0].rigid
    worst_pair = 0.0
    momenta = []

    def watch(state: State) -> None:
        nonlocal worst_pair
        forces = state.bodies.contact.force[0]
        scale = np.abs(forces).sum()
        if scale > 0.0:
            worst_pair = max(worst_pair, float(np.abs(forces.sum(axis=0) + state.bodies.motion[0].force).max() / scale))
        momenta.append(model.mass @ state.velocities + body.mass * state.bodies.motion[0].velocity)

    last = run(model, build_schedule(case.run), Listener(watch))
    exchanged = body.mass * np.linalg.norm(last.bodies.motion[0].velocity - model.bodies.bodies[0].start.velocity)
    momenta = np.array(momenta)
    return worst_pair, float(np.abs(momenta - momenta[0]).max() / exchanged)


def gas_errors() -> tuple[float, float]:
    """Largest relative error of the gas' mass and energy books over a run with impact and jets."""
    model, schedule = impact()
    totals = model.gas.totals(run(model, schedule, Listener()).gas)
    return totals.mass_error, totals.energy_error


def smooth_energy_error() -> float:
    """Energy residual over the largest energy of a fabric that vibrates without contact or damping."""
    model, schedule = impact("none")
    fabric = dataclasses.replace(model.fabric.membranes[0].fabric, damping=0.0, compression=True)
    membrane = dataclasses.replace(
        model.fabric.membranes[0], fabric=fabric, viscosity=0.0 * model.fabric.membranes[0].viscosity
    )
    radius = np.hypot(model.start[:, 0], model.start[:, 1]) / 0.35
    start = model.start.copy()
    start[:, 2] += 0.01 * np.cos(0.5 * np.pi * np.minimum(radius, 1.0))  # both panels bulge upwards together
    model = dataclasses.replace(
        model,
        start=start,
        fixed=radius > 0.999,
        gas=GasPart(NoGas(), model.surface, start),
        fabric=dataclasses.replace(model.fabric, membranes=(membrane,)),
        bodies=dataclasses.replace(model.bodies, bodies=()),
    )
    schedule = dataclasses.replace(schedule, dt_scale=0.5)
    return run(model, schedule, Listener()).ledger.relative_error
