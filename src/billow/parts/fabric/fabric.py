"""The part of the fabric: all its membranes, the ramp from a stretched start shape, and what a run says of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np

from billow.base.compiled import CHUNK, scalar
from billow.base.errors import Concern, NumericalStop
from billow.base.plausible import is_usual
from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.geometry.assembly import Assembly
from billow.geometry.surface import Surface, area_vectors
from billow.geometry.triangle import double_area_vector
from billow.geometry.triangulation import sorted_edges
from billow.parts.fabric.birth import Birth
from billow.parts.fabric.block import VOLUMES
from billow.parts.fabric.frame_fields import fabric_fields
from billow.parts.fabric.membrane import (
    ENERGY,
    HYSTERESIS,
    LATE,
    POWER,
    SQUARED_RATE,
    STRETCH,
    TURNED,
    Membrane,
    damping_heat,
    odd_speed,
)  # fmt: skip
from billow.parts.part import (
    DAMPING,
    RECEIVED,
    STORED,
    WHOLE_MODEL,
    Account,
    Booking,
    Frame,
    Loads,
    Moment,
    Owner,
    Part,
    Quantity,
    Setting,
)
from billow.parts.part import HYSTERESIS as HEAT_OF_HYSTERESIS

STRAIN = Account("strain", STORED, renewed=True)
"""Recoverable energy of the fabric."""
BIRTH_WORK = Account("birth_work", RECEIVED, renewed=False)
"""Work of a reference that moves from the start shape to the flat cut."""

STEP_FACTOR = 0.9
"""Of the exact stable step of the fastest element (docs/theory.md, Membrane step)."""

LARGEST_STRETCH = 3.0
"""Stretch at which a run is stopped; nylon tears at 1.3."""

SHOOTING = 0.5
"""Part of the smallest element altitude that a node may travel in one step."""

SECONDS_PER_TRIANGLE = 60e-9
"""Rough cost of a triangle in a step, with its share of the nodes' motion."""

TORN = NumericalStop.declare(
    "E-NUM-005",
    "fabric is stretched to {stretch:.3g} times its length",
    where="triangle {triangle} (nodes {nodes}), part {part}, {when}",
    why="real fabric tears at 1.3; the load is too high or the fabric too soft",
    remedy="check fabric.young_warp, fabric.young_weft, fabric.thickness and inflator.mass_flow",
)

ODD_WEIGHT = Concern.declare(
    "W-FAB-002",
    "the fabric weighs {weight:.3g} g/m^2",
    where="fabric.density, fabric.thickness",
    why="airbag fabric weighs 150 to 400 g/m^2",
    cause="density or thickness in another unit",
    remedy='write units, for example thickness = "0.3 mm"',
)


@dataclass
class FabricState:
    """history: what each membrane's fabric remembers, as `Membrane.fresh_history`. largest_stretch: bound of the
    stretch [-]. squared_rate: 1/dt^2 of the fastest element as it is strained [1/s^2].
    birth_slope: rate of the strain energy with the moving reference [J per whole way]."""

    history: tuple[np.ndarray, ...]
    largest_stretch: float = 1.0
    squared_rate: float = 0.0
    birth_slope: float = 0.0


