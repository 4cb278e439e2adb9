"""Fabric nodes against the shapes of rigid bodies, over a step (docs/theory.md, Contact over a step): one pass over the
nodes gives half a kick, half of each contact impulse, and the drift. So the drift has the mean of both velocities; the
other half of kick and impulses comes after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.geometry.shapes import super_ellipsoid_block
from billow.geometry.shapes.kinds import number_of
from billow.geometry.shapes.shape import NUMBERS, Shape
from billow.parts.bodies.contact_block import (
    BLOCK,
    CLOSE,
    PAIR_ROWS,
    ROWS,
    SUMS,
    add_up,
    ask_block,
    drift_block,
    fetch,
    find_touching,
    finish,
    kick_block,
    solve,
    sort_by_shape,
)
from billow.parts.bodies.penalty import A_REFERENCE


@dataclass(frozen=True)
class SurfaceLaw:
    """slope: force per penetration of a node with 1e-4 m^2 of fabric [N/m]; friction [-]; damping: of critical [-]."""

    slope: float
    friction: float
    damping: float


@dataclass
class ContactState:
    """Of all shapes. force: average over the last step on each fabric node, [N], (shapes, nodes, 3). offset: from the
    sticking point, [m], (shapes, nodes, 3), in each shape's axes. touching: (shapes, nodes) bool. stored: energy in the
    contact springs [J]; dissipated: in the last step [J]; deepest: penetration [m]; all three (shapes,)."""

    force: np.ndarray
    offset: np.ndarray
    touching: np.ndarray
    stored: np.ndarray
    dissipated: np.ndarray
    deepest: np.ndarray

    @classmethod
    def none(cls, shapes: int, nodes: int) -> ContactState:
        """Nothing touches."""
        field, sums = np.zeros((shapes, nodes, 3)), np.zeros(shapes)
        return cls(field, field.copy(), np.zeros((shapes, nodes), np.bool_), sums, sums.copy(), sums.copy())


class ShapeTable(NamedTuple):
    """What kernels need of all shapes and never changes; a row a shape.

    kind: of `near_shape`, (shapes,) int64. numbers: (shapes, NUMBERS). bound: radius of a sphere around it [m],
    (shapes,). law: slope per fabric area [N/m^3], friction [-], damping [-], (shapes, 3).
    """

    kind: np.ndarray
    numbers: np.ndarray
    bound: np.ndarray
    law: np.ndarray

    @classmethod
    def build(cls, shapes: Sequence[Shape], laws: Sequence[SurfaceLaw]) -> ShapeTable:
        return cls(
            np.array([number_of(shape) for shape in shapes], dtype=np.int64),
            np.array([shape.numbers for shape in shapes], dtype=float).reshape(-1, NUMBERS),
            np.array([shape.bound for shape in shapes], dtype=float),
            np.array([(law.slope / A_REFERENCE, law.friction, law.damping) for law in laws]).reshape(-1, 3),
        )


class Nodes(NamedTuple):
    """inverse_mass [1/kg], (nodes,); force [N] at the start of a step, positions [m], velocities [m/s], and room for
    the positions before the drift: (nodes, 3). No room, (0, 3), where nobody asks for them."""

    inverse_mass: np.ndarray
    force: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    before: np.ndarray


class ShapeMotion(NamedTuple):
    """Where shapes are and how they move, a row a shape.

    body: centre [m], velocity [m/s] and spin [rad/s] of the body that carries it, (shapes, 9). centre: of the shape
    from that of the body [m], in space, (shapes, 3). pose: rotation of the shape's axes to space, row by row, (shapes,
    9). met: depth of each node in each mesh [m] and normal, (shapes, nodes, 4), as `Mesh.look` finds it; without rows
    if no shape is a mesh.
    """

    body: np.ndarray
    centre: np.ndarray
    pose: np.ndarray
    met: np.ndarray

    @classmethod
    def room(cls, shapes: int, nodes: int = 0) -> ShapeMotion:
        """Rows to be filled; shapes lie in their bodies' centres. nodes: if one of them is a mesh."""
        met = np.full((shapes if nodes else 0, nodes, 4), -np.inf)
        return cls(np.zeros((shapes, 9)), np.zeros((shapes, 3)), np.zeros((shapes, 9)), met)


def kick_touch_drift(
    table: ShapeTable, motion: ShapeMotion, area: np.ndarray, nodes: Nodes, dt: float, contact: ContactState
) -> np.ndarray:
    """Half a kick of all fabric nodes, their contact with all shapes over a step of dt [s], and their drift; fills
    `contact`. area: [m^2], (nodes,). Returns (shapes, 6): force [N] and torque about the centre of the body [N m] that
    each shape receives.
    """
    reaction = np.empty((len(table.kind), 6))
    _kick_touch_drift(
        len(nodes.positions), tuple(table), tuple(motion), area, tuple(nodes), dt, contact.force, contact.offset,
        contact.touching, contact.stored, contact.dissipated, contact.deepest, reaction,
    )  # fmt: skip
    return reaction


@kernel
def _kick_touch_drift(
    n, table, motion, area, nodes, dt, force, offset, touching, stored_out, dissipated_out, deepest_out, reaction_out
):
    bound = table[2]
    chunks, shapes = (n + CHUNK - 1) // CHUNK, len(bound)
    partial = np.empty((chunks, shapes, SUMS))
    for chunk in prange(chunks):
        partial[chunk] = 0.0
        block = np.zeros(ROWS * BLOCK)
        found, shape = np.empty(CHUNK, dtype=np.int64), np.empty(CHUNK, dtype=np.int64)
        many, end = 0, min(n, (chunk + 1) * CHUNK)
        for first in range(chunk * CHUNK, end, BLOCK):
            count = min(BLOCK, end - first)
            kick_block(block, first, count, dt, nodes)
            any_close = ask_block(block, first, count, dt, bound, motion, touching)
            drift_block(block, first, count, dt, nodes)
            if any_close:
                for j in range(count):
                    if block[CLOSE + j] > 0.0:
                        found[many], shape[many] = first + j, int(block[CLOSE + j]) - 1
                        many += 1
        if many == 0:
            continue
        pairs, work = np.zeros((shapes, PAIR_ROWS * BLOCK)), np.zeros(super_ellipsoid_block.ROWS * BLOCK)
        close, starts = np.empty(CHUNK, dtype=np.int64), np.empty(shapes + 1, dtype=np.int64)
        sort_by_shape(found, shape, many, starts, close)
        for first in range(0, many, BLOCK):  # nodes that come close to a shape, wherever in the chunk they are
            count = min(BLOCK, many - first)
            fetch(block, close, first, count, dt, area, nodes)
            find_touching(block, pairs, work, close, first, count, dt, table, motion, touching, offset, force)
            solve(block, pairs, dt, table, motion)
            finish(block, pairs, close, first, count, dt, motion, nodes, offset, force)
        add_up(pairs, chunk, partial)
    stored_out[:], dissipated_out[:], deepest_out[:], reaction_out[:] = 0.0, 0.0, 0.0, 0.0
    for chunk in range(chunks):
        for o in range(shapes):
            for k in range(6):
                reaction_out[o, k] += partial[chunk, o, k]
            stored_out[o] += partial[chunk, o, 6]
            dissipated_out[o] += partial[chunk, o, 7]
            deepest_out[o] = max(deepest_out[o], partial[chunk, o, 8])
