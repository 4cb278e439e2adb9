"""What the gas is like in each cell: for pictures, not for the physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import prange

from billow.base.compiled import kernel
from billow.parts.gas.corpuscular.cells import Cells
from billow.parts.gas.corpuscular.collisions import cell_content
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, cell_temperature
from billow.parts.gas.corpuscular.particles import Particles


@dataclass(frozen=True)
class CellFields:
    """Of each cell that holds particles.

    cell: index, (n,) int64; centre [m] (n, 3); chamber (n,) int32; count of particles (n,) int64; mass [kg] (n,);
    velocity, mean over mass [m/s] (n, 3); temperature [K] (n,), nan where a single particle has none; density [kg/m^3]
    and pressure [Pa] (n,), count heat T / volume, as if all of the cell were inside the bag: too low where fabric cuts
    it. Ten particles give 15 % of noise in temperature and 32 % in pressure; average before reading numbers off.
    """

    cell: np.ndarray
    centre: np.ndarray
    chamber: np.ndarray
    count: np.ndarray
    mass: np.ndarray
    velocity: np.ndarray
    temperature: np.ndarray
    density: np.ndarray
    pressure: np.ndarray


def cell_fields(cells: Cells, particles: Particles, kinds: ParticleKinds) -> CellFields:
    """Fields in the cells of the last sort."""
    count = np.diff(cells.start[: cells.count + 1]).astype(np.int64)
    cell = np.flatnonzero(count)
    n = len(cell)
    mass, momentum, temperature = np.zeros(n), np.zeros((n, 3)), np.zeros(n)
    _average(
        n, cell, cells.start, cells.order, particles.velocity, particles.internal_energy, particles.species,
        kinds.table, kinds.mass, kinds.heat, mass, momentum, temperature,
    )  # fmt: skip
    chamber = np.searchsorted(cells.first, cell, side="right").astype(np.int32) - np.int32(1)
    shape, place = cells.shape[chamber], cell - cells.first[chamber]
    steps = np.column_stack(
        [place // (shape[:, 1] * shape[:, 2]), place // shape[:, 2] % shape[:, 1], place % shape[:, 2]]
    )
    size = cells.size[chamber]
    centre = cells.origin[chamber] + (steps + 0.5) * size[:, None]
    return CellFields(
        cell, centre, chamber, count[cell], mass, momentum / mass[:, None], temperature, mass / size**3,
        count[cell] * kinds.heat * temperature / size**3,
    )  # fmt: skip


@kernel
def _average(
    n, cell, start, order, velocity, internal_energy, species, table, mass, heat, mass_out, momentum_out,
    temperature_out,
):  # fmt: skip
    for at in prange(n):
        masses = np.empty(len(mass))
        begin, end = np.int64(start[cell[at]]), np.int64(start[cell[at] + 1])
        thermal = cell_content(order, begin, end, velocity, internal_energy, species, mass, masses)
        mass_out[at] = masses.sum()
        temperature_out[at] = np.nan
        if end - begin > 1:
            temperature_out[at] = cell_temperature(table, masses, heat, thermal, 300.0)
        for j in range(begin, end):
            i = order[j]
            for axis in range(3):
                momentum_out[at, axis] += mass[species[i]] * velocity[i, axis]
