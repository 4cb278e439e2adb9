"""Uniform pressure: one well-mixed gas fills the bag (Wang and Nefske 1988, with species and cp(T)).

A step (physics notes, section 1): rates from the old state; work W = (p_old + p_new)/2 dV with p_new found by
iteration; U_new = U + H_in - H_out - W - W_jets; temperature from U, pressure from p V = T sum(m_i R_i). The same
numbers that change the state are added to the running sums, and the sums are checked against the state every step.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.compiled import scalar
from billow.gas.gas_model import Bag, GasTotals
from billow.gas.inflator import Inflator, delivered_mass, interpolate
from billow.gas.jets import UPDATE_INTERVAL, JetPattern, Jets, add_jet_force, aim
from billow.gas.mixture import mixture_cp, mixture_enthalpy, mixture_gas_constant, mixture_temperature
from billow.gas.outflow import orifice_flux, porous_flux
from billow.gas.pressure_load import add_pressure

PRESSURE_ITERATIONS = 3


@dataclass(frozen=True)
class Ambient:
    """Still air outside: pressure [Pa], temperature [K], mass_fractions (species,) in the order of the gas."""

    pressure: float
    temperature: float
    mass_fractions: np.ndarray


@dataclass(frozen=True)
class Vents:
    """Vent holes, closed by virtual triangles.

    triangles: (n, 3) uint32 of all vents, one vent after the other; start: (vents + 1,) int64.
    discharge: coefficient of each vent [-], (vents,); opening: gauge pressure [Pa] at which it opens for good,
    (vents,).
    """

    triangles: np.ndarray
    start: np.ndarray
    discharge: np.ndarray
    opening: np.ndarray


@dataclass(frozen=True)
class Porosity:
    """Leakage through fabric: permeability [-] times reference_speed [m/s] at reference_difference [Pa], over area
    [m^2]."""

    permeability: float
    area: float
    reference_speed: float = 1.0
    reference_difference: float = 500.0


@dataclass
class UniformState:
    """Everything about the gas that changes; units as in GasTotals."""

    masses: np.ndarray
    energy: float
    volume: float
    pressure: float
    temperature: float
    vent_open: np.ndarray
    vented_by: np.ndarray
    start_mass: float
    start_energy: float
    start_volume: float
    triangle_count: int
    pattern: JetPattern
    next_aim: float
    injected: float = 0.0
    leaked: float = 0.0
    drawn_in: float = 0.0
    enthalpy_in: float = 0.0
    enthalpy_out: float = 0.0
    work: float = 0.0
    jet_work: float = 0.0
    jet_impulse_in: float = 0.0
    jet_impulse_out: float = 0.0
    mass_error: float = 0.0
    energy_error: float = 0.0


@dataclass(frozen=True)
class UniformPressure:
    """Parameters of the gas; see the classes they belong to. table: (species, 16), species.thermo_table."""

    table: np.ndarray
    species_names: tuple[str, ...]
    inflator: Inflator
    ambient: Ambient
    vents: Vents
    porosity: Porosity
    jets: Jets | None = None
    cumulative: np.ndarray = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "cumulative", self.inflator.cumulative)

    def start(self, bag: Bag) -> UniformState:
        """Ambient air in the start shape."""
        volume = bag.surface.volume(bag.positions)
        fractions = self.ambient.mass_fractions
        specific = mixture_gas_constant(self.table, fractions)
        mass = self.ambient.pressure * volume / (specific * self.ambient.temperature)
        masses = mass * fractions
        energy = (
            mixture_enthalpy(self.table, masses, self.ambient.temperature) - mass * specific * self.ambient.temperature
        )
        vents = len(self.vents.discharge)
        pattern = JetPattern(np.empty(0, np.int64), np.empty(0), 0)
        return UniformState(
            masses, energy, volume, self.ambient.pressure, self.ambient.temperature, np.zeros(vents, np.bool_),
            np.zeros(vents), float(masses.sum()), energy, volume, bag.surface.triangle_count,
            pattern, 0.0,
        )  # fmt: skip

    def advance(self, gas: UniformState, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        volume = bag.surface.volume(bag.positions)
        jet_work = self._blow(gas, bag, time, dt, corner_force)
        inflator, porosity = self.inflator, self.porosity
        (
            gas.energy, gas.temperature, gas.pressure, injected, leaked, drawn_in, enthalpy_in, enthalpy_out, work,
        ) = _advance_chamber(
            self.table, gas.masses, gas.energy, gas.volume, gas.pressure, gas.temperature, volume, jet_work, time, dt,
            inflator.flow_time, inflator.mass_flow, self.cumulative, inflator.temperature_time, inflator.temperature,
            inflator.mass_fractions, self.ambient.pressure, self.ambient.temperature, self.ambient.mass_fractions,
            self.vents.triangles, self.vents.start, self.vents.discharge, self.vents.opening, bag.positions,
            gas.vent_open, gas.vented_by, porosity.permeability, porosity.area, porosity.reference_speed,
            porosity.reference_difference,
        )  # fmt: skip
        gas.volume = volume
        gas.injected += injected
        gas.leaked += leaked
        gas.drawn_in += drawn_in
        gas.enthalpy_in += enthalpy_in
        gas.enthalpy_out += enthalpy_out
        gas.work += work
        gas.jet_work += jet_work
        self._close_ledger(gas, time + dt)
        add_pressure(bag.surface.triangles, bag.positions, gas.pressure - self.ambient.pressure, corner_force)

    def _blow(self, gas, bag, time, dt, corner_force) -> float:
        """Add the jets' force; returns their work [J] in this step."""
        if self.jets is None:
            return 0.0
        after = time + dt
        flow_time = self.inflator.flow_time
        flow = interpolate(flow_time, self.inflator.mass_flow, after)
        if not flow_time[0] < after < flow_time[-1] or flow <= 0.0:
            return 0.0
        if after >= gas.next_aim:
            gas.pattern = aim(self.jets, bag.surface.triangles, bag.positions)
            gas.next_aim = after + UPDATE_INTERVAL
        count = self.jets.ring.count
        thrust = flow / count * jet_speed(
            self.table, self.inflator.mass_fractions,
            interpolate(self.inflator.temperature_time, self.inflator.temperature, after),
        )  # fmt: skip
        mouth_velocity = bag.velocities[self.jets.mouth_nodes[0]]  # the inflator is rigid: any of its nodes will do
        power = add_jet_force(
            gas.pattern, thrust, bag.surface.triangles, bag.positions, bag.velocities, mouth_velocity, corner_force
        )
        gas.jet_impulse_in += count * thrust * dt
        gas.jet_impulse_out += gas.pattern.seen * thrust * dt
        return power * dt

    def _close_ledger(self, gas: UniformState, time: float) -> None:
        """Mass against the inflator's closed form, energy against the sums; keeps the largest relative error."""
        delivered = delivered_mass(self.inflator.flow_time, self.inflator.mass_flow, self.cumulative, time)
        mass = gas.masses.sum()
        mass_gap = mass + gas.vented_by.sum() + gas.leaked - gas.start_mass - delivered - gas.drawn_in
        mass_scale = gas.start_mass + delivered + gas.drawn_in
        energy_gap = gas.energy - gas.start_energy - gas.enthalpy_in + gas.enthalpy_out + gas.work + gas.jet_work
        energy_scale = gas.start_energy + gas.enthalpy_in
        gas.mass_error = max(gas.mass_error, abs(mass_gap) / mass_scale)
        gas.energy_error = max(gas.energy_error, abs(energy_gap) / energy_scale)

    def totals(self, gas: UniformState) -> GasTotals:
        return GasTotals(
            pressure=gas.pressure,
            temperature=gas.temperature,
            volume=gas.volume,
            mass_by_species=gas.masses.copy(),
            energy=gas.energy,
            injected=gas.injected,
            vented=float(gas.vented_by.sum()),
            leaked=gas.leaked,
            drawn_in=gas.drawn_in,
            enthalpy_in=gas.enthalpy_in,
            enthalpy_out=gas.enthalpy_out,
            work=gas.work,
            ambient_work=self.ambient.pressure * (gas.volume - gas.start_volume),
            jet_work=gas.jet_work,
            jet_impulse_in=gas.jet_impulse_in,
            jet_impulse_out=gas.jet_impulse_out,
            mass_error=gas.mass_error,
            energy_error=gas.energy_error,
        )

    def fields(self, gas: UniformState) -> dict[str, np.ndarray]:
        return {"pressure": np.full(gas.triangle_count, gas.pressure - self.ambient.pressure)}


