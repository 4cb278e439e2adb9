"""T7, T9, T10, T11, M4, M5 and M7: waves in the mesh gas against closed forms (docs/theory.md, Verification cases).

A tube of 1 m along z, a few cells wide, no wall of which lies in a plane of the lattice; or a flat box as wide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAMMA, GAS_CONSTANT
from billow.apps.verification.mesh_gas import (
    ATMOSPHERE,
    SCHEMES,
    SOUND,
    VAN_LEER,
    WARM,
    books,
    force_on,
    mesh_in,
    moved,
    still,
)
from billow.apps.verification.scenes import box
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.mesh_gas import MeshGas
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.supply.species import Species

ACROSS = 2.3
"""Cells across the tube."""
MONATOMIC = 5.0 / 3.0


def tube(cells: int, advection: str, gamma: float = GAMMA) -> tuple[MeshGas, Bag]:
    """The gas of a tube of 1 m, of so many cells along it."""
    width = ACROSS / cells
    shape = box(width, width, 1.0)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    return mesh_in(bag, 1.0 / cells, advection, species=[Species.ideal("ideal", GAS_CONSTANT, gamma)]), bag


def set_gas(gas: MeshGas, state: MeshState, profile: Callable, gamma: float = GAMMA) -> None:
    """Give each cell the gas of profile(z): density [kg/m^3], velocity along z [m/s] and pressure [Pa]."""
    sheet, cut = state.sheets[0], gas.cut(state)[0]
    some = np.searchsorted(cut.key, sheet.key)
    room = cut.volume[some] * gas.cell**3
    density, velocity, pressure = profile(cut.centroid[some, 2] * gas.cell + state.origin[2])
    sheet.held = np.zeros_like(sheet.held)
    sheet.held[:, 0], sheet.held[:, 3] = density * room, density * velocity * room
    sheet.held[:, 4] = (pressure / (gamma - 1.0) + 0.5 * density * velocity**2) * room
    sheet.temperature[:] = pressure / (density * GAS_CONSTANT)
    sheet.sound[:] = np.sqrt(gamma * pressure / density)
    state.start_masses, state.start_energy = sheet.masses, sheet.energy


def along(gas: MeshGas, state: MeshState) -> tuple[np.ndarray, ...]:
    """Of each cell: z of its centroid [m], volume, density, velocity along z, pressure."""
    cells, cut = gas.cells(state), gas.cut(state)[0]
    z = cut.centroid[cut.volume > 0.0, 2] * gas.cell + state.origin[2]
    return z, cells["volume_fraction"], cells["density"], cells["velocity"][:, 2], cells["pressure"]


def shock_tube() -> Iterator[Measurement]:
    """T7: G. A. Sod, J. Comput. Phys. 27 (1978) 1; 200 cells, at the time 0.2 L/sqrt(p/rho). Mean errors of the density
    are those of the schemes in one dimension, with a fifth on top."""
    rho_l, p_l, rho_r, p_r = 1.0, 1e5, 0.125, 1e4
    unit = math.sqrt(p_l / rho_l)
    c_l, c_r = math.sqrt(GAMMA * p_l / rho_l), math.sqrt(GAMMA * p_r / rho_r)

    def fan(p):
        return 2.0 * c_l / (GAMMA - 1.0) * (1.0 - (p / p_l) ** ((GAMMA - 1.0) / (2.0 * GAMMA)))

    def shock(p):
        return (p - p_r) * math.sqrt(2.0 / ((GAMMA + 1.0) * rho_r) / (p + (GAMMA - 1.0) / (GAMMA + 1.0) * p_r))

    p_star = brentq(lambda p: fan(p) - shock(p), p_r, p_l)
    u_star = fan(p_star)
    ratio, k = p_star / p_r, (GAMMA - 1.0) / (GAMMA + 1.0)
    left, right = rho_l * (p_star / p_l) ** (1.0 / GAMMA), rho_r * (ratio + k) / (1.0 + k * ratio)
    front = c_r * math.sqrt((GAMMA + 1.0) / (2.0 * GAMMA) * ratio + (GAMMA - 1.0) / (2.0 * GAMMA))

    def exact(xi):
        inside = c_l - (GAMMA - 1.0) / 2.0 * (2.0 / (GAMMA + 1.0) * (c_l + xi))
        tail = u_star - math.sqrt(GAMMA * p_star / left)
        bounds = [xi < -c_l, xi < tail, xi < u_star, xi < front]
        return np.select(bounds, [rho_l, rho_l * (inside / c_l) ** (2.0 / (GAMMA - 1.0)), left, right], rho_r)

    for scheme, error in zip(SCHEMES, (0.0139, 0.0035), strict=True):
        gas, bag = tube(200, scheme)
        state = gas.start(bag)
        set_gas(gas, state, lambda z: (np.where(z < 0.5, rho_l, rho_r), 0.0 * z, np.where(z < 0.5, p_l, p_r)))
        end = 0.2 / unit
        for _ in still(gas, state, end):
            pass
        z, volume, density, velocity, pressure = along(gas, state)
        star = (z > 0.55) & (z < 0.65)
        yield Measurement(f"pressure between the waves, {scheme} [Pa]", pressure[star].mean(), p_star, 5e-3)
        yield Measurement(f"speed between the waves, {scheme} [m/s]", velocity[star].mean(), u_star, 5e-3)
        gap = float(volume @ np.abs(density - exact((z - 0.5) / end)) / volume.sum())
        yield Measurement(f"mean error of the density, {scheme} [absolute]", gap, 0.0, error)
        yield from books(state)


def cold_gas_on_a_wall() -> Iterator[Measurement]:
    """T9: W. F. Noh, J. Comput. Phys. 72 (1987) 78: cold gas, gamma 5/3, runs against a wall; behind the shock, which
    moves at a third of its speed, it is four times as dense. The lid follows the gas. Where the shock leaves the wall
    the gas is too hot, by less than a tenth from the fourth cell on."""
    speed, cells, end = 300.0, 100, 0.6
    gas, bag = tube(cells, VAN_LEER, MONATOMIC)
    state = gas.start(bag)
    set_gas(gas, state, lambda z: (1.0 + 0.0 * z, -speed + 0.0 * z, 0.1 + 0.0 * z), MONATOMIC)

    def at(time):
        return bag.positions * [1.0, 1.0, 1.0 - speed * time]

    for _ in moved(gas, state, at, end / speed, 0.6):
        pass
    z, _, density, _, _ = along(gas, state)
    plateau = (z > 0.05) & (z < 0.15)
    yield Measurement("density behind the shock", density[plateau].mean(), 4.0, 1e-2)
    yield Measurement("density in the fourth cell", density[(z > 0.03) & (z < 0.05)].mean(), 4.0, 0.1)
    order = np.argsort(-z)
    yield Measurement("place of the shock [m]", np.interp(2.5, density[order], z[order]), end / 3.0, 2.5e-2)
    yield from books(state)


def reflected_shock() -> Iterator[Measurement]:
    """T10: a piston sends a shock of Mach 2 against the closed end; 100 cells. Toro, chapter 3: 4.5 times the pressure,
    and 15 times after reflection."""
    piston = SOUND * 2.0 / (GAMMA + 1.0) * (2.0 - 0.5)
    arrival = 1.0 / (2.0 * SOUND)
    for scheme in SCHEMES:
        gas, bag = tube(100, scheme)
        state = gas.start(bag)
        area = (ACROSS * gas.cell) ** 2
        behind, reflected = [], []

        def at(time, start=bag.positions):
            return start * [1.0, 1.0, 1.0 - piston * time]

        for time in moved(gas, state, at, 1.35 * arrival, 0.8):
            if 0.4 * arrival < time < 0.95 * arrival:
                behind.append(force_on(gas, state, "lid")[2] / area)
            elif time > 1.15 * arrival:
                whole = state.sheets[0].force.sum(axis=(0, 1))[2]
                reflected.append((force_on(gas, state, "lid")[2] - whole) / area)
        yield Measurement(f"pressure behind the shock, {scheme}", np.mean(behind) / ATMOSPHERE, 4.5, 5e-3)
        yield Measurement(f"pressure behind its reflection, {scheme}", np.mean(reflected) / ATMOSPHERE, 15.0, 5e-3)
        yield from books(state)


def piston() -> Iterator[Measurement]:
    """T11: the lid moves at a tenth or half of the speed of sound; pressure on it, mean over the last 60 % of 0.35 m/c,
    by the exact shock or fan. 100 cells."""
    for scheme in SCHEMES:
        for mach, exact in ((-0.5, 1.94082), (0.5, 0.4782969), (-0.1, 1.14865), (0.1, 0.86813)):
            gas, bag = tube(100, scheme)
            state = gas.start(bag)
            area, end = (ACROSS * gas.cell) ** 2, 0.35 / SOUND

            def at(time, speed=mach * SOUND, start=bag.positions):
                return start * [1.0, 1.0, 1.0 + speed * time]

            pressures, spans, before = [], [], 0.0
            for time in moved(gas, state, at, end, 0.8):
                if time > 0.4 * end:
                    pressures.append(force_on(gas, state, "lid")[2] / area / ATMOSPHERE)
                    spans.append(time - before)
                before = time
            pressures, spans = np.array(pressures), np.array(spans)
            title = f"pressure on a lid at {mach:g} c, {scheme}"
            yield Measurement(title, pressures @ spans / spans.sum(), exact, 2e-3)
            if abs(mach) <= 0.2:
                yield Measurement(f"{title}, ripple [absolute]", pressures.std() / exact, 0.0, 3e-2)
            yield from books(state)


def standing_wave(cells: int, periods: float, amplitude: float = 1e-3) -> tuple[np.ndarray, np.ndarray, float]:
    """Sound along a closed tube of 1 m: times in periods, the amplitude of its first mode, and in the end the mean
    error of the pressure, relative to the amplitude."""
    gas, bag = tube(cells, VAN_LEER)
    state = gas.start(bag)
    rho = ATMOSPHERE / (GAS_CONSTANT * WARM)

    def profile(z):
        wave = amplitude * np.sinc(0.5 / cells) * np.cos(math.pi * z)  # its mean over a cell
        return rho * (1.0 + wave / GAMMA), 0.0 * z, ATMOSPHERE * (1.0 + wave)

    set_gas(gas, state, profile)
    period, times, sizes = 2.0 / SOUND, [], []
    for time in still(gas, state, periods * period):
        z, volume, _, _, pressure = along(gas, state)
        mode = np.cos(math.pi * z)
        times.append(time / period)
        sizes.append(2.0 * float(volume @ ((pressure / ATMOSPHERE - 1.0) * mode)) / volume.sum() / amplitude)
    exact = math.cos(2.0 * math.pi * times[-1]) * amplitude * np.sinc(0.5 / cells) * mode
    error = float(volume @ np.abs(pressure / ATMOSPHERE - 1.0 - exact) / volume.sum()) / amplitude
    return np.array(times), np.array(sizes), error


def sound() -> Iterator[Measurement]:
    """M4: sound in a closed box of 1 m, 40 cells; amplitude and frequency over three periods."""
    times, sizes, _ = standing_wave(40, 3.2)
    crossings = np.flatnonzero(np.diff(np.sign(sizes)) != 0)
    zeros = times[crossings] - sizes[crossings] * np.diff(times)[crossings] / np.diff(sizes)[crossings]
    half = (zeros[-1] - zeros[0]) / (len(zeros) - 1)
    yield Measurement("period, relative", 2.0 * half, 1.0, 2e-3)
    first, last = sizes[(times > 0.75) & (times < 1.25)].max(), sizes[(times > 2.75)].max()
    yield Measurement("amplitude lost in a period [absolute]", 1.0 - (last / first) ** 0.5, 0.0, 3e-2)


def wave_between_moving_walls(cells: int, periods: float = 0.8, drift: float = 30.0) -> tuple[float, float]:
    """Sound along a tube of 1 m that moves through the lattice [m/s], so that its ends pass from cell to cell: mean
    errors of pressure and velocity together, relative to the amplitude, a tenth of a metre away from the ends and in
    all cells."""
    gas, bag = tube(cells, VAN_LEER)
    state, amplitude = gas.start(bag), 1e-6
    mean = amplitude * np.sinc(0.5 / cells)  # over a cell
    rho, end, way = ATMOSPHERE / (GAS_CONSTANT * WARM), periods * 2.0 / SOUND, np.array([0.0, 0.0, drift])

    def profile(z):
        wave = mean * np.cos(math.pi * z)
        return rho * (1.0 + wave / GAMMA), drift + 0.0 * z, ATMOSPHERE * (1.0 + wave)

    set_gas(gas, state, profile)
    places = bag.positions[gas.surface.triangles][:, :, 2]
    ends = np.ptp(places, axis=1) == 0.0  # what the first step books as work begins with the force there
    state.sheets[0].force[ends] *= 1.0 + amplitude * np.cos(math.pi * places[ends, :1, None])
    for _ in moved(gas, state, lambda time: bag.positions + time * way, end, 0.9):
        pass
    z, volume, _, velocity, pressure = along(gas, state)
    z, turn = z - drift * end, 2.0 * math.pi * periods
    error = np.abs(pressure / ATMOSPHERE - 1.0 - mean * math.cos(turn) * np.cos(math.pi * z))
    error += np.abs(GAMMA * (velocity - drift) / SOUND - mean * math.sin(turn) * np.sin(math.pi * z))
    inner = np.abs(z - 0.5) < 0.4
    return (
        float(np.average(error[inner], weights=volume[inner])) / amplitude,
        float(np.average(error, weights=volume)) / amplitude,
    )


def order() -> Iterator[Measurement]:
    """M5: the same wave after 0.8 periods, 20 to 80 cells with cut ends; and between walls that move through the
    lattice, 80 and 160 cells: 2 +- 0.15 with all cells, cut ones too.

    Away from the walls it is 2.16: at the longest step the error of second order is so small that those of third count
    (docs/mesh_gas.md, Checks). That check is of one side."""
    errors = [standing_wave(cells, 0.8, 1e-5)[2] for cells in (20, 40, 80)]
    found = [math.log2(a / b) for a, b in pairwise(errors)]
    yield Measurement("order of a sound wave", found[-1], 2.0, 0.25)
    inner, whole = np.log2(np.divide(*(wave_between_moving_walls(cells) for cells in (80, 160))))
    yield Measurement("order between moving walls in all cells [absolute]", whole, 2.0, 0.15)
    yield Measurement("order between moving walls away from them, at most 2", min(inner, 2.0), 2.0, 0.075)


def vortex_in_a_box(cells: int, radius: float = 0.1) -> tuple[float, float]:
    """A smooth vortex at rest in a flat box that moves slantwise through the lattice, a quarter turn of its core: mean
    error of the velocity, relative to the fastest swirl, away from cut cells and in all of them. Speed and temperature
    of C.-W. Shu's isentropic vortex (NASA CR-97-206253, 1997), 0.3 c at most; at the walls it is 3e-5 of that."""
    h, swirl, drift = 1.0 / cells, 0.3 * SOUND, np.array([30.0, 12.0, 0.0])
    shape = box(1.0, 1.0, ACROSS * h)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    gas = mesh_in(bag, h)
    state, middle = gas.start(bag), shape.positions.mean(axis=0)

    def exact(places, time):
        x, y = ((places - middle - drift * time) / radius)[:, :2].T
        turn = swirl * np.exp(0.5 * (1.0 - x * x - y * y))
        warmth = 1.0 - 0.5 * (GAMMA - 1.0) * (turn / SOUND) ** 2
        velocity = drift + np.column_stack([-turn * y, turn * x, 0.0 * x])
        return ATMOSPHERE / (GAS_CONSTANT * WARM) * warmth ** (1.0 / (GAMMA - 1.0)), velocity, WARM * warmth

    sheet, cut = state.sheets[0], gas.cut(state)[0]
    some = np.searchsorted(cut.key, sheet.key)
    density, velocity, sheet.temperature = exact(cut.centroid[some] * h + state.origin, 0.0)
    mass = density * cut.volume[some] * h**3
    energy = GAS_CONSTANT * sheet.temperature / (GAMMA - 1.0) + 0.5 * (velocity**2).sum(axis=1)
    sheet.held = np.column_stack([mass, mass[:, None] * velocity, mass * energy])
    sheet.sound = np.sqrt(GAMMA * GAS_CONSTANT * sheet.temperature)
    state.start_masses, state.start_energy, end = sheet.masses, sheet.energy, radius / swirl
    for _ in moved(gas, state, lambda time: bag.positions + drift * time, end, 0.9):
        pass
    found, cut = gas.cells(state), gas.cut(state)[0]
    volume, places = found["volume_fraction"], cut.centroid[cut.volume > 0.0] * h + state.origin
    error = np.abs(found["velocity"] - exact(places, end)[1]).sum(axis=1) / swirl
    inner = np.abs(places - middle - drift * end)[:, :2].max(axis=1) < 0.35
    return float(np.average(error[inner], weights=volume[inner])), float(np.average(error, weights=volume))


def vortex() -> Iterator[Measurement]:
    """M7: a smooth vortex between moving walls, 20 to 80 cells: second order, at least 1.5 with cut cells.

    Checks are of one side: 2 +- 0.15 is not what is found, but 2.3 to 2.4 (docs/mesh_gas.md, Checks)."""
    errors = np.array([vortex_in_a_box(cells) for cells in (20, 40, 80)])
    inner, whole = np.log2(errors[1] / errors[2])
    yield Measurement("order of a vortex away from the walls, at most 2", min(inner, 2.0), 2.0, 0.075)
    yield Measurement("order in all cells, at most 1.5", min(whole, 1.5), 1.5, 1e-9)
