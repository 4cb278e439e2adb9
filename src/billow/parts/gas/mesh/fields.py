"""What users see of the mesh gas: on triangles, in cells, and at places."""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.cut_cells import CutCells
from billow.geometry.lattice_clipping import FARTHEST, NORMAL, cell_of
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.winding_number import winding_numbers
from billow.parts.gas.mesh.setup import Setup
from billow.parts.gas.mesh.sheet import Sheet
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.supply.mixture import mixture_gas_constant


def chamber_totals(table: np.ndarray, sheets: list[Sheet], volume: float) -> tuple[float, float]:
    """Pressure [Pa] and temperature [K] of a chamber of this volume [m^3] with the gas of its rooms, such that p V =
    m R T."""
    each = [_heat(table, sheet.held, sheet.temperature) for sheet in sheets]
    heat, gas_constant = sum(one for one, _ in each), sum(one for _, one in each)
    return heat / volume, heat / gas_constant if gas_constant > 0.0 else 0.0


@scalar
def _heat(table, held, temperature):
    """Sums of m R T [J] and m R [J/K]."""
    heat, whole = 0.0, 0.0
    for i in range(len(held)):
        gas_constant = 0.0
        for s in range(len(table)):
            gas_constant += held[i, s] * table[s, 0]
        heat += gas_constant * temperature[i]
        whole += gas_constant
    return heat, whole


def corners_of(key: np.ndarray) -> np.ndarray:
    """Lower corners of cells in lattice coordinates, (n, 3) int64."""
    return np.stack(cell_of.py_func(key), axis=1)


def _states(setup: Setup, sheet: Sheet, cut: CutCells) -> tuple[np.ndarray, ...]:
    """Of the cells that have room for gas: number in the cut, pressure [Pa], temperature [K], density [kg/m^3],
    velocity [m/s], and mass fractions."""
    at = np.searchsorted(cut.key, sheet.key)
    known = (at < len(cut.key)) & (cut.key[np.minimum(at, len(cut.key) - 1)] == sheet.key)
    known[known] = cut.volume[at[known]] > 0.0
    at, masses = at[known], sheet.held[known, :-4]
    room = cut.volume[at] * setup.cell**3
    mass = masses.sum(axis=1)
    pressure = (masses @ setup.table[:, 0]) * sheet.temperature[known] / room
    velocity = sheet.held[known, -4:-1] / mass[:, None]
    return at, pressure, sheet.temperature[known], mass / room, velocity, masses / mass[:, None]


def boxes_of(setup: Setup, gas: MeshState, cuts: tuple[CutCells, ...]) -> dict[str, np.ndarray]:
    """Cells as boxes; see `LocalGas.cells`. Of several chambers that share a cell each has a box of its own; of strips
    of a chamber that do, it is the mean: of pressure and density by volume, of the rest by mass."""
    rows: dict[str, list[np.ndarray]] = {}
    for c, rooms in enumerate(setup.rooms(gas).of_chamber):
        each = [(cuts[r], _states(setup, gas.sheets[r], cuts[r])) for r in rooms]
        key, of = np.unique(np.concatenate([cut.key[states[0]] for cut, states in each]), return_inverse=True)
        share = np.concatenate([cut.volume[states[0]] for cut, states in each])
        volume = _summed(of, share, len(key))
        pressure, temperature, density, velocity, fractions = (
            np.concatenate([states[k] for _, states in each]) for k in range(1, 6)
        )
        mass = share * density
        whole = _summed(of, mass, len(key))
        fractions = _summed(of, mass[:, None] * fractions, len(key)) / whole[:, None]
        found = {
            "centre": gas.origin + (corners_of(key) + 0.5) * setup.cell,
            "size": np.full((len(key), 3), setup.cell),
            "pressure": _summed(of, share * pressure, len(key)) / volume,
            "temperature": _summed(of, mass * temperature, len(key)) / whole,
            "density": whole / volume,
            "velocity": _summed(of, mass[:, None] * velocity, len(key)) / whole[:, None],
            "volume_fraction": volume,
            "chamber": np.full(len(key), float(c)),
        }
        for name, share in zip(setup.supply.species_names, fractions.T, strict=True):
            found[f"mass_fraction_{name}"] = np.ascontiguousarray(share)
        for name, values in found.items():
            rows.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in rows.items()}


