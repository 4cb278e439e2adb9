"""What users see of the gas: in boxes, on faces of the fabric, and at points.

The ten particles of a collision cell know their pressure to 32 %. Readings therefore gather about a hundred particles,
whose pressure is uncertain by 10 %, in boxes as long as the bag is thick where it is flat. Gathering in space says as
much as averaging over time does, follows a bag that moves, and leaves nothing behind that a checkpoint would have to
save. The volume that counts is the part of a box inside the bag.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from billow.geometry.chambers import OUTSIDE, Chambers
from billow.parts.gas.corpuscular.cell_fields import CellFields, cell_fields
from billow.parts.gas.corpuscular.cells import Cells
from billow.parts.gas.corpuscular.collisions import cell_content
from billow.parts.gas.corpuscular.depth import depths
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, cell_temperature
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.mixture import mixture_gas_constant

IN_A_BOX = 100
"""Particles in a box, about: 10 % of noise in pressure, 5 % in temperature."""

BOXES_PER_PARTICLE = 0.1
"""Most boxes of a chamber, in its particles: about a bag that is crumpled up, most of them are empty."""

BOXES_AT_ONCE = 2000
"""Whose lattices are looked at together, which takes 100 bytes a point."""

LATTICE = 4
"""Points along each edge of a box that fabric cuts; they find out how much of it is inside the bag."""

ON_A_FACE = 10
"""Fewest particles of a box that speaks for a face, if there is such a box."""

IN_A_SPHERE = 400
"""Particles that tell a sensor's reading, the nearest: 5 % of noise in pressure."""

POINTS_IN_A_SPHERE = 1000
"""Points that find out how much of that sphere is inside the bag: 3 % where fabric halves it."""


@dataclass(frozen=True)
class Boxes:
    """The gas in boxes along the axes, each chamber with its own; only boxes with gas.

    fields: cell_fields, with pressure and density of the part inside the bag. size: edge lengths [m], (n, 3).
    """

    fields: CellFields
    size: np.ndarray

    def arrays(self) -> dict[str, np.ndarray]:
        """What a picture needs: centre and size [m], (n, 3), and the fields by name."""
        f = self.fields
        return {
            "centre": f.centre,
            "size": self.size,
            "pressure": f.pressure,
            "temperature": f.temperature,
            "density": f.density,
            "velocity": f.velocity,
            "particles": f.count.astype(float),
        }


@dataclass(frozen=True)
class Inside:
    """The surface at the last gas step: triangles (n, 3), positions [m] (nodes, 3), and its chambers."""

    triangles: np.ndarray
    positions: np.ndarray
    chambers: Chambers

    def outside(self, points: np.ndarray, chamber: np.ndarray) -> np.ndarray:
        """Whether points [m] (n, 3) are not in the chambers (n,) they are said to be in, (n,) bool."""
        return depths(points, chamber, self.triangles, self.positions, self.chambers.behind, self.chambers.ahead) < 1


