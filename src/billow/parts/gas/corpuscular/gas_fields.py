"""Gas fields for the user: in boxes, on faces of the fabric, and at points (docs/theory.md, Fields and sensors)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import prange
from scipy.spatial import cKDTree

from billow.base.compiled import kernel
from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.corpuscular.collisions import cell_content
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds, cell_temperature
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.winding_number import winding_numbers
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.mixture import mixture_gas_constant

IN_A_BOX = 100
"""Mean number of particles in a box: 10 % of noise in pressure, 5 % in temperature."""

BOXES_PER_PARTICLE = 0.1
"""Largest number of boxes of a chamber per particle: around a crumpled bag most boxes are empty."""

BOXES_AT_ONCE = 2000
"""Boxes whose lattices are tested together, which takes 100 bytes a point."""

LATTICE = 4
"""Lattice points along each edge of a box that fabric cuts; they measure how much of the box is inside the bag."""

ON_A_FACE = 10
"""Fewest particles of a box that gives the fields on a face, if there is such a box."""

IN_A_SPHERE = 400
"""Nearest particles that give the reading of a sensor: 5 % of noise in pressure."""

POINTS_IN_A_SPHERE = 1000
"""Points that measure how much of that sphere is inside the bag: to 3 % where fabric halves it."""


@dataclass(frozen=True)
class Boxes:
    """The gas in boxes parallel to the axes, each chamber with its own grid; only boxes with gas.

    centre, size: [m] (n, 3); chamber (n,) int32; count of particles (n,) int64; velocity, mean over mass [m/s] (n, 3);
    temperature [K] (n,), nan for a single particle; density [kg/m^3] and pressure [Pa] (n,), of the part of the box
    inside the bag.
    """

    centre: np.ndarray
    size: np.ndarray
    chamber: np.ndarray
    count: np.ndarray
    velocity: np.ndarray
    temperature: np.ndarray
    density: np.ndarray
    pressure: np.ndarray

    def arrays(self) -> dict[str, np.ndarray]:
        """Centre and size [m], (n, 3), and the fields by name."""
        names = "centre", "size", "pressure", "temperature", "density", "velocity"
        return {name: getattr(self, name) for name in names} | {"particles": self.count.astype(float)}


def read_boxes(particles: Particles, kinds: ParticleKinds, bag: Enclosure) -> Boxes:
    """The gas in boxes of about IN_A_BOX particles."""
    n, chambers = particles.count, bag.chambers.count
    position, chamber = particles.position[:n], particles.chamber[:n]
    volume = bag.chambers.volumes(bag.triangles, bag.positions)
    low, size = np.zeros((chambers, 3)), np.ones((chambers, 3))
    shape, first = np.zeros((chambers, 3), np.int64), np.zeros(chambers + 1, np.int64)
    for k in range(chambers):
        mine = position[chamber == k]
        if len(mine):
            low[k], extent = mine.min(axis=0), np.maximum(np.ptp(mine, axis=0), 1e-9)
            shape[k] = _divisions(extent, abs(volume[k]) / len(mine), len(mine))
            size[k] = extent / shape[k]
        first[k + 1] = first[k] + shape[k].prod()
    steps = np.clip(((position - low[chamber]) / size[chamber]).astype(np.int64), 0, shape[chamber] - 1)
    cell = first[chamber] + (steps[:, 0] * shape[chamber, 1] + steps[:, 1]) * shape[chamber, 2] + steps[:, 2]
    start = np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=first[-1]))])
    order = np.argsort(cell, kind="stable").astype(np.int32)
    box = np.flatnonzero(np.diff(start))
    mass, momentum, temperature = np.zeros(len(box)), np.zeros((len(box), 3)), np.full(len(box), np.nan)
    _average(
        len(box), box, start, order, particles.arrays(), kinds.table, kinds.mass, kinds.heat, mass, momentum,
        temperature,
    )  # fmt: skip
    at = np.searchsorted(first, box, side="right").astype(np.int32) - np.int32(1)
    place, across, up = box - first[at], shape[at, 1], shape[at, 2]
    corner = low[at] + np.column_stack([place // (across * up), place // up % across, place % up]) * size[at]
    cut = np.zeros(first[-1], bool)
    for k in np.flatnonzero(shape.prod(axis=1)):
        walls = bag.chambers.boundary(k, bag.triangles)
        _mark_cut(bag.positions[walls], low[k], size[k], shape[k], cut[first[k] :])
    filled = np.ones(len(box))
    some = np.flatnonzero(cut[box])
    for part in np.split(some, range(BOXES_AT_ONCE, len(some), BOXES_AT_ONCE)):
        points = corner[part, None] + _LATTICE * size[at[part], None]
        deep = winding_numbers(points.reshape(-1, 3), np.repeat(at[part], len(_LATTICE)), bag)
        lost = (deep < 1).reshape(points.shape[:2])
        filled[part] = np.maximum(len(_LATTICE) - lost.sum(axis=1), 1) / len(_LATTICE)
    count, room = np.diff(start)[box], np.cbrt(size.prod(axis=1))[at] ** 3
    return Boxes(
        corner + 0.5 * size[at], size[at], at, count, momentum / mass[:, None], temperature, mass / room / filled,
        count * kinds.heat * temperature / room / filled,
    )  # fmt: skip


@kernel
def _average(n, cell, start, order, particles, table, mass, heat, mass_out, momentum_out, temperature_out):
    velocity, internal_energy, species = particles.velocity, particles.internal_energy, particles.species
    for at in prange(n):
        masses = np.empty(len(mass))
        begin, end = np.int64(start[cell[at]]), np.int64(start[cell[at] + 1])
        thermal = cell_content(order, begin, end, velocity, internal_energy, species, mass, masses)
        mass_out[at] = masses.sum()
        if end - begin > 1:
            temperature_out[at] = cell_temperature(table, masses, heat, thermal, 300.0)
        for j in range(begin, end):
            i = order[j]
            for axis in range(3):
                momentum_out[at, axis] += mass[species[i]] * velocity[i, axis]


def _mark_cut(corners: np.ndarray, low, size, shape, cut_out: np.ndarray) -> None:
    """Mark the boxes that triangles may reach into; corners [m] (n, 3, 3)."""
    begin = np.clip(np.floor((corners.min(axis=1) - low) / size), 0, shape - 1).astype(np.int64)
    end = np.clip(np.floor((corners.max(axis=1) - low) / size), 0, shape - 1).astype(np.int64)
    for step in np.ndindex(*(end - begin).max(axis=0, initial=0) + 1):
        box = np.minimum(begin + step, end)
        cut_out[(box[:, 0] * shape[1] + box[:, 1]) * shape[2] + box[:, 2]] = True


def _divisions(extent: np.ndarray, room: float, number: int) -> np.ndarray:
    """Divisions of each axis of a box of extent [m] (3,) with a number of particles that have room [m^3] each. A thin
    axis is not divided. BOXES_PER_PARTICLE limits the number of boxes, which a bag of hardly any volume would raise
    without bound."""
    thin = np.zeros(3, bool)
    room = max(room, float(extent.prod()) / (IN_A_BOX * BOXES_PER_PARTICLE * number))
    while True:
        thick = 3 - thin.sum()
        edge = (IN_A_BOX * room / extent[thin].prod()) ** (1.0 / max(thick, 1))
        thinner = thin | (extent < edge)
        if (thinner == thin).all() or thinner.all():
            return np.where(thinner, 1, np.maximum(1, np.rint(extent / edge))).astype(np.int64)
        thin = thinner


def on_faces(boxes: Boxes, bag: Enclosure, temperature: np.ndarray) -> dict[str, np.ndarray]:
    """Temperature [K], density [kg/m^3] and velocity [m/s] of the gas in the box nearest to each triangle.

    Triangles between two chambers show the one behind them. temperature: of each chamber [K], (chambers,), used if it
    has no box with two particles.
    """
    chambers = bag.chambers
    side = np.where(chambers.behind != OUTSIDE, chambers.behind, chambers.ahead)
    middle = bag.positions[bag.triangles].mean(axis=1)
    warmth, density, velocity = temperature[side], np.zeros(len(side)), np.zeros((len(side), 3))
    for k in range(chambers.count):
        here, known = np.flatnonzero(side == k), np.flatnonzero((boxes.chamber == k) & np.isfinite(boxes.temperature))
        known = known[boxes.count[known] >= min(ON_A_FACE, boxes.count[known].max(initial=0))]
        if len(here) and len(known):
            scale = boxes.size[known[0]]
            nearest = known[cKDTree(boxes.centre[known] / scale).query(middle[here] / scale)[1]]
            warmth[here], density[here] = boxes.temperature[nearest], boxes.density[nearest]
            velocity[here] = boxes.velocity[nearest]
    return {"gas_temperature": warmth, "gas_density": density, "gas_velocity": velocity}


def read_points(
    places: np.ndarray, particles: Particles, kinds: ParticleKinds, bag: Enclosure, ambient: Ambient
) -> dict[str, np.ndarray]:
    """Pressure [Pa], temperature [K], density [kg/m^3] (m,) and velocity [m/s] (m, 3) at places [m] (m, 3).

    They are those of the nearest IN_A_SPHERE particles of the chamber in which a place lies; outside the bag, those of
    still air.
    """
    air = ambient.pressure / (float(ambient.mass_fractions @ kinds.table[:, 0]) * ambient.temperature)
    rows = np.tile([ambient.pressure, ambient.temperature, air, 0.0, 0.0, 0.0], (len(places), 1))
    for row, place in zip(rows, places, strict=True):
        for chamber in range(bag.chambers.count):
            found = np.flatnonzero(particles.chamber[: particles.count] == chamber)
            if len(found) > 1 and winding_numbers(place[None], [chamber], bag)[0] >= 1:
                row[:] = _sphere(place, chamber, found, particles, kinds, bag)
                break
    return {"pressure": rows[:, 0], "temperature": rows[:, 1], "density": rows[:, 2], "velocity": rows[:, 3:]}


def _sphere(place, chamber, found, particles, kinds, bag) -> np.ndarray:
    """Pressure, temperature, density and velocity of the nearest of some particles, `found`."""
    square = np.sum((particles.position[found] - place) ** 2, axis=1)
    if len(found) > IN_A_SPHERE:
        nearest = np.argpartition(square, IN_A_SPHERE - 1)[:IN_A_SPHERE]
        found, square = np.sort(found[nearest]), square[nearest]
    radius = math.sqrt(square.max())
    lost = (winding_numbers(place + radius * _SPHERE, np.full(len(_SPHERE), chamber), bag) < 1).sum()
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