def _summed(of: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Sums of rows of values by what they are of, (count, ...)."""
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, of, values)
    return total


def is_inside(
    triangles: np.ndarray, chambers: Chambers, positions: np.ndarray, places: np.ndarray, chamber: int
) -> np.ndarray:
    """Whether places [m] (m, 3) are in a chamber of the surface with these positions, (m,) bool."""
    enclosure = Enclosure(triangles, positions, chambers)
    return winding_numbers(places, np.full(len(places), chamber), enclosure) >= 1


def at_places(setup: Setup, gas: MeshState, cuts: tuple[CutCells, ...], places: np.ndarray) -> dict[str, np.ndarray]:
    """State of the cells around places; see `LocalGas.at`."""
    ambient, rooms = setup.supply.ambient, setup.rooms(gas)
    air = ambient.pressure / (mixture_gas_constant(setup.table, ambient.mass_fractions) * ambient.temperature)
    rows = np.tile([ambient.pressure, ambient.temperature, air, 0.0, 0.0, 0.0], (len(places), 1))
    corner = np.floor((places - gas.origin) / setup.cell)
    near = np.abs(corner).max(axis=1, initial=0.0) < FARTHEST - 1
    i, j, k = np.where(near[:, None], corner, 0.0).astype(np.int64).T
    key = (i + FARTHEST << 42) + (j + FARTHEST << 21) + k + FARTHEST
    for c, (sheet, cut) in enumerate(zip(gas.sheets, cuts, strict=True)):
        at, pressure, temperature, density, velocity, _ = _states(setup, sheet, cut)
        if not len(at):
            continue
        found = np.minimum(np.searchsorted(cut.key[at], key), len(at) - 1)
        inside = near & (cut.key[at[found]] == key)
        inside[inside] = is_inside(rooms.triangles, rooms.chambers, gas.positions, places[inside], c)
        mine = found[inside]
        rows[inside] = np.column_stack([pressure[mine], temperature[mine], density[mine], velocity[mine]])
    return {"pressure": rows[:, 0], "temperature": rows[:, 1], "density": rows[:, 2], "velocity": rows[:, 3:]}


def on_triangles(setup: Setup, gas: MeshState, cuts: tuple[CutCells, ...]) -> dict[str, np.ndarray]:
    """Pressure behind minus ahead of each triangle of the bag, and the gas beside it: behind it, if there is any."""
    n, surface, ambient = setup.surface.triangle_count, setup.surface, setup.supply.ambient
    area = np.linalg.norm(area_vectors(surface.triangles, gas.positions), axis=1)
    chambers = setup.supply.chambers
    gauge = np.where(chambers.ahead == OUTSIDE, -ambient.pressure, 0.0)
    gauge += np.where(chambers.behind == OUTSIDE, ambient.pressure, 0.0)
    beside = {"gas_temperature": np.full(n, np.nan), "gas_density": np.full(n, np.nan)}
    beside["gas_velocity"] = np.full((n, 3), np.nan)
    for walls, sheet, cut in reversed(list(zip(setup.rooms(gas).walls, gas.sheets, cuts, strict=True))):
        index, first = walls.index[: walls.own], cut.fragments.first[: walls.own + 1]
        normals = area_vectors(walls.triangles[: walls.own], gas.positions)
        push = np.einsum("ij,ij->i", sheet.force[: walls.own].sum(axis=1), normals)
        np.add.at(gauge, index, push / np.maximum(area[index], 1e-300) ** 2)
        at, _, temperature, density, velocity, _ = _states(setup, sheet, cut)
        if not len(at):
            continue
        where = np.full(len(cut.key), -1)
        where[at] = np.arange(len(at))
        fragments = cut.fragments.number[: first[-1]]
        mine = where[cut.cell[fragments]]
        size = np.linalg.norm(cut.fragments.rows[fragments, NORMAL : NORMAL + 3], axis=1)
        size[mine < 0] = 0.0
        triangle = np.repeat(np.arange(walls.own), np.diff(first))
        whole = np.bincount(triangle, size, walls.own)
        some = whole > 0.0
        for name, values in (("gas_temperature", temperature), ("gas_density", density)):
            mean = np.bincount(triangle, size * values[mine], len(whole)) / np.maximum(whole, 1e-300)
            beside[name][index[some]] = mean[some]
        for d in range(3):
            mean = np.bincount(triangle, size * velocity[mine, d], len(whole)) / np.maximum(whole, 1e-300)
            beside["gas_velocity"][index[some], d] = mean[some]
    return {"gauge_pressure": gauge} | beside
