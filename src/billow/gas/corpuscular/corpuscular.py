"""The corpuscular gas: particles that stand for many molecules each (LS-DYNA paper, section 4.3; Olovsson 2007).

The gas steps at its own rate: every few steps of the structure its particles fly to the present time, while the surface
moves evenly from where it was at the last gas step. Then newborns come in, those outside are taken out, particles that
share a cell collide, and debts of energy are settled. In between only the bank pushes. Before there would be too many
particles, every two are merged into one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.compiled import CHUNK, scalar
from billow.errors import NumericalStop
from billow.gas.ambient import Ambient, InitialGas
from billow.gas.corpuscular.audit import audit, bring_back, house_parked
from billow.gas.corpuscular.balance import settle, thermal_energy
from billow.gas.corpuscular.cells import Cells, sort_into_cells
from billow.gas.corpuscular.collisions import collide, collision_time
from billow.gas.corpuscular.drawn_in import draw_in
from billow.gas.corpuscular.flight import Flock, Walls, fly
from billow.gas.corpuscular.impact_bank import Hits, ImpactBank
from billow.gas.corpuscular.initial_air import fill_with_air
from billow.gas.corpuscular.injection import Injector, Nozzles
from billow.gas.corpuscular.internal_energy import ParticleKinds
from billow.gas.corpuscular.leaving import pull_out, take_out
from billow.gas.corpuscular.merging import Remainder, merge, merges_ahead
from billow.gas.corpuscular.outlets import NO_PASSAGE, Outlets
from billow.gas.corpuscular.particles import Particles, ParticleSums, sum_particles
from billow.gas.corpuscular.random_numbers import stream, uniform
from billow.gas.corpuscular.readings import Inside, on_faces, read_boxes, read_points
from billow.gas.corpuscular.state import CorpuscularState
from billow.gas.corpuscular.wall_load import Patches, Squares, WallLoad, wall_speed
from billow.gas.gas_model import Bag, ChamberTotals, GasTotals
from billow.gas.inflator import Inflator
from billow.gas.jets import Jets
from billow.gas.mixture import (
    mixture_cp,
    mixture_enthalpy,
    mixture_gas_constant,
    mixture_temperature,
)
from billow.gas.passages import FABRIC, NO_PASSAGES, Passages
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.search_grid import SearchGrid
from billow.geometry.surface import Surface, area_vectors

SMOOTHING = 0.2e-3
"""Time constant [s] of wall pressure and incident flow (physics notes, section 2)."""

PATCH_INTERVAL = 0.1e-3
"""Time [s] between two changes of the patches."""

AUDIT_INTERVAL = 0.5e-3
"""Time [s] between two looks whether every particle is in its chamber."""

FREE_TIMES = 0.7
"""Times between two collisions of a particle after which the particles are sorted and collide."""

SORT_EVERY = 2
"""Sorts by cell for each of which the particles themselves are moved: neighbours in space are neighbours in memory."""

CELLS_PER_STEP, EDGES_PER_STEP, GAPS_PER_STEP = 1.0, 3.0, 0.3
"""Way of a particle in a gas step, at most about: in collision cells, in mean edges of the mesh, and in mean distances
between opposite walls. The last keeps a flat bag's gas from answering its walls too late."""

SOUND_CROSSES = 1.0
"""Gaps that sound crosses in a step of the structure, at most."""

FAINTEST = 1e-6
"""Pressure [Pa] a jet blows against, at least: into a vacuum it is choked."""

LARGEST_LEAD = 1.1
"""Change of a chamber's volume by which its pressure is led, at most: half a gas step does not change it more."""

MOST_STEPS = 8
"""Of the structure within one gas step."""


BIRTH_TIME = 0x4249_5254
"""Names the random numbers that say when in a step a particle is born."""


@dataclass(frozen=True)
class Source:
    """An inflator in its mouth, and the ring of its holes."""

    inflator: Inflator
    jets: Jets


