"""M6: what leaves a bag of mesh gas through a hole of a few cells (docs/theory.md, Verification cases)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAMMA
from billow.apps.verification.mesh_gas import books, carry, mesh_in, moved
from billow.apps.verification.scenes import sphere
from billow.geometry.surface import Surface, area_vectors
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.setup import VAN_LEER
from billow.parts.gas.supply.outflow import ORIFICE, orifice_flux
from billow.parts.gas.supply.passages import VENT, Passage

OUTSIDE = 101325.0


def vented_sphere(radius: float, subdivisions: int, hole: float) -> tuple[Bag, np.ndarray]:
    """A sphere [m] and its triangles within `hole` [m] of a place on it, its part "vent"."""
    shape = sphere(radius, subdivisions)
    axis = np.array([0.36, 0.48, 0.8])
    centres = shape.positions[shape.surface.triangles].mean(axis=1)
    vent = np.linalg.norm(centres - radius * axis, axis=1) < hole
    surface = Surface.build(
        shape.surface.triangles, vent.astype(np.int64), ("outer", "vent"), len(shape.positions), ("fabric", "vent"),
        shape.surface.chambers,
    )  # fmt: skip
    return Bag(surface, shape.positions, np.zeros_like(shape.positions)), np.flatnonzero(vent)


def flow_of_vent(
    cell: float, gauge: float = 2e4, discharge: float = 0.7, speed: float = 0.0, advection: str = VAN_LEER
) -> Iterator[Measurement]:
    """Mass that a hole of 60 mm lets out from 1 to 2.5 ms, against the law at the total pressure of the whole bag; bag
    and gas move with `speed` [m/s]. The bag is not so large that what flows in it were nothing: 2 %."""
    bag, vent = vented_sphere(0.2, 3, 0.03)
    area = float(np.linalg.norm(area_vectors(bag.surface.triangles[vent], bag.positions), axis=1).sum())
    hole = Passage("hole", VENT, ORIFICE, 0, triangles=vent, area=area, coefficient=discharge)
    gas = mesh_in(bag, cell, advection, OUTSIDE + gauge, 500.0, passages=(hole,), outside=OUTSIDE)
    state, velocity = gas.start(bag), speed * np.array([0.48, 0.64, -0.6])
    carry(state, velocity)
    flowed, expected, before = 0.0, 0.0, (0.0, 0.0)
    for time in moved(gas, state, lambda t: bag.positions + velocity * t, 2.5e-3):
        now = gas.totals(state)
        pressure = (now.energy - 0.5 * now.mass * speed**2) * (GAMMA - 1.0) / now.volume
        flux = discharge * area * orifice_flux(pressure, OUTSIDE, GAMMA, pressure * now.volume / now.mass)
        if before[0] > 1e-3:
            flowed += now.vented - before[1]
            expected += (time - before[0]) * flux
        before = time, now.vented
    title = f"vented, cells of {1e3 * cell:g} mm, {1e-3 * gauge:g} kPa, Cd {discharge:g}, at {speed:g} m/s"
    yield Measurement(f"{title}, {advection} [kg]", flowed, expected, 2e-2)
    yield from books(state)


def vent_of_a_few_cells() -> Iterator[Measurement]:
    """M6: cells as large as the hole, and finer; at rest, moving, choked, as a nozzle."""
    for cell in (0.05, 0.03, 0.018):
        yield from flow_of_vent(cell)
    yield from flow_of_vent(0.03, speed=50.0)
    yield from flow_of_vent(0.03, discharge=1.0)
    yield from flow_of_vent(0.03, gauge=1.5e5)
    yield from flow_of_vent(0.03, advection="donor")