@scalar
def jet_speed(table, mass_fractions, temperature):
    """Speed [m/s] of a choked jet from total temperature [K]: sqrt(2 g/(g+1) R T)."""
    gas_constant = mixture_gas_constant(table, mass_fractions)
    cp = mixture_cp(table, mass_fractions, temperature)
    gamma = cp / (cp - gas_constant)
    return np.sqrt(2.0 * gamma / (gamma + 1.0) * gas_constant * temperature)


@scalar
def patch_area(triangles, first, last, positions):
    """Area [m^2] of triangles first..last."""
    total = 0.0
    for i in range(first, last):
        a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        ux, uy, uz = (
            positions[b, 0] - positions[a, 0], positions[b, 1] - positions[a, 1], positions[b, 2] - positions[a, 2],
        )  # fmt: skip
        wx, wy, wz = (
            positions[c, 0] - positions[a, 0], positions[c, 1] - positions[a, 1], positions[c, 2] - positions[a, 2],
        )  # fmt: skip
        nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        total += 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    return total


@scalar
def _advance_chamber(
    table, masses, energy, volume_old, pressure, temperature, volume, jet_work, time, dt,
    flow_time, mass_flow, cumulative, temperature_time, inflow_temperature, inflow_fractions,
    ambient_pressure, ambient_temperature, ambient_fractions,
    vent_triangles, vent_start, vent_discharge, vent_opening, positions, vent_open, vented_by,
    permeability, porous_area, reference_speed, reference_difference,
):  # fmt: skip
    """One step of one chamber; changes masses, vent_open and vented_by in place."""
    mass = masses.sum()
    gas_constant = mixture_gas_constant(table, masses) / mass
    cp = mixture_cp(table, masses, temperature) / mass
    gamma = cp / (cp - gas_constant)
    outward = pressure >= ambient_pressure
    if outward:
        upstream, downstream = pressure, ambient_pressure
        upstream_gamma, upstream_rt = gamma, gas_constant * temperature
    else:
        upstream, downstream = ambient_pressure, pressure
        air_constant = mixture_gas_constant(table, ambient_fractions)
        air_cp = mixture_cp(table, ambient_fractions, ambient_temperature)
        upstream_gamma, upstream_rt = air_cp / (air_cp - air_constant), air_constant * ambient_temperature

    # Rates from the old state.
    flux = orifice_flux(upstream, downstream, upstream_gamma, upstream_rt)
    through_fabric = (
        dt * porous_area
        * porous_flux(
            upstream - downstream, upstream / upstream_rt, permeability, reference_speed, reference_difference
        )
    )  # fmt: skip
    through_vents = 0.0
    vent_count = len(vent_discharge)
    for k in range(vent_count):
        if pressure - ambient_pressure >= vent_opening[k]:
            vent_open[k] = True
        if vent_open[k]:
            area = patch_area(vent_triangles, vent_start[k], vent_start[k + 1], positions)
            through_vents += dt * vent_discharge[k] * area * flux
    # A step never takes more than half of what is there; only a mistaken input comes near this.
    limit = 1.0
    if outward and through_vents + through_fabric > 0.5 * mass:
        limit = 0.5 * mass / (through_vents + through_fabric)
    total = limit * (through_vents + through_fabric)
    through_fabric *= limit

    leaked, drawn_in = 0.0, 0.0
    enthalpy_in, enthalpy_out = 0.0, 0.0
    if outward:
        leaked = through_fabric
        enthalpy_out = total * mixture_enthalpy(table, masses, temperature) / mass
        for k in range(vent_count):
            if vent_open[k]:
                area = patch_area(vent_triangles, vent_start[k], vent_start[k + 1], positions)
                vented_by[k] += limit * dt * vent_discharge[k] * area * flux
        keep = 1.0 - total / mass
        for i in range(len(masses)):
            masses[i] *= keep
    else:
        drawn_in = total
        enthalpy_in = total * mixture_enthalpy(table, ambient_fractions, ambient_temperature)
        for i in range(len(masses)):
            masses[i] += total * ambient_fractions[i]

    injected = delivered_mass(flow_time, mass_flow, cumulative, time + dt) - delivered_mass(
        flow_time, mass_flow, cumulative, time
    )
    inflow = interpolate(temperature_time, inflow_temperature, time + 0.5 * dt)
    enthalpy_in += injected * mixture_enthalpy(table, inflow_fractions, inflow)
    for i in range(len(masses)):
        masses[i] += injected * inflow_fractions[i]

    new_constant = mixture_gas_constant(table, masses)
    heated = energy + enthalpy_in - enthalpy_out - jet_work
    new_pressure = pressure * (volume_old / volume) ** gamma
    new_temperature, work = temperature, 0.0
    for _ in range(PRESSURE_ITERATIONS):
        work = 0.5 * (pressure + new_pressure) * (volume - volume_old)
        new_temperature = mixture_temperature(table, masses, heated - work, new_temperature)
        new_pressure = new_constant * new_temperature / volume
    return (
        heated - work, new_temperature, new_pressure, injected, leaked, drawn_in, enthalpy_in, enthalpy_out, work,
    )  # fmt: skip