def read_boxes(particles: Particles, kinds: ParticleKinds, bag: Inside) -> Boxes:
    """The gas in boxes of about IN_A_BOX particles."""
    n, chambers = particles.count, bag.chambers
    position, chamber = particles.position[:n], particles.chamber[:n]
    volume = chambers.volumes(bag.triangles, bag.positions)
    count = chambers.count
    low, size = np.zeros((count, 3)), np.ones((count, 3))
    shape, first = np.zeros((count, 3), np.int64), np.zeros(count + 1, np.int64)
    for k in range(count):
        mine = position[chamber == k]
        if len(mine):
            low[k], extent = mine.min(axis=0), np.maximum(np.ptp(mine, axis=0), 1e-9)
            shape[k] = _divisions(extent, abs(volume[k]) / len(mine), len(mine))
            size[k] = extent / shape[k]
        first[k + 1] = first[k] + shape[k].prod()

    def index(points: np.ndarray, where: np.ndarray) -> np.ndarray:
        steps = np.clip(((points - low[where]) / size[where]).astype(np.int64), 0, shape[where] - 1)
        return first[where] + (steps[:, 0] * shape[where, 1] + steps[:, 1]) * shape[where, 2] + steps[:, 2]

    cell = index(position, chamber)
    start = np.zeros(first[-1] + 2, np.int32)
    start[1:-1] = np.cumsum(np.bincount(cell, minlength=first[-1]))
    cells = Cells(
        np.cbrt(size.prod(axis=1)), np.zeros(count), low, shape, first, start,
        np.argsort(cell, kind="stable").astype(np.int32), cell.astype(np.int32),
    )  # fmt: skip
    # cell_fields knows cubes; those of the same volume have the density of the boxes.
    fields = cell_fields(cells, particles, kinds)
    at, place = fields.chamber, fields.cell - first[fields.chamber]
    steps = _steps(place, shape[at])
    cut = np.zeros(first[-1], bool)
    for k in np.flatnonzero(shape.prod(axis=1)):
        _mark_cut(bag.positions[chambers.boundary(k, bag.triangles)], low[k], size[k], shape[k], cut[first[k] :])
    corner, filled = low[at] + steps * size[at], np.ones(len(at))
    some = np.flatnonzero(cut[fields.cell])
    for part in np.split(some, range(BOXES_AT_ONCE, len(some), BOXES_AT_ONCE)):
        points = corner[part, None] + _LATTICE * size[at[part], None]
        lost = bag.outside(points.reshape(-1, 3), np.repeat(at[part], len(_LATTICE))).reshape(len(part), len(_LATTICE))
        filled[part] = np.maximum(len(_LATTICE) - lost.sum(axis=1), 1) / len(_LATTICE)
    fields = replace(
        fields, centre=corner + 0.5 * size[at], density=fields.density / filled,
        pressure=fields.pressure / filled,
    )  # fmt: skip
    return Boxes(fields, size[at])


