"""The mesh gas: flow of an inviscid gas on a lattice whose cells are cut exactly by the fabric (docs/mesh_gas.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from billow.base.compiled import CHUNK
from billow.base.errors import Concern
from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.geometry.cut_cells import CutCells, Window, cut_cells
from billow.geometry.surface import area_vectors
from billow.parts.gas.gas_model import Bag, ChamberTotals, Content, GasTotals, SwitchableGas
from billow.parts.gas.mesh.concerns import mesh_concerns
from billow.parts.gas.mesh.exchange import Exchange
from billow.parts.gas.mesh.fields import at_places, boxes_of, chamber_totals, is_inside, on_triangles
from billow.parts.gas.mesh.longest_step import fastest, parts_of
from billow.parts.gas.mesh.moved import Moved
from billow.parts.gas.mesh.rooms import NO_CELLS, inside_out, join_sheets
from billow.parts.gas.mesh.setup import VAN_LEER, Setup
from billow.parts.gas.mesh.sheet import Sheet
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.mesh.work import add_load
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gamma, mixture_gas_constant
from billow.parts.part import MYLAR_VOLUME, Loads, Setting

COURANT = 0.9
"""Of the exact bound of the linear scheme, which the structure is asked to keep."""
DRIFT = 1.05
"""How much longer a part may be before a step takes one more: the bound falls while the structure's steps stay."""

MOST_PARTS = 4
"""Parts of a step of the structure, about, that the gas asks for: the structure takes no longer steps."""

OFF_THE_PLANES = 0.37
"""Distance [cells] of the lattice's planes from the ends of the bag at the start, so that no panel lies in one."""

LOOK_EVERY = 16
"""Parts of steps between looks at strips that may join."""

SECONDS_PER_CELL, SECONDS_PER_TRIANGLE = 0.9e-6, 2e-6
"""Rough cost of a full cell, and of what of a triangle is cut, in a part of a step."""


