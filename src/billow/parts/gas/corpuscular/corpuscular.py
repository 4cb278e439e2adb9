"""The corpuscular gas: particles that stand for many molecules each (docs/theory.md, Corpuscular gas and Gas step)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from billow.base.compiled import CHUNK
from billow.base.errors import NumericalStop
from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.geometry.chambers import OUTSIDE
from billow.geometry.search_grid import COARSE, FINE, USUAL, SearchGrid
from billow.geometry.surface import area_vectors
from billow.parts.gas.corpuscular.books import close_books, content, sums_of, take_stock, totals
from billow.parts.gas.corpuscular.cells import Cells, sort_into_cells
from billow.parts.gas.corpuscular.collisions import collide, collision_time
from billow.parts.gas.corpuscular.energy_settlement import lose_heat, settle, thermal_energy
from billow.parts.gas.corpuscular.flight import Flock, Motion, WallResponse, fly
from billow.parts.gas.corpuscular.gas_fields import on_faces, read_boxes, read_points
from billow.parts.gas.corpuscular.impact_bank import Hits, ImpactBank
from billow.parts.gas.corpuscular.inflow import blow, coming, draw_air_in, injectors
from billow.parts.gas.corpuscular.initial_air import fill_with_air
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.merging import Remainder, merge, merges_ahead
from billow.parts.gas.corpuscular.outlets import NO_PASSAGE, pull_out, take_out
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.corpuscular.wall_load import Patches, WallLoad, wall_speed
from billow.parts.gas.corpuscular.winding_number import audit, bring_back, recheck_parked, winding_numbers
from billow.parts.gas.gas_model import Bag, Content, GasTotals, SwitchableGas
from billow.parts.gas.supply.passages import OPENING
from billow.parts.part import MYLAR_VOLUME, Loads

PARTICLE_LOST = NumericalStop.declare(
    "E-NUM-008",
    "the position of a gas particle is not a finite number",
    where="particle {particle} of {count} (number {number}), chamber {chamber}, in the gas step from t = {time:.4f} ms",
    why="its speed is {speed:.4g} m/s; it came from gas at {pressure:.4g} Pa and {temperature:.4g} K in {volume:.4g} l",
    cause="gas that became far too hot or fast, for example in a bag that collapsed",
    remedy="reduce run.dt_scale, or compare with gas.model = uniform-pressure",
)

SMOOTHING = 0.2e-3
"""Time constant [s] of wall pressure and incident flow (docs/theory.md, Smoothing of wall pressure)."""

PATCH_INTERVAL = 0.1e-3
"""Time [s] between two changes of the patches."""

AUDIT_INTERVAL = 0.5e-3
"""Time [s] between two looks whether every particle is in its chamber."""

FREE_TIMES = 0.7
"""Times between two collisions of a particle after which the particles are sorted and collide."""

SORT_EVERY = 2
"""Sorts by cell for each of which the particles themselves are moved: neighbours in space are neighbours in memory."""

CELLS_PER_STEP, EDGES_PER_STEP, GAPS_PER_STEP = 1.3, 3.0, 0.3
"""Way of a particle in a gas step, at most about: in collision cells, in mean edges of the mesh, and in mean distances
between opposite walls. The last keeps a flat bag's gas from answering its walls too late. The first is why particles
may collide more than once between two steps (docs/theory.md, Gas step, has what it was measured to change)."""

FLAT_IN_EDGES, FULL_IN_EDGES = 1.0, 4.0
"""Mean distance between opposite walls, in edges of the mesh, below which the search for walls is fine, because
particles are near a wall wherever they are, and above which it is coarse, because most are far from all of them."""

SOUND_CROSSES = 1.0
"""Gaps that sound crosses in a step of the structure, at most."""

LARGEST_LEAD = 1.1
"""Change of a chamber's volume by which its pressure is led, at most: half a gas step does not change it more."""

SECONDS_PER_PARTICLE, SECONDS_PER_TRIANGLE = 520e-9, 80e-9
"""Rough cost of a particle in a gas step, and of a triangle in a step of the structure."""

USUAL_SPEED, IN_A_CELL = 700.0, 10
"""Root mean square of particles' speeds in warm gas [m/s], and particles in a collision cell, about."""

MOST_STEPS = 8
"""Of the structure within one gas step."""


