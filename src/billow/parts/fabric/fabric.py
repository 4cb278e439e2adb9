"""The part of the fabric: all its membranes, the ramp from a stretched start shape, and what a run says of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.compiled import scalar
from billow.base.errors import Concern, NumericalStop
from billow.base.plausible import is_usual
from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.geometry.surface import Surface, area_vectors
from billow.geometry.triangle import double_area_vector
from billow.geometry.triangulation import sorted_edges
from billow.parts.fabric.birth import Birth
from billow.parts.fabric.block import VOLUMES
from billow.parts.fabric.frame_fields import fabric_fields
from billow.parts.fabric.membrane import ENERGY, HYSTERESIS, POWER, SQUARED_RATE, STRETCH, Membrane, odd_speed
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
    """history: what each membrane's fabric remembers, (elements, width). largest_stretch: bound of the stretch [-].
    squared_rate: 1/dt^2 of the fastest element as it is strained [1/s^2].
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
        """Triangle of the smallest stable step in its flat cut."""
        membrane = max(self.membranes, key=lambda m: m.squared_rate.max())
        return int(membrane.elements[membrane.squared_rate.argmax()])

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
        largest, rate, strain, heat = 0.0, 0.0, 0.0, 0.0
        triangles, on_triangles = self.surface.triangles, (loads.corner_force, loads.thirds)
        loads.volumes[:] = self._holes(positions, loads)
        for membrane, history in zip(membranes, state.history, strict=True):
            sums = membrane.sums(len(loads.volumes))
            membrane.fabric.add_forces(membrane, triangles, positions, velocities, history, on_triangles, sums)
            loads.volumes[:] += sums[:, VOLUMES + 1 :].sum(axis=0)
            columns = sums.T.tolist()
            strain += sum(columns[ENERGY])
            heat += sum(columns[HYSTERESIS])
            bookings.append(Booking(DAMPING, sum(columns[POWER]) * dt))
            largest = max([largest, *columns[STRETCH]])
            rate = max([rate, *columns[SQUARED_RATE]])
        state.largest_stretch, state.squared_rate = math.sqrt(largest), rate
        return [*bookings, Booking(STRAIN, strain), Booking(HEAT_OF_HYSTERESIS, heat)]

    @cached_property
    def _bare(self) -> np.ndarray:
        """Triangles that no membrane covers: vents, and the mouth."""
        covered = [np.empty(0, np.int64), *(membrane.elements for membrane in self.membranes)]
        return np.setdiff1d(np.arange(self.surface.triangle_count), np.concatenate(covered))

    def _holes(self, positions: np.ndarray, loads: Loads) -> np.ndarray:
        """Set the loads of triangles without fabric; returns their part in the volumes [m^3], (chambers,)."""
        chambers = self.surface.chambers
        volumes = np.zeros(chambers.count + 1)
        _measure_holes(
            self._bare, self.surface.triangles, positions, chambers.behind, chambers.ahead, loads.corner_force,
            loads.thirds, volumes,
        )  # fmt: skip
        return volumes[:-1]

    def _reference(
        self, state: FabricState, positions: np.ndarray, time: float, dt: float, bookings: list[Booking]
    ) -> tuple[Membrane, ...]:
        """The membranes with the reference of the step's end; books the work of the reference that moved."""
        before, now = self.birth.fraction(time), self.birth.fraction(time + dt)
        if before < 1.0:
            slope = self.birth.energy_slope(self.membranes, now, self.surface.triangles, positions, state.history)
            bookings.append(Booking(BIRTH_WORK, 0.5 * (state.birth_slope + slope) * (now - before)))
            state.birth_slope = slope
        return self.birth.membranes(self.membranes, now)

    def squared_rate(self, state: FabricState) -> float:
        """1 / dt^2 [1/s^2] of the largest stable step as the fabric is strained now; zero without fabric."""
        at_rest = max((float(m.squared_rate.max()) for m in self.membranes), default=0.0)
        return max(state.squared_rate, at_rest) / STEP_FACTOR**2

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
        speed = np.sqrt(np.max(np.sum(moment.velocities**2, axis=1)))
        if speed * moment.dt <= farthest:
            return 0
        return int(np.count_nonzero(np.linalg.norm(moment.velocities, axis=1) * moment.dt > farthest))

    def inverted_elements(self, positions: np.ndarray) -> int:
        """Number of fabric triangles that face against every one of their neighbours; positions: [m], (nodes, 3).

        Fabric without compression folds through zero area while it crumples, and unfolds again: that is no fault. A
        triangle that still lies the wrong way round in an inflated bag is.
        """
        normals = area_vectors(self.surface.triangles, positions)
        first, second = _neighbours(self.surface.triangles.astype(np.int64))
        agree = np.zeros(len(normals), dtype=bool)
        same = np.einsum("ij,ij->i", normals[first], normals[second]) > 0.0
        agree[first[same]] = agree[second[same]] = True
        elements = np.concatenate([membrane.elements for membrane in self.membranes])
        return int(np.count_nonzero(~agree[elements]))

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
            fabric = membrane.fabric
            areal = fabric.density * fabric.thickness
            yield from odd_speed("warp", fabric.warp_modulus, fabric.density)
            if not is_usual("weight of fabric", areal):
                yield ODD_WEIGHT(weight=1e3 * areal)
            yield from fabric.concerns(float(membrane.altitude.min()), setting)

    def seconds_per_step(self, state: FabricState, dt: float, end: float) -> float:
        return SECONDS_PER_TRIANGLE * self.element_count


@scalar
def _measure_holes(which, triangles, positions, behind, ahead, corner_force, thirds, volumes_out):
    x, y, z = positions[0, 0], positions[0, 1], positions[0, 2]
    for t in which:
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        nx, ny, nz = double_area_vector(positions, a, b, c)
        nx, ny, nz = nx / 6.0, ny / 6.0, nz / 6.0
        volume = (positions[a, 0] - x) * nx + (positions[a, 1] - y) * ny + (positions[a, 2] - z) * nz
        volumes_out[behind[t]] += volume  # OUTSIDE, -1, is the last
        volumes_out[ahead[t]] -= volume
        thirds[t, 0], thirds[t, 1], thirds[t, 2] = nx, ny, nz
        for k in range(3):
            corner_force[t, k, 0] = corner_force[t, k, 1] = corner_force[t, k, 2] = 0.0


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