class MeshGas(Setup, SwitchableGas):
    """The gas model; its parameters are those of `Setup`."""

    on_lattice = True

    # --- the contract ----------------------------------------------------------------------------------------------

    def start(self, bag: Bag) -> MeshState:
        """The initial gas in the start shape. Raises NumericalStop E-NUM-020."""
        initial, positions, species = self.supply.start_gas, bag.positions.copy(), len(self.table)
        used = positions[np.unique(bag.surface.triangles)]
        origin = used.min(axis=0) - OFF_THE_PLANES * self.cell
        rows = len(self.supply.passages.rows)
        gas = MeshState(
            (), positions, origin, np.zeros(rows, np.bool_), np.zeros((rows, 2)), np.zeros(species), np.zeros(species),
            np.zeros(self.supply.chambers.count), np.zeros(species),
            np.arange(self.supply.chambers.count if self.strips is None else self.strips.count),
        )  # fmt: skip
        sheets, rooms = [], self.rooms(gas)
        for room, (walls, cut) in enumerate(zip(rooms.walls, self.cut(gas), strict=True)):
            c = next(c for c, some in enumerate(rooms.of_chamber) if room in some)
            p, t, y = float(initial.pressure[c]), float(initial.temperature[c]), initial.mass_fractions[c]
            gas_constant = mixture_gas_constant(self.table, y)
            some = cut.volume != 0.0
            mass = p / (gas_constant * t) * self.cell**3 * cut.volume[some]
            held = np.zeros((len(mass), species + 4))
            held[:, :species] = mass[:, None] * y
            held[:, -1] = mass * (mixture_enthalpy(self.table, y, t) - gas_constant * t)
            normals = walls.sign[:, None] * area_vectors(walls.triangles, positions)
            force = np.repeat(p / 3.0 * normals[:, None, :], 3, axis=1)
            sound = np.full(len(mass), math.sqrt(mixture_gamma(self.table, y, t) * gas_constant * t))
            sheets.append(Sheet(cut.key[some], held, np.full(len(mass), t), sound, force, np.zeros(len(normals))))
        gas.sheets = tuple(sheets)
        inside = np.append(initial.pressure, self.supply.ambient.pressure)
        for k, row in enumerate(self.supply.passages.rows):
            gas.is_open[k] = inside[row.behind] - inside[row.ahead] >= row.opens_at  # OUTSIDE, -1, is the last entry
        for c, sheet in enumerate(sheets):
            sheet.force[rooms.ways.links(c, gas.is_open)] = 0.0
        gas.volume = self.supply.chambers.volumes(bag.surface.triangles, positions)
        gas.start_masses, gas.start_energy = sum(s.masses for s in sheets), sum(s.energy for s in sheets)
        return gas

    def cut(self, gas: MeshState) -> tuple[CutCells, ...]:
        """The cells of every room as the surface stands."""
        now = gas.positions, gas.joined
        if gas.cuts is None or not all(map(np.array_equal, gas.cuts[::2], now)):
            gas.cuts = gas.positions.copy(), self._cut(gas, gas.positions), gas.joined.copy()
        return gas.cuts[1]

    def _cut(self, gas: MeshState, positions: np.ndarray) -> tuple[CutCells, ...]:
        walls, places = self.rooms(gas).walls, (positions - gas.origin) / self.cell
        if gas.windows is None:
            gas.windows = [Window.none() for _ in walls]
        return tuple(
            cut_cells(w.triangles, w.sign, places, window) if len(w.index) else NO_CELLS
            for w, window in zip(walls, gas.windows, strict=True)
        )

    def advance(self, gas: MeshState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        """Raises NumericalStop E-NUM-020 and E-NUM-021."""
        gas.volume = bag.volumes.copy()
        if dt > 0.0 and np.isfinite(bag.positions).all():  # others stop a run whose fabric is nowhere
            self._flow(gas, bag, time, dt)
        corner_force, ambient = loads.at_corners(), self.supply.ambient.pressure
        for walls, sheet in zip(self.rooms(gas).walls, gas.sheets, strict=True):
            add_load(
                walls.own, walls.triangles, walls.index, bag.positions, sheet.force, walls.sign, walls.outer,
                ambient, corner_force,
            )  # fmt: skip

    def _flow(self, gas: MeshState, bag: Bag, time: float, dt: float) -> None:
        old, before, positions = self.cut(gas), gas.positions, bag.positions.copy()
        moved = not np.array_equal(before, positions)
        new = self._cut(gas, positions) if moved else old
        velocity = (positions - before) / dt
        parts = max(1, math.ceil(dt / (DRIFT * self.longest_part(gas))))
        second_order, rooms = self.advection == VAN_LEER, self.rooms(gas)
        chambers = {
            c: Moved.begin(
                rooms.walls[c], gas.sheets[c], gas.windows[c].scratch, self.table, self.cell, gas.origin,
                (old[c], new[c]), velocity, rooms.ways.links(c, gas.is_open), second_order,
                self.film_friction,
            )
            for c in rooms.lived_in
        }  # fmt: skip
        exchange = Exchange.begin(rooms.ways, gas, chambers, bag, velocity)
        steps = (chamber.parts(gas.sheets[c], before, dt, parts, time) for c, chamber in chambers.items())
        for middle, *_ in zip(*steps, strict=True):
            exchange.flow(middle, dt / parts)
        exchange.open_passages(time + dt, dt)
        for c, chamber in chambers.items():
            work, against = chamber.push(gas.sheets[c], before, positions, self.supply.ambient.pressure)
            gas.work, gas.ambient_work = gas.work + float(work.sum()), gas.ambient_work + float(against.sum())
            gas.adopted, gas.lost = gas.adopted + chamber.adopted, gas.lost + chamber.lost
            gas.donors += chamber.donors
        for some in rooms.of_chamber:
            whole = max(sum(new[c].total for c in some), 1e-300)
            share = -sum(new[c].inverted for c in some) / whole
            if share > gas.inverted and len(some) > 1:  # by strips it is never less
                share = -inside_out([new[c] for c in some]) / whole
            gas.inverted = max(gas.inverted, share)
        gas.positions, gas.cuts, gas.time = positions, (positions, new, gas.joined.copy()), time + dt
        gas.parts += parts
        if self.strips is not None and gas.parts // LOOK_EVERY > (gas.parts - parts) // LOOK_EVERY:
            for pair in rooms.joining(new):
                self._join(gas, *pair)
        self._close_books(gas)

    def _join(self, gas: MeshState, first: int, second: int) -> None:
        """Two rooms become one."""
        before, sheets = self.rooms(gas).walls, list(gas.sheets)
        gas.joined[gas.joined == second] = first
        walls = self.rooms(gas).walls[first]
        sheets[first] = join_sheets(self.table, sheets[first], sheets[second], before[first], before[second], walls)
        sheets[second] = Sheet.empty(len(self.table))
        gas.sheets, gas.windows[second] = tuple(sheets), Window.none()

    def longest_part(self, gas: MeshState) -> float:
        """Longest part of a step [s]."""
        now = tuple(sheet.held for sheet in gas.sheets)
        if gas.longest is None or any(a is not b for a, b in zip(gas.longest[0], now, strict=True)):
            gas.longest = now, self._longest_part(gas)
        return gas.longest[1]

    def _longest_part(self, gas: MeshState) -> float:
        fast, flow = 0.0, 0.0
        for sheet in gas.sheets:
            n = len(sheet.key)
            if n:
                most = np.empty((-(-n // CHUNK), 2))
                fastest(n, sheet.held, sheet.sound, most)
                fast, flow = max(fast, float(most[:, 0].max())), max(flow, float(most[:, 1].max()))
        limit = COURANT * self.cell / fast if fast > 0.0 else math.inf
        return min(limit, self.flow_limit * self.cell / flow) if flow > 0.0 and self.flow_limit < 1.0 else limit

    def stable_dt(self, gas: MeshState, limit: float) -> float:
        cuts = self.cut(gas)
        return parts_of(
            limit, self.longest_part(gas), MOST_PARTS, sum(len(sheet.key) for sheet in gas.sheets),
            sum(len(cut.fragments.triangle) for cut in cuts), self.surface.triangle_count,
        )  # fmt: skip

    def _close_books(self, gas: MeshState) -> None:
        """Hold what is inside against the books; keep the largest relative errors."""
        came = gas.start_masses + self.supply.delivered(gas.time).sum(axis=0) + gas.drawn
        gap = sum(sheet.masses for sheet in gas.sheets) + gas.out - came
        gas.mass_error = max(gas.mass_error, float(np.abs(gap).max() / came.sum()))
        scale = gas.start_energy + gas.enthalpy_in
        gap = sum(sheet.energy for sheet in gas.sheets) + gas.enthalpy_out + gas.work + gas.heat_lost - scale
        gas.energy_error = max(gas.energy_error, abs(gap) / scale)

    # --- handing over to another gas -------------------------------------------------------------------------------

    def can_hand_over(self, gas: MeshState) -> bool:
        return all(sheet.masses.any() for sheet in gas.sheets)

    def hand_over(self, gas: MeshState, bag: Bag, time: float, dt: float) -> Content:
        """The gas flows to the end of the step and goes; half of the step's work was that of the force at its
        beginning."""
        work, ambient = self._half_work(gas, bag)
        gas.volume = bag.volumes.copy()
        kept = gas.work, gas.ambient_work
        self._flow(gas, bag, time, dt)
        # What the force at the end would have done is given back: another gas does it.
        back = gas.work - kept[0] - work
        gas.work, gas.ambient_work = kept[0] + work, kept[1] + ambient
        rooms, sheets = self._rooms_now(gas)
        masses = np.array([sum(sheet.masses for sheet in some) for some in sheets])
        energy = np.array([sum(sheet.energy for sheet in some) for some in sheets])
        energy += back * energy / energy.sum()
        for sheet in gas.sheets:
            species = sheet.species
            sheet.key, sheet.held = np.empty(0, np.int64), np.empty((0, species + 4))
            sheet.temperature, sheet.sound = np.empty(0), np.empty(0)
            sheet.force[...], sheet.owed[...] = 0.0, 0.0
        return Content(masses, energy, gas.volume.copy(), np.array([room[1] for room in rooms]), gas.is_open.copy())

    def _half_work(self, gas: MeshState, bag: Bag) -> tuple[float, float]:
        """Work [J] of the force at the start of a step over its motion, halved, and the part of it against the
        ambient."""
        work, against, way = 0.0, 0.0, bag.positions - gas.positions
        for walls, sheet in zip(self.rooms(gas).walls, gas.sheets, strict=True):
            moves = way[walls.triangles]
            work += 0.5 * float(np.sum(sheet.force * moves))
            pull = self.supply.ambient.pressure * (walls.sign * walls.outer)[:, None]
            normals = pull * area_vectors(walls.triangles, gas.positions)
            against += 0.5 * float(np.sum(normals[:, None] / 3.0 * moves))
        return work, against

    def book_work(self, gas: MeshState, work: float, ambient_work: float) -> None:
        gas.work += work
        gas.ambient_work += ambient_work

    # --- what users see --------------------------------------------------------------------------------------------

    def _rooms_now(self, gas: MeshState) -> tuple[list[tuple[float, float]], list[list[Sheet]]]:
        """Of each chamber, its pressure [Pa] and temperature [K], and the gas of its rooms."""
        sheets = [[gas.sheets[c] for c in some] for some in self.rooms(gas).of_chamber]
        return [chamber_totals(self.table, *both) for both in zip(sheets, gas.volume.tolist(), strict=True)], sheets

    def totals(self, gas: MeshState) -> GasTotals:
        rooms, sheets = self._rooms_now(gas)
        vented_by, leaked_by, passed = self.supply.outflow_by_name(gas.passed.tolist())
        volume, masses = float(gas.volume.sum()), sum(sheet.masses for sheet in gas.sheets)
        mass = [sum(float(sheet.masses.sum()) for sheet in some) for some in sheets]
        energy = [sum(sheet.energy for sheet in some) for some in sheets]
        heat = sum(p * v for (p, _), v in zip(rooms, gas.volume.tolist(), strict=True))
        gas_constant = mixture_gas_constant(self.table, masses)
        names = self.supply.chambers.names
        each = zip(names, rooms, gas.volume.tolist(), mass, energy, strict=True)
        return GasTotals(
            pressure=heat / volume,
            temperature=heat / gas_constant if gas_constant > 0.0 else self.supply.ambient.temperature,
            volume=volume,
            mass_by_species=masses,
            energy=sum(energy),
            injected=float(sum(i.delivered(gas.time) for i in self.supply.inflators)),
            vented=sum(vented_by.values()),
            leaked=sum(leaked_by.values()),
            drawn_in=float(gas.drawn.sum()),
            work=gas.work,
            ambient_work=gas.ambient_work,
            enthalpy_in=gas.enthalpy_in,
            enthalpy_out=gas.enthalpy_out,
            jet_impulse_in=gas.jet_impulse,
            jet_impulse_out=gas.jet_impulse,
            mass_error=gas.mass_error,
            energy_error=gas.energy_error,
            heat_lost=gas.heat_lost,
            blocked_area=gas.blocked_area,
            vented_by=vented_by,
            leaked_by=leaked_by,
            passed=passed,
            chambers=()
            if len(names) == 1
            else tuple(ChamberTotals(name, p, t, v, m, e) for name, (p, t), v, m, e in each),
        )

    def fields(self, gas: MeshState) -> dict[str, np.ndarray]:
        """Pressure on triangles, and the gas beside them."""
        return on_triangles(self, gas, self.cut(gas))

    def cells(self, gas: MeshState) -> dict[str, np.ndarray]:
        return boxes_of(self, gas, self.cut(gas))

    def at(self, gas: MeshState, places: np.ndarray) -> dict[str, np.ndarray]:
        return at_places(self, gas, self.cut(gas), places)

    def outside(self, positions: np.ndarray, places: np.ndarray, chamber: int) -> np.ndarray:
        return ~is_inside(self.surface.triangles, self.supply.chambers, positions, places, chamber)

    def books(self, gas: MeshState) -> dict[str, float]:
        return {
            "mesh_gas_lost_clusters": float(gas.lost),
            "mesh_gas_donor_clusters": float(gas.donors),
            "mesh_gas_adopted_clusters": float(gas.adopted),
            "mesh_gas_parts": float(gas.parts),
            "mesh_gas_inverted_volume": gas.inverted,
        }

    def verdicts(self, books: Mapping[str, float]) -> Iterator[Criterion]:
        inverted = 100.0 * books["mesh_gas_inverted_volume"]
        yield criterion(
            "volume that is inside out, where fabric lies in itself", inverted, 0.1, 5.0, "%", SMALLER_STEPS
        )
        yield criterion("gas without room", books["mesh_gas_lost_clusters"], 0.5, math.inf, "clusters", SMALLER_STEPS)

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        start = np.ascontiguousarray(setting.start)
        state = self.start(Bag(self.surface, start, np.zeros_like(start)))
        return mesh_concerns(self.cell, self.cut(state), self.strips, setting)

    def remarks(self, gas: MeshState) -> list[str]:
        cells = sum(len(sheet.key) for sheet in gas.sheets)
        lines = [f"mesh gas: {cells} cells at the end, {gas.parts} parts of steps, {gas.donors} donor clusters"]
        if self.strips is not None:
            rooms = len(self.rooms(gas).lived_in)
            lines.append(f"mesh gas: {self.strips.count} strips at the start, {rooms} rooms at the end")
        return lines

    def seconds_per_step(self, gas: MeshState, dt: float, end: float) -> float:
        """Of a bag half inflated."""
        cells = 0.5 * MYLAR_VOLUME * (self.fabric_area / (2.0 * math.pi)) ** 1.5 / self.cell**3
        cut = self.fabric_area / self.cell**2 + self.surface.triangle_count
        parts = max(1.0, dt * 3.0 * 700.0 / self.cell)
        return parts * (SECONDS_PER_CELL * cells + SECONDS_PER_TRIANGLE * cut)