@dataclass(frozen=True)
class Corpuscular:
    """Parameters of the gas; see the classes they belong to.

    table: (species, 16), species.thermo_table. surface: of the bag, its chambers and kinds of parts. reference: flat
    corner coordinates [m], (triangles, 3, 2). particles: as many as there are at most (to 2 %); at the start at least
    half of them, unless there is hardly any gas. initial: ambient air by default. seed: of the random numbers.
    """

    table: np.ndarray
    species_names: tuple[str, ...]
    sources: tuple[Source, ...]
    ambient: Ambient
    surface: Surface
    reference: np.ndarray
    passages: Passages = NO_PASSAGES
    initial: InitialGas | None = None
    particles: int = 100_000
    seed: int = 1

    # --- what never changes ----------------------------------------------------------------------------------------

    @property
    def chambers(self) -> Chambers:
        return self.surface.chambers

    @property
    def _room(self) -> int:
        """Particles there may be; more than `particles`, lest the last ones to come, one too many, cause a merge."""
        return self.particles + self.particles // 50 + 64

    @property
    def inflators(self) -> tuple[Inflator, ...]:
        return tuple(source.inflator for source in self.sources)

    @cached_property
    def _walls(self) -> Walls:
        return Walls.build(self.surface.triangles, self.chambers.behind, self.chambers.ahead)

    @cached_property
    def _outlets(self) -> Outlets:
        return Outlets.build(self.table, self.passages, self.ambient, self.surface.triangles)

    @cached_property
    def _solid(self) -> np.ndarray:
        """(triangles,) bool: whether there is anything to push on."""
        return np.array([kind in ("fabric", "mouth") for kind in self.surface.part_kinds])[self.surface.part]

    @cached_property
    def _ambient_load(self) -> np.ndarray:
        """Ambient pressure against the normal of each triangle [Pa], (triangles,): on fabric and mouth from outside."""
        behind, ahead = self.chambers.behind, self.chambers.ahead
        side = (ahead == OUTSIDE) * 1.0 - (behind == OUTSIDE) * 1.0
        return np.where(self._solid, side * self.ambient.pressure, 0.0)

    @cached_property
    def _flat_area(self) -> np.ndarray:
        """Of each triangle of the flat cut [m^2], (triangles,)."""
        edges = self.reference[:, 1:] - self.reference[:, :1]
        return 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])

    @cached_property
    def _edge(self) -> float:
        """Mean edge of the mesh [m], as if all triangles were equilateral."""
        return math.sqrt(4.0 / math.sqrt(3.0) * float(self._flat_area.mean()))

    @cached_property
    def _squares(self) -> Squares:
        return Squares.of(self.reference.mean(axis=1), self.surface.part, self._edge)

    def _injectors(self, kinds: ParticleKinds, positions: np.ndarray) -> list[Injector]:
        injectors = []
        for source in self.sources:
            holes, frames, (axis, _, _) = source.jets.nozzles(positions)
            ring = source.jets.ring
            centre = positions[source.jets.mouth_nodes].mean(axis=0)
            nozzles = Nozzles(
                holes - centre, frames[:, 0], np.full(ring.count, source.inflator.chamber, np.int32),
                0.5 * ring.hole_diameter, ring.cone, axis, ring.spin,
            )  # fmt: skip
            injectors.append(Injector(kinds, source.inflator, nozzles))
        return injectors

    # --- the contract ----------------------------------------------------------------------------------------------

    def start(self, bag: Bag) -> CorpuscularState:
        """The initial gas in the start shape."""
        chambers, species, rows = self.chambers.count, len(self.table), len(self.passages.rows)
        volume = self.chambers.volumes(bag.surface.triangles, bag.positions)
        initial = self.initial or InitialGas.like(self.ambient, chambers)
        specific = initial.mass_fractions @ self.table[:, 0]
        at_start = (initial.pressure * volume / (specific * initial.temperature)) @ initial.mass_fractions
        total = at_start.copy()
        for inflator in self.inflators:
            total = total + inflator.cumulative[-1] * inflator.mass_fractions
        merges = merges_ahead(self.table, at_start, total)
        kinds = ParticleKinds.sharing(self.table, total, self.particles * 2**merges)
        particles = Particles.room_for(self._room)
        fill_with_air(
            particles, kinds, initial.mass_fractions[0], float(initial.pressure[0]), float(initial.temperature[0]),
            volume, bag.surface.triangles, bag.positions, self.chambers.behind, self.chambers.ahead, self.seed,
        )  # fmt: skip
        triangles = bag.surface.triangle_count
        gas = CorpuscularState(
            molecules=kinds.molecules,
            particles=particles,
            cells=Cells.of(chambers),
            bank=ImpactBank.empty(triangles),
            load=WallLoad.none(triangles),
            deliveries=tuple(i.start() for i in self._injectors(kinds, bag.positions)),
            remainder=Remainder.none(chambers, species),
            positions=bag.positions.copy(),
            pass_probability=np.zeros(triangles),
            patch=np.zeros(triangles, np.int64),
            is_open=np.zeros(rows, np.bool_),
            owed=np.zeros((rows, species)),
            wanted=np.zeros(rows),
            short=np.zeros(rows),
            pool=np.zeros(chambers),
            volume=volume,
            volume_struck=volume,
            pressure=np.zeros(chambers),
            temperature=initial.temperature.copy(),
            gamma=np.ones(chambers),
            masses=np.zeros((chambers, species)),
            left=np.zeros((rows, species)),
            drawn=np.zeros(species),
            passed=np.zeros(rows),
            impulse=np.zeros(3),
            start_masses=np.zeros(species),
            start_momentum=np.zeros(3),
        )
        self._take_stock(gas, kinds)
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

    def advance(self, gas: CorpuscularState, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        gas.volume = self.chambers.volumes(bag.surface.triangles, bag.positions)
        if dt > 0.0:
            if gas.steps_to_go <= 0:
                self._gas_step(gas, bag, time + dt, dt)
            gas.steps_to_go -= 1
        gas.energy_waiting = gas.load.push(
            self._solid, self._ambient_load, self._lead(gas), bag.surface.triangles, bag.positions, bag.velocities, dt,
            corner_force,
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
        self._settle(gas, kinds)
        born = self._blow(gas, kinds, bag, span)
        flock = self._fly(gas, kinds, bag, span, born)
        pulled = pull_out(gas, kinds, self._outlets, self.passages, bag, flock, span)
        take_out(gas, kinds, self._outlets, self.passages, bag, flock, pulled)
        if time >= gas.next_audit:
            gas.next_audit = time + AUDIT_INTERVAL
            self._audit(gas, bag)
        self._draw_in(gas, kinds, bag)
        self._collide(gas, kinds, span)
        before = self.chambers.volumes(bag.surface.triangles, gas.positions)
        gas.volume_struck = 0.5 * (before + gas.volume)
        gas.positions[...] = bag.positions
        gas.gas_time = time
        gas.gas_step += 1
        self._take_stock(gas, kinds)
        self._press(gas, bag, span)
        self._close_books(gas, kinds)
        gas.steps_to_go = self._steps(gas, kinds, dt)

    # --- parts of a gas step ---------------------------------------------------------------------------------------

    def _merge(self, gas: CorpuscularState, time: float) -> ParticleKinds:
        """Merge particles until those coming up to `time` [s] have room; returns what particles are from now on."""
        kinds = ParticleKinds(self.table, gas.molecules)
        while gas.particles.count + self._coming(gas, kinds, time) > self._room:
            sort_into_cells(gas.cells, gas.particles, self.seed, gas.gas_step)
            gas.pool += merge(gas.particles, kinds, gas.cells, gas.remainder, self.seed, gas.merges)
            for delivery in gas.deliveries:
                delivery.born *= 0.5
            gas.sums = None
            gas.merges += 1
            gas.molecules *= 2.0
            kinds = ParticleKinds(self.table, gas.molecules)
        return kinds

    def _coming(self, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> float:
        """Particles that inflators blow, and passages draw in, up to `time` [s]."""
        return float(((self._pending(gas, kinds, time) + gas.owed.sum(axis=0)) / kinds.mass).sum())

    def _settle(self, gas: CorpuscularState, kinds: ParticleKinds) -> None:
        """Return what the walls did not take, and what is pooled."""
        sums = self._sums(gas, kinds)
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
        if gas.grid is None:
            gas.grid = SearchGrid.build(triangles, gas.positions, bag.positions)
        gas.grid = gas.grid.follow(triangles, gas.positions, bag.positions)
        if gas.hits is None or len(gas.hits.count) * CHUNK < n:
            gas.hits = Hits.empty(gas.particles.capacity)
        flock = _flock(gas.particles)
        if gas.patches is None:
            gas.patches = Patches.of(gas.patch)
        speed = wall_speed(gas.patches, triangles, gas.positions, bag.positions, span)
        tally = fly(
            flock, kinds.mass, self._walls, gas.grid, gas.positions, bag.positions, span, gas.pass_probability, 0.0,
            self.seed, gas.gas_step, gas.hits, gas.bank, born, self._outlets.passage, speed,
        )  # fmt: skip
        if tally.bad >= 0:
            raise self._lost(gas, tally.bad)
        if self.passages.rows:
            gas.passed += tally.through
        gas.energy_at_walls += tally.energy_to_walls
        if tally.parked:
            gas.parked += tally.parked
            house_parked(flock, *self._surface_now(bag))
        return flock

    def _lost(self, gas: CorpuscularState, bad: int) -> NumericalStop:
        """What to say of a particle that is nowhere."""
        particles = gas.particles
        speed = float(np.linalg.norm(particles.velocity[bad]))
        return NumericalStop(
            "E-NUM-008",
            "a particle of the gas is nowhere: its place is not a finite number",
            where=f"particle {bad} of {particles.count} (number {particles.identity[bad]}), chamber "
            f"{self.chambers.names[particles.chamber[bad]]}, in the gas step from t = {1e3 * gas.gas_time:.4f} ms",
            why=f"its speed is {speed:.4g} m/s; gas at {gas.pressure.max():.4g} Pa and {gas.temperature.max():.4g} K "
            f"in {1e3 * gas.volume.min():.4g} l gave it that",
            remedy="reduce run.dt_scale, or compare with gas.model = uniform-pressure",
        )

    def _surface_now(self, bag: Bag) -> tuple[np.ndarray, ...]:
        """Triangles, positions, and the chambers on both sides, as `depths` takes them."""
        return bag.surface.triangles, bag.positions, self.chambers.behind, self.chambers.ahead

    def _audit(self, gas: CorpuscularState, bag: Bag) -> None:
        """Book and bring back who is not in its chamber."""
        flock = _flock(gas.particles)
        escaped = audit(flock, *self._surface_now(bag))
        if len(escaped):
            gas.escaped += len(escaped)
            bring_back(flock, escaped)

    def _draw_in(self, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag) -> None:
        """Air from outside, where that has the higher pressure."""
        ambient = self.ambient
        for k, row in enumerate(self.passages.rows):
            number = np.floor(gas.owed[k] / kinds.mass).astype(np.int64)
            if not number.any():
                continue
            mass = number * kinds.mass
            chamber, inward = (row.behind, -1.0) if row.ahead == OUTSIDE else (row.ahead, 1.0)
            energy, impulse = draw_in(
                gas.particles, kinds, number, ambient.temperature, chamber, bag.surface.triangles[row.triangles],
                bag.positions, inward, self.seed,
            )  # fmt: skip
            enthalpy = mixture_enthalpy(self.table, mass, ambient.temperature)
            gas.owed[k] -= mass
            gas.drawn += mass
            gas.enthalpy_in += enthalpy
            gas.pool[chamber] += enthalpy - energy
            gas.impulse += impulse

    def _blow(self, gas: CorpuscularState, kinds: ParticleKinds, bag: Bag, span: float) -> np.ndarray | None:
        """Newborn particles from the inflators; returns at which fraction of the step each particle starts to fly."""
        first = gas.particles.count
        for source, injector, delivery in zip(
            self.sources, self._injectors(kinds, gas.positions), gas.deliveries, strict=True
        ):
            mouth, one = source.jets.mouth_nodes, gas.particles.count
            offered = delivery.offered
            start, end = gas.positions[mouth].mean(axis=0), bag.positions[mouth].mean(axis=0)
            birth = injector.blow(
                delivery, gas.particles, gas.gas_time, span, start, (end - start) / span,
                max(float(gas.pressure[source.inflator.chamber]), FAINTEST), 0.0, self.seed,
            )  # fmt: skip
            gas.enthalpy_in += delivery.offered - offered + birth.carried_energy
            gas.impulse += birth.impulse
            when = self._birth_times(gas, one)
            gas.particles.position[one : gas.particles.count] += when[:, None] * (end - start)
        if gas.particles.count == first:
            return None
        return np.concatenate([np.zeros(first), self._birth_times(gas, first)])

    def _birth_times(self, gas: CorpuscularState, first: int) -> np.ndarray:
        """Fractions of the step at which the particles from `first` on are born, (newborns,)."""
        times = np.empty(gas.particles.count - first)
        _draw_uniform(gas.particles.identity[first : gas.particles.count], self.seed + BIRTH_TIME, times)
        return times

    def _collide(self, gas: CorpuscularState, kinds: ParticleKinds, span: float) -> None:
        """Collisions of the time since the last ones, as soon as it is worth the sorting."""
        gas.since_collisions += span
        if gas.since_collisions < FREE_TIMES * gas.collision_time:
            return
        sort_into_cells(gas.cells, gas.particles, self.seed, gas.gas_step)
        if gas.sorts % SORT_EVERY == 0:
            self._put_in_order(gas)
        collide(gas.cells, gas.particles, kinds, gas.since_collisions, self.seed, gas.gas_step)
        gas.sorts += 1
        gas.since_collisions = 0.0
        mass = gas.masses.sum(axis=0)
        warmest = float(gas.temperature.max())
        if mass.any():  # not yet when the first particles have just come into a vacuum
            gas.collision_time = collision_time(gas.cells, kinds, mass / mass.sum(), warmest)

    def _put_in_order(self, gas: CorpuscularState) -> None:
        """Particles of a cell side by side in memory."""
        n = gas.particles.count
        order = gas.cells.order[:n].copy()
        for array in gas.particles.arrays():
            array[:n] = array[order]
        gas.cells.cell[:n] = gas.cells.cell[order]
        gas.cells.order[:n] = np.arange(n, dtype=np.int32)

    def _take_stock(self, gas: CorpuscularState, kinds: ParticleKinds) -> None:
        """Masses, energy, pressure and temperature from the particles."""
        gas.sums = sums = sum_particles(gas.particles, kinds.mass, self.chambers.count)
        gas.masses = sums.particles * kinds.mass
        gas.particle_energy = sums.energy
        weight = np.maximum(gas.masses.sum(axis=1), 1e-300)
        drift = 0.5 * np.sum(sums.momentum**2, axis=1) / weight
        gas.pressure = 2.0 / 3.0 * (sums.flight_energy - drift) / gas.volume  # LS-DYNA paper, equation 8
        thermal = thermal_energy(sums, kinds.mass)
        for c in range(self.chambers.count):
            if thermal[c] > 0.0:
                masses, guess = gas.masses[c], gas.temperature[c]
                gas.temperature[c] = mixture_temperature(self.table, masses, thermal[c], guess)
                capacity = mixture_cp(self.table, masses, gas.temperature[c])
                gas.gamma[c] = capacity / (capacity - mixture_gas_constant(self.table, masses))

    def _press(self, gas: CorpuscularState, bag: Bag, span: float) -> None:
        """Hand the impulses of this step to the fabric, and set the outlets for the next one."""
        normals = area_vectors(bag.surface.triangles, bag.positions)
        area = np.linalg.norm(normals, axis=1)
        gas.load.renew(self._patches(gas, area), gas.bank.held, normals, span)
        gas.bank.smooth(area, span, SMOOTHING)
        self._regulate(gas, bag, area, span)

    def _patches(self, gas: CorpuscularState, area: np.ndarray) -> Patches:
        """The patches impulses are spread over; they follow the gas every now and then."""
        if gas.gas_time >= gas.next_patches:
            gas.next_patches = gas.gas_time + PATCH_INTERVAL
            struck = gas.bank.mass_flux.sum(axis=1) * area
            gas.patch = self._squares.patches(struck * (gas.particles.count / max(struck.sum(), 1e-300)))
            gas.patches = None
        if gas.patches is None:
            gas.patches = Patches.of(gas.patch)
        return gas.patches

    def _regulate(self, gas: CorpuscularState, bag: Bag, area: np.ndarray, span: float) -> None:
        if not self.passages.rows:
            return
        particle_mass = gas.masses.sum(axis=1) / np.maximum(gas.sums.particles.sum(axis=1), 1)
        drawn, blocked, gas.wanted = self._outlets.regulate(
            gas.pass_probability, gas.is_open, gas.short,
            self.passages.measure(bag.surface.triangles, bag.positions, bag.touched), area, gas.bank.pressure,
            gas.bank.mass_flux, gas.pressure, gas.masses, gas.temperature,
            np.maximum(particle_mass, 1e-300), 2.0 * SMOOTHING, gas.gas_time, span,
        )  # fmt: skip
        gas.owed += drawn[:, None] * self.ambient.mass_fractions
        gas.blocked_area = float(blocked.sum())

    def _steps(self, gas: CorpuscularState, kinds: ParticleKinds, dt: float) -> int:
        """Steps of the structure that the next gas step may take."""
        speed = self._speed(gas)
        if speed == 0.0:
            return 1
        cell = float(gas.cells.size[gas.cells.size > 0.0].min())
        way = min(CELLS_PER_STEP * cell, EDGES_PER_STEP * self._edge, GAPS_PER_STEP * self._gap(gas))
        return max(1, min(MOST_STEPS, int(way / (speed * dt))))

    def _speed(self, gas: CorpuscularState) -> float:
        """Root mean square of the particles' speeds [m/s]."""
        mass = gas.masses.sum()
        return math.sqrt(2.0 * gas.sums.flight_energy.sum() / mass) if mass > 0.0 else 0.0

    def _pending(self, gas: CorpuscularState, kinds: ParticleKinds, time: float) -> np.ndarray:
        """Delivered by inflators up to `time` [s], but no particle yet [kg], (species,)."""
        pending = np.zeros(len(kinds.mass))
        for source, delivery in zip(self.sources, gas.deliveries, strict=True):
            inflator = source.inflator
            pending += inflator.delivered(time) * inflator.mass_fractions - delivery.mass(kinds)
        return pending

    def _mass(self, gas: CorpuscularState, kinds: ParticleKinds) -> np.ndarray:
        """In particles, and what is not yet one or no longer [kg], (species,)."""
        return gas.masses.sum(axis=0) + self._pending(gas, kinds, gas.gas_time) + gas.remainder.mass(kinds)

    def _energy(self, gas: CorpuscularState) -> float:
        """Of particles, of what is not yet one or no longer, of the bank, and what is owed [J]."""
        pending = sum(delivery.pending_energy for delivery in gas.deliveries) + gas.remainder.energy
        return gas.particle_energy + pending + gas.in_bank + float(gas.pool.sum())

    def _close_books(self, gas: CorpuscularState, kinds: ParticleKinds) -> None:
        """Hold mass, energy and momentum of the state against the books; keep the largest relative errors."""
        injected = sum(i.delivered(gas.gas_time) * i.mass_fractions for i in self.inflators)
        came = gas.start_masses + injected + gas.drawn
        gap = self._mass(gas, kinds) + gas.left.sum(axis=0) - came
        gas.mass_error = max(gas.mass_error, float(np.abs(gap).max() / came.sum()))
        booked = gas.start_energy + gas.enthalpy_in - gas.enthalpy_out - gas.load.work
        scale = gas.start_energy + gas.enthalpy_in
        gas.energy_error = max(gas.energy_error, abs(self._energy(gas) - booked) / scale)
        momentum = gas.sums.momentum.sum(axis=0) + gas.remainder.momentum + gas.load.held.sum(axis=0) + gas.load.given
        gap = momentum - gas.start_momentum - gas.impulse
        scale = math.sqrt(2.0 * gas.sums.flight_energy.sum() * gas.masses.sum())
        gas.momentum_error = max(gas.momentum_error, float(np.abs(gap).max() / scale))

    def _sums(self, gas: CorpuscularState, kinds: ParticleKinds) -> ParticleSums:
        if gas.sums is None:  # a state just restored
            gas.sums = sum_particles(gas.particles, kinds.mass, self.chambers.count)
        return gas.sums

    def _gap(self, gas: CorpuscularState) -> float:
        """Mean distance of opposite walls [m]."""
        return 2.0 * float(gas.volume.sum() / self._flat_area.sum())

    def stable_dt(self, gas: CorpuscularState) -> float:
        """The gap over the speed of sound: between light walls gas is a stiff spring that answers half a step late."""
        density = gas.masses.sum() / gas.volume.sum()
        pressure = float(gas.pressure @ gas.volume / gas.volume.sum())
        return SOUND_CROSSES * self._gap(gas) / math.sqrt(float(gas.gamma.max()) * pressure / density)

    # --- handing over to another gas -------------------------------------------------------------------------------

    def arrive(self, gas: CorpuscularState, bag: Bag, time: float, dt: float) -> None:
        """The last step, from `time` to `time + dt` [s]: the particles come to its end, and of the step's work the half
        is booked that belongs to the force at its beginning. The force at its end is another gas'."""
        triangles = bag.surface.triangles
        gas.volume = self.chambers.volumes(triangles, bag.positions)
        self._gas_step(gas, bag, time + dt, dt)
        gas.load.force.fill(0.0)
        nothing = np.zeros(len(triangles))
        no_force = np.zeros((len(triangles), 3, 3))
        gas.load.push(self._solid, nothing, nothing, triangles, bag.positions, bag.velocities, dt, no_force)
        before = area_vectors(triangles, bag.positions - dt * bag.velocities)
        rate = np.sum(before * bag.velocities[triangles].mean(axis=1), axis=1)
        gas.load.ambient_work += 0.5 * dt * float(self._ambient_load @ rate)

    def content(self, gas: CorpuscularState) -> tuple[np.ndarray, np.ndarray]:
        """Mass [kg] (chambers, species) and energy [J] (chambers,) that the books find in each chamber.

        With the particles goes what is not yet one or no longer, what is owed, and what walls were given and did not
        pass on.
        """
        kinds = ParticleKinds(self.table, gas.molecules)
        sums = self._sums(gas, kinds)
        thermal = thermal_energy(sums, kinds.mass)
        energy = sums.flight_energy + sums.internal_energy + gas.pool
        energy += (gas.in_bank + gas.remainder.energy) * thermal / max(thermal.sum(), 1e-300)
        masses = gas.masses + gas.remainder.number * kinds.mass
        for source, delivery in zip(self.sources, gas.deliveries, strict=True):
            inflator = source.inflator
            delivered = inflator.delivered(gas.gas_time) * inflator.mass_fractions
            masses[inflator.chamber] += delivered - delivery.mass(kinds)
            energy[inflator.chamber] += delivery.pending_energy
        return masses, energy

    def dismiss(self, gas: CorpuscularState) -> None:
        """Let the particles go, and what they needed; the books stay."""
        gas.particles, gas.cells = Particles.room_for(0), Cells.of(self.chambers.count)
        gas.grid = gas.hits = gas.sums = gas.patches = None

    # --- what users see --------------------------------------------------------------------------------------------

    def totals(self, gas: CorpuscularState) -> GasTotals:
        kinds = ParticleKinds(self.table, gas.molecules)
        left = gas.left.sum(axis=1)
        vented_by, leaked_by, passed = {}, {}, {}
        for k, row in enumerate(self.passages.rows):
            if row.behind != OUTSIDE and row.ahead != OUTSIDE:
                passed[row.name] = float(gas.passed[k])
            elif row.kind == FABRIC:
                leaked_by[row.name] = float(left[k])
            else:
                vented_by[row.name] = float(left[k])
        single = self.chambers.count == 1
        volume = float(gas.volume.sum())
        mass = gas.masses.sum(axis=1)
        share = mass / max(mass.sum(), 1e-300)
        return GasTotals(
            pressure=float(gas.pressure @ gas.volume) / volume,
            temperature=float(gas.temperature @ share) if mass.any() else self.ambient.temperature,
            volume=volume,
            mass_by_species=self._mass(gas, kinds),
            energy=self._energy(gas),
            injected=float(sum(i.delivered(gas.gas_time) for i in self.inflators)),
            vented=sum(vented_by.values()),
            leaked=sum(leaked_by.values()),
            drawn_in=float(gas.drawn.sum()),
            enthalpy_in=gas.enthalpy_in,
            enthalpy_out=gas.enthalpy_out,
            work=gas.load.work,
            ambient_work=gas.load.ambient_work,
            jet_work=0.0,
            jet_impulse_in=0.0,
            jet_impulse_out=0.0,
            mass_error=gas.mass_error,
            energy_error=gas.energy_error,
            blocked_area=gas.blocked_area,
            vented_by=vented_by,
            leaked_by=leaked_by,
            passed=passed,
            chambers=() if single else self._each(gas, kinds),
            escaped=gas.escaped,
        )

    def _each(self, gas: CorpuscularState, kinds: ParticleKinds) -> tuple[ChamberTotals, ...]:
        sums = self._sums(gas, kinds)
        energy = sums.flight_energy + sums.internal_energy
        mass = gas.masses.sum(axis=1) + gas.remainder.number @ kinds.mass
        columns = (gas.pressure, gas.temperature, gas.volume, mass, energy)
        return tuple(map(ChamberTotals, self.chambers.names, *(column.tolist() for column in columns)))

    def fields(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        behind, ahead = self.chambers.behind, self.chambers.ahead
        inner = np.where(behind == OUTSIDE, self.ambient.pressure, gas.bank.pressure[:, 0])
        outer = np.where(ahead == OUTSIDE, self.ambient.pressure, gas.bank.pressure[:, 1])
        bag = self.inside(gas)
        boxes = read_boxes(gas.particles, ParticleKinds(self.table, gas.molecules), bag)
        return {"pressure": inner - outer} | on_faces(boxes, bag, gas.temperature)

    def cells(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        return read_boxes(gas.particles, ParticleKinds(self.table, gas.molecules), self.inside(gas)).arrays()

    def points(self, gas: CorpuscularState) -> dict[str, np.ndarray]:
        n, particles = gas.particles.count, gas.particles
        return {
            "position": particles.position[:n],
            "velocity": particles.velocity[:n],
            "internal_energy": particles.internal_energy[:n],
            "species": particles.species[:n],
            "chamber": particles.chamber[:n],
        }

    def at(self, gas: CorpuscularState, places: np.ndarray) -> dict[str, np.ndarray]:
        kinds = ParticleKinds(self.table, gas.molecules)
        return read_points(places, gas.particles, kinds, self.inside(gas), self.ambient)

    def inside(self, gas: CorpuscularState) -> Inside:
        """What is inside the bag and in which chamber, as the surface was at the last gas step."""
        return Inside(self.surface.triangles, gas.positions, self.chambers)


def _flock(particles: Particles) -> Flock:
    """The particles that exist, as flight takes them."""
    n = particles.count
    return Flock(
        particles.position[:n], particles.velocity[:n], particles.species[:n], particles.identity[:n],
        particles.chamber[:n], np.full(n, NO_PASSAGE, np.int32), particles.overlap[:n],
    )  # fmt: skip


@scalar
def _draw_uniform(identity, seed, drawn_out):
    for p in range(len(identity)):
        drawn_out[p] = uniform(stream(seed, 0, identity[p]), 0)
