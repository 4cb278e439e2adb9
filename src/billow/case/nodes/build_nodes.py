"""From the `[[nodes]]` tables to driven nodes and velocities at the start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.errors import InputError
from billow.case.nodes.schema_nodes import NodeGroup
from billow.case.obstacles.motion import unit_vector
from billow.geometry.bag_shapes import BagShape
from billow.geometry.mesh_bag import require_nodes
from billow.parts.bodies.drive import Prescribed
from billow.parts.driven_nodes import DrivenNodes

NO_NODES = InputError.declare(
    "E-CASE-213",
    "the group {name} has no nodes",
    where="nodes.{name}",
    cause="a misspelt part, parts that do not touch, or a box in another unit",
    remedy="correct parts, between, low or high; the parts of the bag are {known}",
)
TWO_SAY = InputError.declare(
    "E-CASE-214",
    "{one} and {other} both say how node {node} moves",
    where="nodes.{one}, nodes.{other}",
    cause="parts that share the nodes of their seam, or boxes that overlap",
    remedy="narrow one of them with low and high, or with other parts",
)

SLACK = 1e-9
"""Of a box, by which a node may lie outside [m]; and of a product of unit vectors that are at right angles."""

MOUTH_MOVES = InputError.declare(
    "E-CASE-215",
    "{name} moves nodes of the mouth",
    where="nodes.{name}, gas.model",
    why="jets, and a gas that differs from place to place, come from where the mouth is at the start, and would not go "
    "with it",
    cause="a group of all nodes, or of a part that borders on the mouth",
    remedy='use gas.model = "uniform-pressure" and inflator.jets.count = 0, or leave the mouth out of the group',
)
NOT_BETWEEN_LAYERS = InputError.declare(
    "E-CASE-216",
    "{name} gives nodes their places in some directions only, beside contact of layers",
    where="nodes.{name}, fabric.self_contact",
    why="impulses between layers know nodes that yield in all directions and nodes that yield in none",
    remedy='set fabric.self_contact to true or false, hold the nodes across their way (motion.across = "held"), or fix '
    "them in all directions",
)


@dataclass(frozen=True)
class Ways:
    """Places of driven nodes over time. start: [m], (n, 3). moves: what moves some of them, which by index."""

    start: np.ndarray
    moves: tuple[tuple[np.ndarray, Prescribed], ...]

    def __call__(self, time: float) -> np.ndarray:
        places = self.start.copy()
        for members, drive in self.moves:
            places[members] += drive.way(time) * drive.direction
        return places


def members_of(group: NodeGroup, shape: BagShape) -> np.ndarray:
    """The nodes of a group, sorted. Raises InputError E-CASE-213, or E-GEO-034 for a number that no node has."""
    surface, points = shape.surface, shape.positions
    low, high = np.array(group.low) - SLACK, np.array(group.high) + SLACK
    chosen = ((points >= low) & (points <= high)).all(axis=1)
    touched = {
        name: np.isin(np.arange(surface.node_count), surface.triangles[surface.triangles_of(name)])
        for name in (*group.parts, *group.between)
    }
    known = ", ".join(surface.part_names)
    for name in touched:
        if name not in surface.part_names:
            raise NO_NODES(name=group.name, known=known, why=f"the bag has no part {name!r}")
    if group.parts:
        chosen &= np.any([touched[name] for name in group.parts], axis=0)
    for name in group.between:
        chosen &= touched[name]
    if group.numbers:
        named = require_nodes(group.numbers, surface.node_count, f"nodes.{group.name}.numbers")
        chosen &= np.isin(np.arange(surface.node_count), named)
    found = np.flatnonzero(chosen)
    if not len(found):
        raise NO_NODES(name=group.name, known=known, why="no node of the bag meets all of its conditions")
    return found


def start_velocity(groups: tuple[NodeGroup, ...], shape: BagShape, start: np.ndarray) -> np.ndarray | None:
    """Velocities at the start [m/s], (nodes, 3), whether nodes are held or not; None if the bag rests. shape: in which
    groups are found; start: where the nodes begin [m], (nodes, 3). Raises InputError E-CASE-214 if two groups name one
    node."""
    found, owner = np.zeros_like(shape.positions), np.full(len(shape.positions), -1)
    for k, group in enumerate(groups):
        if not group.starts:
            continue
        nodes = members_of(group, shape)
        taken = nodes[owner[nodes] >= 0]
        if len(taken):
            other = groups[owner[taken[0]]].name
            raise TWO_SAY(one=other, other=group.name, node=taken[0], why="each gives it a velocity at the start")
        owner[nodes] = k
        arm = start[nodes] - np.array(group.about)
        found[nodes] = np.array(group.velocity) + np.cross(np.array(group.spin), arm)
    return found if (owner >= 0).any() else None


def driven_nodes(
    groups: tuple[NodeGroup, ...], shape: BagShape, start: np.ndarray, mass: np.ndarray
) -> DrivenNodes | None:
    """Nodes that groups hold or move; None if there are none. shape, start: as in `start_velocity`; mass: [kg],
    (nodes,). Raises InputError E-CASE-214 if two groups give a node a place along one direction."""
    holding = [(group, members_of(group, shape)) for group in groups if group.motion.kind != "none"]
    if not holding:
        return None
    nodes = np.unique(np.concatenate([members for _, members in holding]))
    held, owner = np.zeros((len(nodes), 3, 3)), np.full((len(nodes), len(holding)), -1)
    moves, named = [], {}
    for k, (group, members) in enumerate(holding):
        at = np.searchsorted(nodes, members)
        own = _projection(group)
        clash = np.abs(held[at] @ own).max(axis=(1, 2)) > SLACK
        if clash.any():
            row = at[int(np.argmax(clash))]
            other = next(
                holding[j][0] for j in range(k)
                if owner[row, j] >= 0 and np.abs(_projection(holding[j][0]) @ own).max() > SLACK
            )  # fmt: skip
            why = "each gives it a place along one direction"
            raise TWO_SAY(one=other.name, other=group.name, node=nodes[row], why=why)
        held[at] += own
        owner[at, k] = k
        named[group.name] = at
        if group.motion.kind != "fixed":
            moves.append((at, group.motion.build()))
    held[shape.fixed[nodes]] = np.eye(3)  # what the bag holds is moved, but does not yield
    return DrivenNodes(nodes, mass[nodes], Ways(start[nodes], tuple(moves)), held, named)


def launched(velocity: np.ndarray, free: np.ndarray, driven: DrivenNodes | None) -> np.ndarray:
    """Velocities [m/s] (nodes, 3) without what is held. free: which nodes nothing holds, (nodes,)."""
    found = velocity * free[:, None]
    if driven is not None:
        found[driven.nodes] = driven.yielded(velocity[driven.nodes])
    return found


def require_possible_groups(groups: tuple[NodeGroup, ...], shape: BagShape, has_jets: bool, has_layers: bool) -> None:
    """Raises InputError E-CASE-215 or E-CASE-216. has_jets: whether gas comes from places that stand still."""
    mouth = shape.surface.triangles[shape.surface.triangles_of_kind("mouth")]
    for group in groups:
        moves = group.motion.kind in ("travel", "speed")
        if moves and has_jets and np.isin(members_of(group, shape), mouth).any():
            raise MOUTH_MOVES(name=group.name)
        yields = group.motion.kind == "fixed" and len(group.motion.directions) < 3
        if has_layers and (yields or (moves and group.motion.across == "free")):
            raise NOT_BETWEEN_LAYERS(name=group.name)


def _projection(group: NodeGroup) -> np.ndarray:
    """Onto the directions in which a group gives places, (3, 3)."""
    motion = group.motion
    if motion.kind == "fixed":
        return np.diag([float(axis in motion.directions) for axis in "xyz"])
    if motion.across == "held":
        return np.eye(3)
    line = unit_vector(motion.direction)
    return np.outer(line, line)
