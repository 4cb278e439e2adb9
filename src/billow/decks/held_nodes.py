"""Nodes of the bag that a deck holds or moves, as `bag.fixed_nodes` and `[[nodes]]` of a case."""

from __future__ import annotations

from typing import Any

import numpy as np

from billow.decks.bag_mesh import BagMesh, plain_name
from billow.decks.context import Context
from billow.decks.draft import said


def put_held(context: Context, held: np.ndarray, sources: list[str]) -> None:
    """What stands still. held: directions of each mesh node, (nodes, 3) bool; sources: of the deck."""
    source = ", ".join(dict.fromkeys(sources))
    still = held.all(axis=1)
    if still.any():
        context.set("bag.fixed_nodes", np.flatnonzero(still).tolist(), source)
    some = held[held.any(axis=1) & ~still]
    for ways in np.unique(some, axis=0).tolist():
        members = np.flatnonzero((held == ways).all(axis=1))
        directions = [axis for axis, is_held in zip("xyz", ways, strict=True) if is_held]
        motion = {"kind": "fixed", "directions": directions}
        put_group(context, f"held_{''.join(directions)}", members, {"motion": motion}, source)


def put_group(context: Context, name: str, members: np.ndarray, what: dict[str, Any], source: str) -> None:
    """A group of mesh nodes; of those of one name, the second gets _2, and so on."""
    groups = context.tables.setdefault("nodes", [])
    name = plain_name(name) or "group"
    taken, k = {one["name"] for one in groups}, 2
    unique = name
    while unique in taken:
        unique, k = f"{name}_{k}", k + 1
    groups.append({"name": unique, "numbers": said(members.tolist(), source), **what})


def put_moved(
    context: Context, bag: BagMesh, members: np.ndarray, held: np.ndarray, motion: dict[str, Any], name: str,
    source: str,
) -> str:  # fmt: skip
    """A group that is moved, if a case can say it; else why not. held: as in `put_held`; motion: a table of
    `[nodes.motion]`."""
    if len(np.intersect1d(members, bag.mouth)):
        return "they belong to the mouth, where jets come from: a case keeps it where it is"
    line = np.abs(np.array(motion["direction"].value)) > 1e-9
    if (held[members][:, line]).any():
        return "some of them are held along it by another card"
    put_group(context, name, members, {"motion": motion}, source)
    return ""