def _steps(place: np.ndarray, shape: np.ndarray) -> np.ndarray:
    return np.column_stack(
        [place // (shape[:, 1] * shape[:, 2]), place // shape[:, 2] % shape[:, 1], place % shape[:, 2]]
    )


def _mark_cut(corners: np.ndarray, low, size, shape, cut_out: np.ndarray) -> None:
    """Mark the boxes that triangles may reach into; corners [m] (n, 3, 3)."""
    begin = np.clip(np.floor((corners.min(axis=1) - low) / size), 0, shape - 1).astype(np.int64)
    end = np.clip(np.floor((corners.max(axis=1) - low) / size), 0, shape - 1).astype(np.int64)
    for step in np.ndindex(*(end - begin).max(axis=0, initial=0) + 1):
        box = np.minimum(begin + step, end)
        cut_out[(box[:, 0] * shape[1] + box[:, 1]) * shape[2] + box[:, 2]] = True


def _divisions(extent: np.ndarray, room: float, number: int) -> np.ndarray:
    """How often to divide a box of extent [m] (3,) whose particles, so many, have room [m^3] each; never an axis that
    is thin. A bag of hardly any volume would have boxes without end; they are as large as BOXES_PER_PARTICLE asks."""
    thin = np.zeros(3, bool)
    room = max(room, float(extent.prod()) / (IN_A_BOX * BOXES_PER_PARTICLE * number))
    while True:
        thick = 3 - thin.sum()
        edge = (IN_A_BOX * room / extent[thin].prod()) ** (1.0 / max(thick, 1))
        thinner = thin | (extent < edge)
        if (thinner == thin).all() or thinner.all():
            return np.where(thinner, 1, np.maximum(1, np.rint(extent / edge))).astype(np.int64)
        thin = thinner


def on_faces(boxes: Boxes, bag: Inside, temperature: np.ndarray) -> dict[str, np.ndarray]:
    """Temperature [K], density [kg/m^3] and velocity [m/s] of the gas in the nearest box at each triangle.

    Triangles between two chambers show the one behind them. temperature: of each chamber [K], (chambers,), for one that
    has no box with two particles.
    """
    f, chambers = boxes.fields, bag.chambers
    side = np.where(chambers.behind != OUTSIDE, chambers.behind, chambers.ahead)
    middle = bag.positions[bag.triangles].mean(axis=1)
    warmth, density, velocity = temperature[side], np.zeros(len(side)), np.zeros((len(side), 3))
    for k in range(chambers.count):
        here, known = np.flatnonzero(side == k), np.flatnonzero((f.chamber == k) & np.isfinite(f.temperature))
        known = known[f.count[known] >= min(ON_A_FACE, f.count[known].max(initial=0))]
        if len(here) and len(known):
            scale = boxes.size[known[0]]
            nearest = known[cKDTree(f.centre[known] / scale).query(middle[here] / scale)[1]]
            warmth[here], density[here], velocity[here] = (
                f.temperature[nearest],
                f.density[nearest],
                f.velocity[nearest],
            )
    return {"gas_temperature": warmth, "gas_density": density, "gas_velocity": velocity}


def read_points(
    places: np.ndarray, particles: Particles, kinds: ParticleKinds, bag: Inside, ambient: Ambient
) -> dict[str, np.ndarray]:
    """Pressure [Pa], temperature [K], density [kg/m^3] (m,) and velocity [m/s] (m, 3) at places [m] (m, 3).

    Each is that of the nearest IN_A_SPHERE particles of the chamber a place lies in; outside the bag, of still air.
    """
    air = ambient.pressure / (float(ambient.mass_fractions @ kinds.table[:, 0]) * ambient.temperature)
    rows = np.tile([ambient.pressure, ambient.temperature, air, 0.0, 0.0, 0.0], (len(places), 1))
    for row, place in zip(rows, places, strict=True):
        for chamber in range(bag.chambers.count):
            found = np.flatnonzero(particles.chamber[: particles.count] == chamber)
            if len(found) > 1 and not bag.outside(place[None], [chamber])[0]:
                row[:] = _sphere(place, chamber, found, particles, kinds, bag)
                break
    return {"pressure": rows[:, 0], "temperature": rows[:, 1], "density": rows[:, 2], "velocity": rows[:, 3:]}


def _sphere(place, chamber, found, particles, kinds, bag) -> np.ndarray:
    """Pressure, temperature, density and velocity of the nearest of the particles found."""
    square = np.sum((particles.position[found] - place) ** 2, axis=1)
    if len(found) > IN_A_SPHERE:
        nearest = np.argpartition(square, IN_A_SPHERE - 1)[:IN_A_SPHERE]
        found, square = np.sort(found[nearest]), square[nearest]
    radius = math.sqrt(square.max())
    lost = bag.outside(place + radius * _SPHERE, np.full(len(_SPHERE), chamber)).sum()
    volume = 4.0 / 3.0 * math.pi * radius**3 * max(1, len(_SPHERE) - lost) / len(_SPHERE)
    masses = np.zeros(len(kinds.mass))
    thermal = cell_content(
        found.astype(np.int32), 0, len(found), particles.velocity, particles.internal_energy, particles.species,
        kinds.mass, masses,
    )  # fmt: skip
    temperature = cell_temperature(kinds.table, masses, kinds.heat, thermal, 300.0)
    weight = kinds.mass[particles.species[found]]
    velocity = weight @ particles.velocity[found] / weight.sum()
    pressure = mixture_gas_constant(kinds.table, masses) * temperature / volume
    return np.array([pressure, temperature, masses.sum() / volume, *velocity])


def _even_sphere(number: int) -> np.ndarray:
    """Points spread evenly through the unit sphere, (number, 3): a golden spiral on shells of equal volume."""
    k = np.arange(number) + 0.5
    z, turn = 1.0 - 2.0 * k / number, np.pi * (1.0 + math.sqrt(5.0)) * k
    radius = np.cbrt((k * 0.6180339887498949) % 1.0)
    ring = np.sqrt(1.0 - z * z)
    return radius[:, None] * np.column_stack([ring * np.cos(turn), ring * np.sin(turn), z])


_SPHERE = _even_sphere(POINTS_IN_A_SPHERE)
_LATTICE = (np.array(list(np.ndindex(LATTICE, LATTICE, LATTICE))) + 0.5) / LATTICE
