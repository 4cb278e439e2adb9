"""What a row of histories.csv says: every quantity with its unit in the name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from billow.parts.bodies import rigid_body
from billow.parts.gas.gas_model import GasTotals, LocalGas
from billow.parts.straps import ELONGATION, TENSION
from billow.solver.inspection import shooting_nodes
from billow.solver.model import Model, Obstacle, State


def history_row(model: Model, state: State, sensors: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """Column name -> value at the present time; sensors: where the gas is read [m], by name."""
    row = {"time [s]": state.time, "dt [s]": state.dt}
    row |= _gas(model.gas.totals(state.gas))
    row |= _energy(state)
    if model.birth is not None:
        row["birth_work [J]"] = state.ledger.birth_work
    for k, (obstacle, body) in enumerate(zip(model.obstacles, state.bodies, strict=True)):
        row |= _body(model, obstacle, body)
        row[f"{obstacle.name}_contact [J]"] = float(state.contact.stored[k])
        row[f"{obstacle.name}_penetration [m]"] = float(state.contact.deepest[k])
    for k in range(model.straps.strap_count):
        bars = state.bar[model.straps.strap == k]
        row[f"strap_{k + 1}_tension [N]"] = float(bars[:, TENSION].sum())
        row[f"strap_{k + 1}_elongation [m]"] = float(bars[:, ELONGATION].mean())
    if sensors and isinstance(model.gas, LocalGas):
        row |= _readings(model.gas.at(state.gas, np.array(list(sensors.values()))), list(sensors))
    row["largest_stretch [-]"] = state.largest_stretch
    row["shooting_nodes [-]"] = float(shooting_nodes(model, state))
    return row


def _gas(totals: GasTotals) -> dict[str, float]:
    columns = {
        "pressure [Pa]": totals.pressure,
        "temperature [K]": totals.temperature,
        "volume [m^3]": totals.volume,
        "gas_mass [kg]": totals.mass,
        "gas_energy [J]": totals.energy,
        "injected [kg]": totals.injected,
        "vented [kg]": totals.vented,
        "leaked [kg]": totals.leaked,
        "drawn_in [kg]": totals.drawn_in,
        "enthalpy_in [J]": totals.enthalpy_in,
        "enthalpy_out [J]": totals.enthalpy_out,
        "heat_lost [J]": totals.heat_lost,
        "pressure_work [J]": totals.work,
        "jet_work [J]": totals.jet_work,
        "jet_impulse_in [N s]": totals.jet_impulse_in,
        "jet_impulse_out [N s]": totals.jet_impulse_out,
        "blocked_area [m^2]": totals.blocked_area,
    }
    columns |= {f"{name}_vented [kg]": mass for name, mass in totals.vented_by.items()}
    columns |= {f"{name}_leaked [kg]": mass for name, mass in totals.leaked_by.items()}
    columns |= {f"{name}_passed [kg]": mass for name, mass in totals.passed.items()}
    for chamber in totals.chambers:
        columns |= {
            f"{chamber.name}_pressure [Pa]": chamber.pressure,
            f"{chamber.name}_temperature [K]": chamber.temperature,
            f"{chamber.name}_volume [m^3]": chamber.volume,
            f"{chamber.name}_mass [kg]": chamber.mass,
            f"{chamber.name}_energy [J]": chamber.energy,
        }
    return columns


def _readings(readings: dict[str, np.ndarray], names: list[str]) -> dict[str, float]:
    columns = {}
    for k, name in enumerate(names):
        columns |= {
            f"{name}_gas_pressure [Pa]": float(readings["pressure"][k]),
            f"{name}_gas_temperature [K]": float(readings["temperature"][k]),
            f"{name}_gas_density [kg/m^3]": float(readings["density"][k]),
        }
        columns |= {
            f"{name}_gas_velocity_{a} [m/s]": float(v) for a, v in zip("xyz", readings["velocity"][k], strict=True)
        }
    return columns


def _energy(state: State) -> dict[str, float]:
    ledger = state.ledger
    return {
        "kinetic [J]": ledger.kinetic,
        "body_kinetic [J]": ledger.body_kinetic,
        "strain [J]": ledger.strain,
        "strap [J]": ledger.strap,
        "contact [J]": ledger.contact,
        "damping [J]": ledger.damping,
        "hysteresis [J]": ledger.hysteresis,
        "friction [J]": ledger.friction,
        "gas_work [J]": ledger.gas_work,
        "gravity_work [J]": ledger.gravity_work,
        "energy_residual [J]": ledger.residual,
    }


def _body(model: Model, obstacle: Obstacle, body: rigid_body.RigidState) -> dict[str, float]:
    columns = {f"{obstacle.name}_force_{axis} [N]": float(body.force[k]) for k, axis in enumerate("xyz")}
    if obstacle.body.locked:
        return columns
    acceleration = body.force / obstacle.body.mass + model.gravity
    spin = rigid_body.spin(obstacle.body, body)
    vectors = (
        ("centre", "m", body.centre),
        ("velocity", "m/s", body.velocity),
        ("acceleration", "m/s^2", acceleration),
        ("spin", "rad/s", spin),
    )
    for name, unit, vector in vectors:
        columns |= {f"{obstacle.name}_{name}_{a} [{unit}]": float(v) for a, v in zip("xyz", vector, strict=True)}
    quaternion = zip("wxyz", np.asarray(body.quaternion), strict=True)
    return columns | {f"{obstacle.name}_quaternion_{part} [-]": float(v) for part, v in quaternion}
