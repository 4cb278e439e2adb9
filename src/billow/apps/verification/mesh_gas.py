"""T1m, T3m, T5m, T12, T14 and M1 to M3: the mesh gas in closed bags against closed forms (docs/theory.md, Verification
cases). Walls stand still or are moved by hand; the gas is advanced by `MeshGas.advance`, as in a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import (
    DEPTH,
    GAMMA,
    GAS_CONSTANT,
    HEIGHT,
    IDEAL,
    VOLUME,
    WHOLE,
    WIDTH,
    boxes_in_a_row,
    inflow,
    supply,
)
from billow.apps.verification.scenes import bag_of_height, sphere
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.mesh_gas import MeshGas
from billow.parts.gas.mesh.setup import DONOR, VAN_LEER
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import JetRing
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.outflow import ORIFICE, jet_speed
from billow.parts.gas.supply.passages import VENT, Passage
from billow.parts.gas.supply.species import Species
from billow.parts.gas.supply.supply import Source
from billow.parts.part import Loads

ATMOSPHERE, WARM = 1e5, 300.0
SOUND = math.sqrt(GAMMA * GAS_CONSTANT * WARM)
SCHEMES = (DONOR, VAN_LEER)


def mesh_in(
    bag: Bag, cell: float, advection: str = VAN_LEER, pressure: float = ATMOSPHERE, temperature: float = WARM,
    sources: tuple[Source, ...] = (), passages: tuple[Passage, ...] = (), outside: float = 0.0,
    species: list[Species] = IDEAL, **more,
) -> MeshGas:  # fmt: skip
    """The gas in a bag, with this pressure [Pa] and temperature [K] inside and `outside` [Pa] around; more: further
    fields of `Supply`."""
    chambers = bag.surface.chambers
    inside = InitialGas.like(Ambient(pressure, temperature, WHOLE), chambers.count)
    fed = supply(
        species, Ambient(max(outside, 1e-6), WARM, WHOLE), sources, chambers, passages, **({"initial": inside} | more)
    )
    return MeshGas(fed, bag.surface, 1.0, cell, advection)


def moved(
    gas: MeshGas, state: MeshState, at: Callable[[float], np.ndarray], end: float, share: float = 0.99,
    longest: float = math.inf,
) -> Iterator[float]:  # fmt: skip
    """Advance to the time `end` [s] with the surface at(time) [m], (nodes, 3), in steps of a share of the gas' longest,
    or of `longest` [s]; yields the time after each."""
    loads, time = Loads(0, gas.surface), state.time
    while time < end * (1.0 - 1e-12):
        dt = min(share * gas.longest_part(state), longest, end - time)
        after = at(time + dt)
        velocity = (after - state.positions) / dt
        loads.open()
        gas.advance(state, Bag(gas.surface, after, velocity, before=state.positions), time, dt, loads)
        time += dt
        yield time


def still(gas: MeshGas, state: MeshState, end: float) -> Iterator[float]:
    """Likewise, with a surface that stands still."""
    positions = state.positions.copy()
    return moved(gas, state, lambda time: positions, end)


def force_on(gas: MeshGas, state: MeshState, part: str) -> np.ndarray:
    """Absolute force of the gas [N] on a part of a single chamber, (3,)."""
    return state.sheets[0].force[gas.surface.triangles_of(part)].sum(axis=(0, 1))


def thermal(state: MeshState) -> float:
    """Energy [J] of the gas of a single chamber, less that of its flow."""
    held = state.sheets[0].held
    return state.sheets[0].energy - 0.5 * float((held[:, -4:-1] ** 2).sum(axis=1) @ (1.0 / held[:, :-4].sum(axis=1)))


def books(state: MeshState) -> Iterator[Measurement]:
    """Nothing lost."""
    yield Measurement("largest mass error [absolute]", state.mass_error, 0.0, 1e-12)
    yield Measurement("largest energy error [absolute]", state.energy_error, 0.0, 1e-11)
    yield Measurement("clusters without room", state.lost, 0.0, 0.5)


def carry(state: MeshState, velocity: np.ndarray) -> None:
    """Let gas at rest move with a velocity [m/s], (3,)."""
    for sheet in state.sheets:
        mass = sheet.held[:, :-4].sum(axis=1)
        sheet.held = sheet.held.copy()
        sheet.held[:, -4:-1] = mass[:, None] * velocity
        sheet.held[:, -1] += 0.5 * mass * float(velocity @ velocity)
    state.start_energy = sum(sheet.energy for sheet in state.sheets)


def mouth(bag: Bag, ring: JetRing) -> Jets:
    """The floor of a box as a mouth with a ring of jets."""
    floor = np.flatnonzero(bag.positions[:, 2] == bag.positions[:, 2].min())
    return Jets(ring, floor, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))


def rigid_tank() -> Iterator[Measurement]:
    """T1m: as T1, from a hundredth of a pascal, blown in without thrust. What still flows is 1e-4 of the energy."""
    bag = bag_of_height(HEIGHT)
    for scheme in SCHEMES:
        source = Source(inflow(1.0, 0.030, 600.0, WHOLE), mouth(bag, JetRing(0, 0.02, 0.01, 0.0)), diffuse=True)
        gas = mesh_in(bag, 0.1, scheme, 0.01, sources=(source,))
        state = gas.start(bag)
        for _ in still(gas, state, 0.032):
            pass
        final, mass = GAMMA * 600.0, 0.030
        warmth = thermal(state) * (GAMMA - 1.0) / (mass * GAS_CONSTANT)
        yield Measurement(f"temperature of the tank, {scheme} [K]", warmth, final, 1e-3)
        pressure = gas.totals(state).pressure
        yield Measurement(f"pressure of the tank, {scheme} [Pa]", pressure, mass * GAS_CONSTANT * final / VOLUME, 1e-3)
        yield from books(state)


def choked_blow_down() -> Iterator[Measurement]:
    """T3m: as T3, through the lid, an orifice that feels its stagnation pressure."""
    bag = bag_of_height(HEIGHT)
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=bag.surface.triangles_of("lid"), area=1e-3)
    gas = mesh_in(bag, 0.1, DONOR, 5e5, 600.0, passages=(hole,), outside=101325.0)
    state, before = gas.start(bag), (0.0, 5e5)
    start = state.start_masses.sum()
    for time in still(gas, state, 0.2):
        pressure = gas.totals(state).pressure
        if pressure <= 2e5:
            break
        before = time, pressure
    share = (before[1] - 2e5) / (before[1] - pressure)
    now = gas.totals(state)
    yield Measurement("time to 2 bar [s]", before[0] + share * (time - before[0]), 0.14770, 2e-2)
    yield Measurement("temperature at 2 bar [K]", now.temperature, 461.8, 2e-2)
    yield Measurement("mass left at 2 bar, relative", now.mass / start, 0.5197, 2e-2)
    yield from books(state)


def isentropic_compression() -> Iterator[Measurement]:
    """T5m: a sphere is squeezed to half its volume within 30 ms."""
    shape = sphere(0.25, 3)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))

    def at(time):
        return shape.positions * _eased(1.0, 0.5 ** (1.0 / 3.0), time / 0.03)

    for scheme in SCHEMES:
        gas = mesh_in(bag, 0.05, scheme)
        state = gas.start(bag)
        start = state.volume[0]
        for _ in moved(gas, state, at, 0.03):
            pass
        ratio = start / state.volume[0]
        pressure = thermal(state) * (GAMMA - 1.0) / state.volume[0]
        yield Measurement(f"pressure ratio, {scheme} [-]", pressure / ATMOSPHERE, ratio**GAMMA, 1e-3)
        yield from books(state)


def at_rest() -> Iterator[Measurement]:
    """T12: gas at rest in a sphere that cuts cells of all sizes; 50 steps."""
    shape = sphere(0.25, 3)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    gas = mesh_in(bag, 0.03, pressure=1.3e5, temperature=400.0)
    state = gas.start(bag)
    for k, _ in enumerate(still(gas, state, 1.0)):
        if k == 50:
            break
    cells = gas.cells(state)
    yield Measurement("largest pressure [Pa]", cells["pressure"].max(), 1.3e5, 1e-12)
    yield Measurement("least pressure [Pa]", cells["pressure"].min(), 1.3e5, 1e-12)
    density = 1.3e5 / (GAS_CONSTANT * 400.0)
    yield Measurement("largest density [kg/m^3]", cells["density"].max(), density, 1e-12)
    yield Measurement("largest Mach number [absolute]", np.abs(cells["velocity"]).max() / 400.0, 0.0, 1e-12)
    force = state.sheets[0].force
    net = np.abs(force.sum(axis=(0, 1))).max() / np.abs(force).sum()
    yield Measurement("net force, relative [absolute]", net, 0.0, 1e-13)


def layers_in_a_cell() -> Iterator[Measurement]:
    """T14: two chambers of 5 mm in cells of 20 mm, at 200 and 120 kPa. What the one holds changes no digit of the
    other, at rest and at 30 m/s through the lattice."""
    bag = boxes_in_a_row((0.005, 0.005))
    for speed in (0.0, 30.0):
        found = []
        for other in (1.2e5, 3.7e5):
            shares = InitialGas(np.array([2e5, other]), np.full(2, WARM), np.tile(WHOLE, (2, 1)))
            gas = mesh_in(bag, 0.02, initial=shares)
            state = gas.start(bag)
            carry(state, np.array([speed, 0.4 * speed, 0.0]))

            def at(time, v=speed):
                return bag.positions + np.array([v * time, 0.4 * v * time, 0.0])

            for _ in moved(gas, state, at, 5e-4, longest=1e-5):
                pass
            found.append((state.sheets[0].held.copy(), gas.totals(state), state))
        first, second = found
        gap = np.abs(first[0] - second[0]).max() / np.abs(first[0]).max()
        yield Measurement(f"what one feels of the other at {speed:g} m/s [absolute]", gap, 0.0, 1e-12)
        rooms = first[1].chambers
        exact = 1e-12 if speed == 0.0 else 1e-6
        yield Measurement(f"pressure of the first at {speed:g} m/s [Pa]", rooms[0].pressure, 2e5, exact)
        yield Measurement(f"pressure of the second at {speed:g} m/s [Pa]", rooms[1].pressure, 1.2e5, exact)
        yield from books(first[2])


def breathing_sphere() -> Iterator[Measurement]:
    """M1: a sphere of mass m, in ambient air of the same pressure, breathes with omega^2 = gamma p A^2/(m V) for small
    amplitudes; three cycles. Sound is fast: omega R/c = 0.2, which lowers omega by (omega R/c)^2/30 = 0.13 %."""
    shape = sphere(0.25, 3)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    gas = mesh_in(bag, 0.05, outside=ATMOSPHERE)
    state = gas.start(bag)
    volume = state.volume[0]
    area = 3.0 * volume / 0.25  # of x R: dV/dR
    omega = 0.2 * SOUND / 0.25
    mass, amplitude = GAMMA * ATMOSPHERE * area**2 / (omega**2 * volume), 2e-3
    radius, speed, end = 0.25 * (1.0 + amplitude), 0.0, 6.2 * math.pi / omega
    positions = shape.positions / 0.25
    loads, times, radii, time = Loads(0, gas.surface), [], [], 0.0
    for _ in moved(
        gas, state, lambda t: positions * _eased(0.25, radius, t / 0.02), 0.02
    ):  # so slowly that it is silent
        pass
    begin = state.time

    def push() -> float:
        force = state.sheets[0].force
        inside = float(np.sum(force * positions[gas.surface.triangles]))
        return inside - ATMOSPHERE * area * (radius / 0.25) ** 2

    now = push()
    while time < end:
        dt = 0.9 * gas.longest_part(state)
        speed += 0.5 * dt * now / mass
        radius += dt * speed
        after = positions * radius
        velocity = (after - state.positions) / dt
        loads.open()
        gas.advance(state, Bag(gas.surface, after, velocity, before=state.positions), begin + time, dt, loads)
        now = push()
        speed += 0.5 * dt * now / mass
        time += dt
        times.append(time)
        radii.append(radius / 0.25 - 1.0)
    frequency, first, last = _cycles(np.array(times), np.array(radii), omega)
    yield Measurement("circular frequency [1/s]", frequency, omega * (1.0 - 0.04 / 30.0), 5e-3)
    yield Measurement("amplitude after three cycles, relative", last / first, 1.0, 1e-2)
    yield from books(state)


def _eased(start: float, end: float, share: float) -> float:
    """From start to end without a jerk."""
    return start + (end - start) * 0.5 * (1.0 - math.cos(math.pi * share))


def _cycles(times: np.ndarray, values: np.ndarray, omega: float) -> tuple[float, float, float]:
    """Circular frequency [1/s] of a damped oscillation that begins at its crest, and its amplitudes in the first half
    cycle and three cycles later, by fits of a sine to windows of one cycle."""
    period = 2.0 * math.pi / omega
    phases, sizes, middles = [], [], []
    for centre in (0.55, 2.55):
        window = np.abs(times / period - centre) <= 0.5
        t = times[window]
        waves = np.column_stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t)])
        (a, b, _), *_ = np.linalg.lstsq(waves, values[window], rcond=None)
        phases.append(math.atan2(b, a))
        sizes.append(math.hypot(a, b))
        middles.append(t.mean())
    drift = (phases[1] - phases[0] + math.pi) % (2.0 * math.pi) - math.pi
    return omega - drift / (middles[1] - middles[0]), sizes[0], sizes[0] * (sizes[1] / sizes[0]) ** 1.5


def jet_on_a_plate() -> Iterator[Measurement]:
    """M2: a jet blows through the floor of a box; the force on all walls over time, and the momentum of the gas in the
    end, are together mdot u over time, at the longest step of the gas as at half of it."""
    flow, end = 0.4, 0.02
    for share in (0.99, 0.5):
        bag = bag_of_height(HEIGHT)
        inflator = inflow(flow, end, 600.0, WHOLE)
        gas = mesh_in(bag, 0.05, sources=(Source(inflator, mouth(bag, JetRing(1, 1e-3, 0.02, 0.0))),))
        state = gas.start(bag)
        impulse, before, time_before = np.zeros(3), state.sheets[0].force.sum(axis=(0, 1)), 0.0
        positions = state.positions.copy()
        for time in moved(gas, state, lambda _, places=positions: places, end, share):
            now = state.sheets[0].force.sum(axis=(0, 1))
            impulse += 0.5 * (time - time_before) * (before + now)
            before, time_before = now, time
        impulse += state.sheets[0].held[:, -4:-1].sum(axis=0)
        exact = flow * end * jet_speed(gas.table, WHOLE, 600.0)
        yield Measurement(f"impulse of the jet, {share:g} of the longest step [N s]", impulse[2], exact, 1e-3)
        yield Measurement("impulse across it [N s, absolute]", np.abs(impulse[:2]).max(), 0.0, 1e-3 * exact)
        yield from books(state)


def turned_bag() -> Iterator[Measurement]:
    """M3: a box turned by 30 degrees about a skew axis, blown up through its floor, open at its lid, fills alike."""
    axis = np.array([1.0, 2.0, 0.5]) / math.sqrt(5.25)
    skew = np.cross(np.eye(3), axis)
    turn = np.eye(3) + math.sin(math.pi / 6.0) * skew + (1.0 - math.cos(math.pi / 6.0)) * skew @ skew
    found = []
    for rotation in (np.eye(3), turn):
        bag = bag_of_height(0.5)
        jets = mouth(bag, JetRing(1, 1e-3, 0.02, 0.0))
        jets = Jets(jets.ring, jets.mouth_nodes, rotation @ jets.axis, rotation @ jets.zero)
        positions = np.ascontiguousarray(bag.positions @ rotation.T)
        turned = Bag(bag.surface, positions, np.zeros_like(positions))
        hole = Passage("hole", VENT, ORIFICE, 0, triangles=bag.surface.triangles_of("lid"), area=5e-4)
        source = Source(inflow(1.0, 0.01, 600.0, WHOLE), jets, diffuse=True)
        gas = mesh_in(turned, 0.025, sources=(source,), passages=(hole,), outside=ATMOSPHERE)
        state = gas.start(turned)
        for _ in still(gas, state, 0.01):
            pass
        lid = np.abs(rotation.T @ force_on(gas, state, "lid"))[2] / (WIDTH * DEPTH)
        found.append((gas.totals(state), lid))
        yield from books(state)
    (here, lid), (there, turned_lid) = found
    yield Measurement("pressure of the turned bag [Pa]", there.pressure, here.pressure, 1e-2)
    yield Measurement("vented by the turned bag [kg]", there.vented, here.vented, 1e-2)
    yield Measurement("pressure on its lid [Pa]", turned_lid, lid, 1e-2)