@dataclass(frozen=True)
class Fabric(Part):
    """membranes: of one fabric each. birth: for a start shape that is stretched against the flat cut."""

    surface: Surface
    membranes: tuple[Membrane, ...]
    birth: Birth | None = None

    @property
    def accounts(self) -> tuple[Account, ...]:
        return (STRAIN, DAMPING, HEAT_OF_HYSTERESIS, *([BIRTH_WORK] if self.birth else []))

    @property
    def area(self) -> float:
        """As cut [m^2]."""
        d = [m.reference_inverse for m in self.membranes]
        return float(sum(np.sum(0.5 / np.abs(d11 * d22 - d12 * d21)) for d11, d12, d21, d22 in d))

    @property
    def element_count(self) -> int:
        return sum(len(m.elements) for m in self.membranes)

    @property
    def smallest_element(self) -> int:
        """Triangle that a wave crosses first in its flat cut."""
        membrane = min(self.membranes, key=lambda m: m.crossing_time)
        return int(membrane.elements[membrane.altitude.argmin()])

    def start(self, bag) -> FabricState:
        """Fabric that has never been strained."""
        return FabricState(tuple(m.fresh_history() for m in self.membranes))

    # --- in a step -------------------------------------------------------------------------------------------------

    def add_forces(
        self, state: FabricState, positions: np.ndarray, velocities: np.ndarray, time: float, dt: float,
        loads: Loads,
    ) -> list[Booking]:  # fmt: skip
        """Set the loads of all triangles at the end of a step from `time` to `time + dt` [s]: membrane forces, area
        vectors, volumes. positions [m] then, velocities [m/s] in its middle: (nodes, 3)."""
        bookings: list[Booking] = []
        membranes: Sequence[Membrane] = self.membranes
        if self.birth is not None:
            membranes = self._reference(state, positions, time, dt, bookings)
        chambers = self.surface.chambers
        *of_membranes, of_holes = self.assembly.corners
        sums = np.zeros((self._chunks[-1], VOLUMES + 1 + len(loads.volumes)))
        for k, membrane in enumerate(membranes):
            own = sums[self._chunks[k] : self._chunks[k + 1]]
            membrane.fabric.add_forces(
                membrane, of_membranes[k], positions, velocities, state.history[k], loads.entries, own
            )  # fmt: skip
        strain, power, largest, heat, state.squared_rate, late, turned = _sum_up(
            sums, self._bare, positions, chambers.behind, chambers.ahead, *of_holes, loads.entries, loads.volumes
        )  # fmt: skip
        state.largest_stretch = math.sqrt(largest)
        damping = DAMPING, damping_heat(power, late, turned, dt)
        return [*bookings, damping, (STRAIN, strain), (HEAT_OF_HYSTERESIS, heat)]

    @cached_property
    def _chunks(self) -> list[int]:
        """Of each membrane, and after the last one: where its chunks begin in the sums of all."""
        return [0, *accumulate(-(-len(membrane.elements) // CHUNK) for membrane in self.membranes)]

    @cached_property
    def assembly(self) -> Assembly:
        """Of the membranes, and last of the triangles that none covers."""
        lists = [*(membrane.elements for membrane in self.membranes), self._bare]
        return Assembly.build(lists, self.surface.triangles, self.surface.chambers, self.surface.node_count)

    @cached_property
    def _bare(self) -> np.ndarray:
        """Triangles that no membrane covers: vents, and the mouth."""
        covered = [np.empty(0, np.int64), *(membrane.elements for membrane in self.membranes)]
        return np.setdiff1d(np.arange(self.surface.triangle_count), np.concatenate(covered))

    def corner_forces(self, state: FabricState, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Forces of the fabric on the corners of each triangle by itself [N], (triangles, 3, 3), after the ramp from a
        stretched start shape; positions [m] and velocities [m/s]: (nodes, 3). Its history stays as it is."""
        forces = np.zeros((self.surface.triangle_count, 3, 3))
        for membrane, history in zip(self.membranes, state.history, strict=True):
            forces[membrane.elements], _ = membrane.by_itself(self.surface.triangles, positions, velocities, history)
        return forces

    def _reference(
        self, state: FabricState, positions: np.ndarray, time: float, dt: float, bookings: list[Booking]
    ) -> tuple[Membrane, ...]:
        """The membranes with the reference of the step's end; books the work of the reference that moved."""
        before, now = self.birth.fraction(time), self.birth.fraction(time + dt)
        membranes = self.birth.membranes(self.membranes, now)
        if before < 1.0:
            slope = self.birth.energy_slope(membranes, now, self.surface.triangles, positions, state.history)
            bookings.append(Booking(BIRTH_WORK, 0.5 * (state.birth_slope + slope) * (now - before)))
            state.birth_slope = slope
        return membranes

    def squared_rate(self, state: FabricState) -> float:
        """1 / dt^2 [1/s^2] of the largest stable step as the fabric is strained now; zero without fabric."""
        return max(state.squared_rate, self._rate_at_rest) / STEP_FACTOR**2

    @cached_property
    def _rate_at_rest(self) -> float:
        return max((float(m.squared_rate.max()) for m in self.membranes), default=0.0)

    # --- what a run says of it -------------------------------------------------------------------------------------

    def owners(self) -> Iterator[Owner]:
        yield Owner(WHOLE_MODEL, "", ("largest_stretch", "shooting_nodes"))

    def quantities(self, state: FabricState, moment: Moment) -> Iterator[Quantity]:
        yield Quantity("", "largest_stretch", "-", state.largest_stretch)
        yield Quantity("", "shooting_nodes", "-", float(self.shooting_nodes(moment)))

    def frame(self, state: FabricState, moment: Moment) -> Frame:
        """Stretch, strain along the yarns and stress, as `fabric_fields`."""
        membranes = self.membranes
        if self.birth is not None:
            membranes = self.birth.membranes(membranes, self.birth.fraction(moment.time))
        places = self.surface.triangles, moment.positions, moment.velocities
        return Frame(cell=fabric_fields(membranes, state.history, *places))

    def shooting_nodes(self, moment: Moment) -> int:
        """Number of nodes that travel more than half the smallest altitude in one step."""
        farthest = SHOOTING * min(membrane.altitude.min() for membrane in self.membranes)
        travel = moment.dt * np.sqrt(np.einsum("ij,ij->i", moment.velocities, moment.velocities))
        return int(np.count_nonzero(travel > farthest))

    def inverted_elements(self, positions: np.ndarray) -> int:
        """Number of taut fabric triangles that face against every one of their neighbours; positions: [m], (nodes, 3).

        A membrane in space has no side that a triangle could be turned to, only neighbours. Where fabric is wrinkled or
        slack, its smaller principal stretch below one, it lies in folds finer than elements, and a triangle that faces
        against its neighbours is one of them, which unfolds as it is pulled. One that is pulled both ways does not.
        """
        normals = area_vectors(self.surface.triangles, positions)
        first, second = _neighbours(self.surface.triangles.astype(np.int64))
        agree = np.zeros(len(normals), dtype=bool)
        same = np.einsum("ij,ij->i", normals[first], normals[second]) > 0.0
        agree[first[same]] = agree[second[same]] = True
        triangles, count = self.surface.triangles, 0
        for membrane in self.membranes:
            odd = ~agree[membrane.elements]
            if odd.any():
                count += np.count_nonzero(odd & (membrane.least_stretch(triangles, positions) > 1.0))
        return int(count)

    def guard(self, state: FabricState, moment: Moment) -> None:
        """Raises NumericalStop E-NUM-005 if fabric is stretched beyond tearing."""
        if not state.largest_stretch > LARGEST_STRETCH:
            return
        found = ((m, *worst_stretch(m, self.surface.triangles, moment.positions)) for m in self.membranes)
        membrane, element, stretch = max(found, key=lambda found: found[2])
        triangle = int(membrane.elements[element])
        nodes = tuple(int(n) for n in self.surface.triangles[triangle])
        part = self.surface.parts_at(nodes[0])
        stop = TORN(stretch=stretch, triangle=triangle, nodes=nodes, part=part, when=moment.when)
        stop.nodes = nodes
        raise stop

    def books(self, state: FabricState, moment: Moment, history) -> dict[str, float]:
        return {
            "shooting_nodes": float(history.of("").shooting_nodes.max()),
            "inverted_elements": float(self.inverted_elements(moment.positions)),
        }

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        yield criterion("shooting nodes", books["shooting_nodes"], 0, 1, "-", SMALLER_STEPS)
        flat = "a smaller bag.element_size or run.dt_scale, or fabric.self_contact = true"
        yield criterion("inverted elements at the end", books["inverted_elements"], 0, 1, "-", flat)

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        for membrane in self.membranes:
            for concern in _concerns_of(membrane, setting):
                if len(self.membranes) > 1:
                    part = self.surface.part_names[self.surface.part[membrane.elements[0]]]
                    concern = replace(concern, where=f"{concern.where}, part {part}")
                yield concern

    def seconds_per_step(self, state: FabricState, dt: float, end: float) -> float:
        return SECONDS_PER_TRIANGLE * self.element_count


def _concerns_of(membrane: Membrane, setting: Setting) -> Iterator[Concern]:
    fabric = membrane.fabric
    areal = fabric.density * fabric.thickness
    yield from odd_speed("warp", fabric.warp_modulus, fabric.density)
    if not is_usual("weight of fabric", areal):
        yield ODD_WEIGHT(weight=1e3 * areal)
    yield from fabric.concerns(float(membrane.altitude.min()), setting)


@scalar
def _sum_up(partial, which, positions, behind, ahead, node, corner, first, loads_out, volumes_out):
    """Sums of what laws summed up per chunk, and of the triangles without fabric: the columns of `partial` but for the
    volumes, which are set. What is not finite shows in the energy."""
    totals = np.zeros(partial.shape[1])
    for chunk in range(len(partial)):
        for k in range(len(totals)):
            if k in (STRETCH, SQUARED_RATE):
                totals[k] = max(totals[k], partial[chunk, k])
            else:
                totals[k] += partial[chunk, k]
    loads_out[first[0] : first[-1]] = 0.0
    x, y, z = positions[0, 0], positions[0, 1], positions[0, 2]
    for i in range(len(which)):
        t = which[i]
        a, b, c = node[i, 0], node[i, 1], node[i, 2]
        nx, ny, nz = double_area_vector(positions, a, b, c)
        nx, ny, nz = nx / 6.0, ny / 6.0, nz / 6.0
        volume = (positions[a, 0] - x) * nx + (positions[a, 1] - y) * ny + (positions[a, 2] - z) * nz
        totals[VOLUMES + 1 + behind[t]] += volume  # OUTSIDE, -1, is the first
        totals[VOLUMES + 1 + ahead[t]] -= volume
        for k in range(3):
            entry = corner[i, k]
            loads_out[entry, 3] += nx
            loads_out[entry, 4] += ny
            loads_out[entry, 5] += nz
    for c in range(len(volumes_out)):  # an assigned slice would bring the text of an error: seconds of compiling
        volumes_out[c] = totals[VOLUMES + 1 + c]
    strain, largest, fastest = totals[ENERGY], totals[STRETCH], totals[SQUARED_RATE]
    return strain, totals[POWER], largest, totals[HYSTERESIS], fastest, totals[LATE], totals[TURNED]


def worst_stretch(membrane: Membrane, triangles: np.ndarray, positions: np.ndarray) -> tuple[int, float]:
    """The element of a membrane, counted from 0, that is stretched most, and its principal stretch [-]; positions: [m],
    (nodes, 3)."""
    stretch = membrane.stretch(triangles, positions)
    return int(stretch.argmax()), float(stretch.max())


def _neighbours(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of triangles that share an edge."""
    edges = sorted_edges(triangles)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    shared = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    return owner[shared], owner[shared + 1]
