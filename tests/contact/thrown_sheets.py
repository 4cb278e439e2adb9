"""Sheets of fabric that are thrown at each other, for tests of contact between layers."""

from __future__ import annotations

import dataclasses

import numpy as np

from billow.case.build import keep_apart
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import Surface, nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model

FABRIC = LinearFabric(800.0, 3e-4, 0.4e9, 0.35e9, 0.2, 1e7, False, 0.05)
CELLS, EDGE = 8, 0.02


def sheet(origin, along, across, cells=(CELLS, CELLS), edge=EDGE):
    """Positions, triangles and flat coordinates of a rectangle with alternating diagonals."""
    i, j = np.meshgrid(np.arange(cells[0] + 1), np.arange(cells[1] + 1), indexing="ij")
    flat = edge * np.stack([i.ravel(), j.ravel()], axis=1)
    positions = np.asarray(origin) + flat[:, :1] * np.asarray(along) + flat[:, 1:] * np.asarray(across)
    number, triangles = i * (cells[1] + 1) + j, []
    for a in range(cells[0]):
        for b in range(cells[1]):
            p, q, r, s = number[a, b], number[a + 1, b], number[a + 1, b + 1], number[a, b + 1]
            triangles += [(p, q, r), (p, r, s)] if (a + b) % 2 == 0 else [(p, q, s), (q, r, s)]
    return positions, np.array(triangles), flat


def model_of(sheets, fixed=(), bodies=None, gravity=(0.0, 0.0, 0.0)):
    """A model of loose sheets without gas; fixed: numbers of those that are held."""
    positions, triangles, reference, first = [], [], [], 0
    for points, cells, flat in sheets:
        positions.append(points)
        triangles.append(cells + first)
        reference.append(flat[cells])
        first += len(points)
    positions, triangles, reference = (np.vstack(part) for part in (positions, triangles, reference))
    of_sheet = np.repeat(np.arange(len(sheets)), [len(points) for points, *_ in sheets])
    part = np.repeat(np.arange(len(sheets)), [len(cells) for _, cells, _ in sheets])
    names = tuple(f"sheet_{k}" for k in range(len(sheets)))
    surface = Surface.build(triangles, part, names, len(positions), ("fabric",) * len(sheets))
    membrane = Membrane.build(FABRIC, np.arange(len(triangles)), reference)
    area = nodal_share(triangles, flat_area(reference), len(positions))
    gravity = np.array(gravity)
    model = Model(
        surface=surface, start=positions, mass=nodal_share(triangles, membrane.mass, len(positions)),
        fixed=np.isin(of_sheet, fixed), gravity=gravity, gas=GasPart(NoGas(), surface, positions),
        fabric=Fabric(surface, (membrane,)), straps=NO_STRAPS, bodies=Bodies(bodies or (), area, gravity),
    )  # fmt: skip
    return dataclasses.replace(model, layers=keep_apart(model)), of_sheet


def facing(kind):
    """Two sheets about to meet: "angle", 2 degrees apart; "edge", free edges that cross; "corner" on a free edge. The
    second moves towards -z."""
    x, y, z, side = np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], CELLS * EDGE
    if kind == "angle":
        tilt = np.radians(2.0)
        return [
            sheet((0.0, 0.0, 0.0), x, y),
            sheet((0.4 * EDGE, 0.3 * EDGE, 0.002), [np.cos(tilt), 0.0, np.sin(tilt)], y),
        ]
    lower = sheet((0.0, 0.5 * side, -side - 0.001), x, z)
    if kind == "edge":
        return [lower, sheet((0.45 * side, 0.03, 0.001), y, z)]
    q = np.sqrt(0.5)
    return [lower, sheet((0.48 * side, 0.5 * side + 1e-4, 0.001), [0.0, q, q], [0.0, -q, q])]