class Corpuscular(Setup, SwitchableGas):
    """The gas model; its parameters are those of `Setup`."""

    # --- the contract ----------------------------------------------------------------------------------------------

    def start(self, bag: Bag) -> CorpuscularState:
        """The initial gas in the start shape."""
        chambers, species, rows = self.chambers.count, len(self.table), len(self.supply.passages.rows)
        volume = self.chambers.volumes(bag.surface.triangles, bag.positions)
        initial = self.supply.start_gas
        at_start = self.supply.start_amount(volume) @ initial.mass_fractions
        total = sum((i.cumulative[-1] * i.mass_fractions for i in self.supply.inflators), at_start)
        merges = merges_ahead(self.table, at_start, total)
        kinds = ParticleKinds.sharing(self.table, total, self.particles * 2**merges)
        particles = Particles.room_for(self.room)
        fill_with_air(
            particles, kinds, initial.mass_fractions[0], float(initial.pressure[0]), float(initial.temperature[0]),
            volume, self._enclosure(bag.positions), self.seed,
        )  # fmt: skip
        triangles = bag.surface.triangle_count
        gas = CorpuscularState(
            molecules=kinds.molecules, particles=particles, cells=Cells.of(chambers), bank=ImpactBank.empty(triangles),
            load=WallLoad.none(triangles), deliveries=tuple(i.start() for i in injectors(self, kinds, bag.positions)),
            remainder=Remainder.none(chambers, species), positions=bag.positions.copy(),
            pass_probability=np.zeros(triangles), patch=np.zeros(triangles, np.int64),
            is_open=np.zeros(rows, np.bool_), owed=np.zeros((rows, species)), wanted=np.zeros(rows),
            short=np.zeros(rows), pool=np.zeros(chambers), volume=volume, volume_struck=volume,
            pressure=np.zeros(chambers), temperature=initial.temperature.copy(), gamma=np.ones(chambers),
            masses=np.zeros((chambers, species)), left=np.zeros((rows, species)), drawn=np.zeros(species),
            passed=np.zeros(rows), impulse=np.zeros(3), start_masses=np.zeros(species), start_momentum=np.zeros(3),
        )  # fmt: skip
        take_stock(self, gas, kinds)
        gas.start_masses = gas.masses.sum(axis=0)
        gas.start_energy, gas.start_volume = gas.particle_energy, float(volume.sum())
        # Gas at rest strikes every wall as its pressure says; n c/4 molecules a second and area.
        for side, chamber in enumerate((self.chambers.behind, self.chambers.ahead)):
            inside = chamber != OUTSIDE
            density = gas.masses.sum(axis=1) / volume
            speed = np.sqrt(8.0 / np.pi * gas.pressure / np.maximum(density, 1e-300))
            gas.bank.pressure[inside, side] = gas.pressure[chamber[inside]]
            gas.bank.mass_flux[inside, side] = (0.25 * density * speed)[chamber[inside]]
        push = gas.bank.pressure[:, 0] - gas.bank.pressure[:, 1]
        normals = area_vectors(bag.surface.triangles, bag.positions)
        gas.load = WallLoad.of_pressure(push, normals)
        gas.start_momentum = gas.sums.momentum.sum(axis=0)
        self._regulate(gas, bag, np.linalg.norm(normals, axis=1), 0.0)
        gas.sums = None  # a checkpoint may be restored into this state
        return gas

    def advance(self, gas: CorpuscularState, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        gas.volume = bag.volumes.copy()
        if dt > 0.0:
            if gas.steps_to_go <= 0:
                self._gas_step(gas, bag, time + dt, dt)
            gas.steps_to_go -= 1
        gas.energy_waiting = gas.load.push(
            self.solid, self.ambient_load, self._lead(gas), bag.surface.triangles, bag.positions, bag.velocities, dt,
            loads.at_corners(),
        )  # fmt: skip

    def _lead(self, gas: CorpuscularState) -> np.ndarray:
        """Pressure on each triangle [Pa], (triangles,), that the present volumes add to that of the last gas step."""
        grown = np.clip(gas.volume_struck / np.maximum(gas.volume, 1e-300), 1.0 / LARGEST_LEAD, LARGEST_LEAD)
        lead = np.append(gas.pressure * (grown**gas.gamma - 1.0), 0.0)
        return lead[self.chambers.behind] - lead[self.chambers.ahead]  # OUTSIDE, -1, is the last entry

    def _gas_step(self, gas: CorpuscularState, bag: Bag, time: float, dt: float) -> None:
        """Bring the particles to `time` [s]; dt: of the structure's step."""
        span = time - gas.gas_time
        kinds = self._merge(gas, time)
        lose_heat(self, gas, span)
        self._settle(gas, kinds)
        born = blow(self, gas, kinds, bag, span)
        flock = self._fly(gas, kinds, bag, span, born)
        pulled = pull_out(gas, kinds, self.outlets, bag, flock, span)
        take_out(gas, kinds, self.outlets, bag, flock, pulled)
        if time >= gas.next_audit:
            gas.next_audit = time + AUDIT_INTERVAL
            flock = _flock(gas.particles)
            before = flock.chamber.copy()
            escaped = audit(flock, self._enclosure(bag.positions))
            self._book_strays(gas, kinds, flock, before)
            gas.escaped += len(escaped)
            bring_back(flock, escaped)
        draw_air_in(self, gas, kinds, bag)
        self._collide(gas, kinds, span)
        before = self.chambers.volumes(bag.surface.triangles, gas.positions)
        gas.volume_struck = 0.5 * (before + gas.volume)
        gas.positions[...] = bag.positions
        gas.gas_time = time
        gas.gas_step += 1
        take_stock(self, gas, kinds)
        self._press(gas, bag, span)
        close_books(self, gas, kinds)
        gas.steps_to_go = self._steps(gas, dt)

    # --- parts of a gas step ---------------------------------------------------------------------------------------

    def _merge(self, gas: CorpuscularState, time: float) -> ParticleKinds:
        """Merge particles until those coming up to `time` [s] have room; returns what particles are from now on."""
        kinds = self.kinds(gas)
        while gas.particles.count + coming(self, gas, kinds, time) > self.room:
            sort_into_cells(gas.cells, gas.particles, self.seed, gas.gas_step)
            gas.pool += merge(gas.particles, kinds, gas.cells, gas.remainder, self.seed, gas.merges)
            for delivery in gas.deliveries:
                delivery.born *= 0.5
            gas.sums = None
            gas.merges += 1
            gas.molecules *= 2.0
            kinds = self.kinds(gas)
        return kinds

    def _settle(self, gas: CorpuscularState, kinds: ParticleKinds) -> None:
        """Return what the walls did not take, and what is pooled."""
        sums = sums_of(self, gas, kinds)
        thermal = thermal_energy(sums, kinds.mass)
        back = (gas.in_bank - gas.energy_waiting) * thermal / max(thermal.sum(), 1e-300)
        given = settle(gas.particles, sums, kinds.mass, gas.pool + back)
        returned = given - gas.pool
        gas.pool[...] = 0.0
        gas.energy_returned += float(returned.sum())

    def _fly(
        self, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag, span: float, born: np.ndarray | None
    ) -> Flock:
        triangles, n = bag.surface.triangles, gas.particles.count
        gap = self._gap(gas) / self.edge
        fineness = FINE if gap < FLAT_IN_EDGES else USUAL if gap < FULL_IN_EDGES else COARSE
        if gas.grid is None:
            gas.grid = SearchGrid.build(triangles, gas.positions, bag.positions, fineness=fineness)
        gas.grid = gas.grid.follow(triangles, gas.positions, bag.positions, fineness)
        if gas.hits is None or len(gas.hits.count) * CHUNK < n:
            gas.hits = Hits.empty(gas.particles.capacity)
        flock = _flock(gas.particles)
        if gas.patches is None:
            gas.patches = Patches.of(gas.patch)
        speed = wall_speed(gas.patches, triangles, gas.positions, bag.positions, span)
        tally = fly(
            flock, kinds.mass, self.walls, gas.grid, Motion(gas.positions, bag.positions, span),
            WallResponse(gas.pass_probability, self.outlets.passage, speed), gas.hits, gas.bank, self.seed,
            gas.gas_step, born,
        )  # fmt: skip
        if tally.bad >= 0:
            particles, speed = gas.particles, np.linalg.norm(gas.particles.velocity[tally.bad])
            raise PARTICLE_LOST(
                particle=tally.bad, count=n, number=particles.identity[tally.bad],
                chamber=self.chambers.names[particles.chamber[tally.bad]], time=1e3 * gas.gas_time, speed=speed,
                pressure=gas.pressure.max(), temperature=gas.temperature.max(), volume=1e3 * gas.volume.min(),
            )  # fmt: skip
        if self.supply.passages.rows:
            gas.passed += tally.through
        gas.energy_at_walls += tally.energy_to_walls
        if tally.parked:
            gas.parked += tally.parked
            before = flock.chamber.copy()
            recheck_parked(flock, self._enclosure(bag.positions))
            self._book_strays(gas, kinds, flock, before)
        return flock

    def _book_strays(self, gas: CorpuscularState, kinds: ParticleKinds, flock: Flock, before: np.ndarray) -> None:
        """Book particles whose chamber was corrected as gas that went through the opening between the two.

        before: (particles,) int32, chambers until now."""
        strays = np.flatnonzero(flock.chamber != before)
        for k, row in enumerate(self.supply.passages.rows if len(strays) else ()):
            if row.kind == OPENING:
                mass = kinds.mass[flock.species[strays]]
                left, entered = before[strays], flock.chamber[strays]
                gas.passed[k] += float(mass[(left == row.behind) & (entered == row.ahead)].sum())
                gas.passed[k] -= float(mass[(left == row.ahead) & (entered == row.behind)].sum())

    def _enclosure(self, positions: np.ndarray) -> Enclosure:
        return Enclosure(self.surface.triangles, positions, self.chambers, self.group)

    def _collide(self, gas: CorpuscularState, kinds: ParticleKinds, span: float) -> None:
        """Collisions of the time since the last ones, as soon as it is worth the sorting."""
        gas.since_collisions += span
        if gas.since_collisions < FREE_TIMES * gas.collision_time:
            return
        sort_into_cells(gas.cells, gas.particles, self.seed, gas.gas_step)
        if gas.sorts % SORT_EVERY == 0:
            n = gas.particles.count
            order = gas.cells.order[:n]
            gas.particles.reorder(order)
            gas.cells.cell[:n] = gas.cells.cell[order]
            gas.cells.order[:n] = np.arange(n, dtype=np.int32)
        collide(gas.cells, gas.particles, kinds, gas.since_collisions, self.seed, gas.gas_step)
        gas.sorts += 1
        gas.since_collisions = 0.0
        mass = gas.masses.sum(axis=0)
        warmest = float(gas.temperature.max())
        if mass.any():  # not yet when the first particles have just come into a vacuum
            gas.collision_time = collision_time(gas.cells, kinds, mass / mass.sum(), warmest)

    def _press(self, gas: CorpuscularState, bag: Bag, span: float) -> None:
        """Hand the impulses of this step to the fabric, and set the outlets for the next one."""
        normals = area_vectors(bag.surface.triangles, bag.positions)
        area = np.sqrt(normals[:, 0] ** 2 + normals[:, 1] ** 2 + normals[:, 2] ** 2)
        gas.load.renew(self._patches(gas, area), gas.bank.held, normals, span)
        gas.bank.smooth(area, span, SMOOTHING)
        self._regulate(gas, bag, area, span)

    def _patches(self, gas: CorpuscularState, area: np.ndarray) -> Patches:
        """The patches impulses are spread over; they follow the gas every now and then."""
        if gas.gas_time >= gas.next_patches:
            gas.next_patches = gas.gas_time + PATCH_INTERVAL
            struck = gas.bank.mass_flux.sum(axis=1) * area
            gas.patch = self.squares.patches(struck * (gas.particles.count / max(struck.sum(), 1e-300)))
            gas.patches = None
        if gas.patches is None:
            gas.patches = Patches.of(gas.patch)
        return gas.patches

    def _regulate(self, gas: CorpuscularState, bag: Bag, area: np.ndarray, span: float) -> None:
        if not self.supply.passages.rows:
            return
        particle_mass = gas.masses.sum(axis=1) / np.maximum(gas.sums.particles.sum(axis=1), 1)
        areas = self.supply.passages.measure(bag.surface.triangles, bag.positions, bag.touched)
        self.outlets.regulate(gas, areas, area, np.maximum(particle_mass, 1e-300), 2.0 * SMOOTHING, span)

    def _steps(self, gas: CorpuscularState, dt: float) -> int:
        """Steps of the structure that the next gas step may take."""
        speed = self._speed(gas)
        if speed == 0.0:
            return 1
        cell = float(gas.cells.size[gas.cells.size > 0.0].min())
        way = min(CELLS_PER_STEP * cell, EDGES_PER_STEP * self.edge, GAPS_PER_STEP * self._gap(gas))
        return max(1, min(MOST_STEPS, int(way / (speed * dt))))

    def _speed(self, gas: CorpuscularState) -> float:
        """Root mean square of the particles' speeds [m/s]."""
        mass = gas.masses.sum()
        return math.sqrt(2.0 * gas.sums.flight_energy.sum() / mass) if mass > 0.0 else 0.0

    def _gap(self, gas: CorpuscularState) -> float:
        """Mean distance of opposite walls [m]."""
        return 2.0 * float(gas.volume.sum() / self.flat_area.sum())

    def stable_dt(self, gas: CorpuscularState, limit: float) -> float:
        """The gap over the speed of sound: between light walls gas is a stiff spring that answers half a step late."""
        density = gas.masses.sum() / gas.volume.sum()
        pressure = float(gas.pressure @ gas.volume / gas.volume.sum())
        return min(limit, SOUND_CROSSES * self._gap(gas) / math.sqrt(float(gas.gamma.max()) * pressure / density))

    # --- handing over to another gas -------------------------------------------------------------------------------

    def can_hand_over(self, gas: CorpuscularState) -> bool:
        return bool(gas.masses.any(axis=1).all())

    def hand_over(self, gas: CorpuscularState, bag: Bag, time: float, dt: float) -> Content:
        """The particles fly to the end of the step and go; their books stay."""
        triangles = bag.surface.triangles
        gas.volume = bag.volumes.copy()
        self._gas_step(gas, bag, time + dt, dt)
        gas.load.force.fill(0.0)
        nothing = np.zeros(len(triangles))
        no_force = np.zeros((len(triangles), 3, 3))
        gas.load.push(self.solid, nothing, nothing, triangles, bag.positions, bag.velocities, dt, no_force)
        before = area_vectors(triangles, bag.positions - dt * bag.velocities)
        rate = np.sum(before * bag.velocities[triangles].mean(axis=1), axis=1)
        gas.load.ambient_work += 0.5 * dt * float(self.ambient_load @ rate)
        masses, energy = content(self, gas)
        given = Content(masses, energy, gas.volume.copy(), gas.temperature.copy(), gas.is_open.copy())
        gas.particles, gas.cells = Particles.room_for(0), Cells.of(self.chambers.count)
        gas.grid = gas.hits = gas.sums = gas.patches = None
        return given

    def book_work(self, gas: CorpuscularState, work: float, ambient_work: float) -> None:
        gas.load.work += work
        gas.load.ambient_work += ambient_work

    # --- what users see --------------------------------------------------------------------------------------------

    def totals(self, gas: CorpuscularState) -> GasTotals:
        return totals(self, gas)

    def fields(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        behind, ahead = self.chambers.behind, self.chambers.ahead
        inner = np.where(behind == OUTSIDE, self.supply.ambient.pressure, gas.bank.pressure[:, 0])
        outer = np.where(ahead == OUTSIDE, self.supply.ambient.pressure, gas.bank.pressure[:, 1])
        bag = self._enclosure(gas.positions)  # as it was at the last gas step
        boxes = read_boxes(gas.particles, self.kinds(gas), bag)
        return {"gauge_pressure": inner - outer} | on_faces(boxes, bag, gas.temperature)

    def cells(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        return read_boxes(gas.particles, self.kinds(gas), self._enclosure(gas.positions)).arrays()

    def points(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        n, particles = gas.particles.count, gas.particles
        names = "position", "velocity", "internal_energy", "species", "chamber"
        return {name: getattr(particles, name)[:n] for name in names}

    def at(self, gas: CorpuscularState, places: np.ndarray) -> dict[str, np.ndarray]:
        bag = self._enclosure(gas.positions)
        return read_points(places, gas.particles, self.kinds(gas), bag, self.supply.ambient)

    def outside(self, positions: np.ndarray, places: np.ndarray, chamber: int) -> np.ndarray:
        return winding_numbers(places, np.full(len(places), chamber), self._enclosure(positions)) < 1

    def books(self, gas: CorpuscularState) -> dict[str, float]:
        return {"leaked_particles": float(gas.escaped), "leaked_particles_share": gas.escaped / self.particles}

    def verdicts(self, books: Mapping[str, float]) -> Iterator[Criterion]:
        share = 100.0 * books["leaked_particles_share"]
        yield criterion("particles found outside, of all", share, 0.01, 1.0, "%", SMALLER_STEPS)

    def remarks(self, gas: CorpuscularState) -> list[str]:
        return [f"particles found outside and put back: {gas.escaped}"]

    def seconds_per_step(self, gas: CorpuscularState, dt: float, end: float) -> float:
        """A gas step of all the particles there may be in a bag half inflated, spread over the steps it takes."""
        volume = 0.5 * MYLAR_VOLUME * (float(self.flat_area.sum()) / (2.0 * math.pi)) ** 1.5
        way = min(CELLS_PER_STEP * (IN_A_CELL * volume / self.particles) ** (1.0 / 3.0), EDGES_PER_STEP * self.edge)
        steps = max(1, min(MOST_STEPS, int(way / (USUAL_SPEED * dt))))
        return SECONDS_PER_PARTICLE * self.particles / steps + SECONDS_PER_TRIANGLE * len(self.surface.triangles)


def _flock(particles: Particles) -> Flock:
    """The particles that exist, as flight takes them."""
    n = particles.count
    return Flock(
        particles.position[:n], particles.velocity[:n], particles.species[:n], particles.identity[:n],
        particles.chamber[:n], np.full(n, NO_PASSAGE, np.int32), particles.overlap[:n], particles.group_overlap[:n],
    )  # fmt: skip
