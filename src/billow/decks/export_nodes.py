"""`[[nodes]]` of a case in a deck: velocities at the start, constraints, and motions that are prescribed."""

from __future__ import annotations

import numpy as np

from billow.case.nodes.build_nodes import members_of
from billow.case.obstacles.motion import unit_vector
from billow.case.schema import Case
from billow.decks.deck_text import DeckText
from billow.geometry.bag_shapes import BagShape


def put_nodes(deck: DeckText, case: Case, shape: BagShape) -> None:
    """Nodes of the bag have their number in the mesh plus 1."""
    for number, group in enumerate(case.nodes, 1):
        _node_set(deck, number, members_of(group, shape) + 1)
        if group.starts:
            spin = np.array(group.spin)
            size = float(np.linalg.norm(spin))
            axis = spin / size if size else np.zeros(3)
            deck.keyword("INITIAL_VELOCITY_GENERATION")
            speeds = [deck.of(v, "velocity") for v in group.velocity]
            deck.card(number, 3, deck.of(size, "frequency"), *speeds, 0, 0)
            deck.card(*[deck.of(v, "length") for v in group.about], *axis.tolist(), 0, 0)
        motion = group.motion
        if motion.kind == "fixed":
            deck.keyword("BOUNDARY_SPC_SET")
            deck.card(number, 0, *(int(axis in motion.directions) for axis in "xyz"), 0, 0, 0)
        elif motion.kind != "none":
            curve = deck.course(motion, group.name)
            deck.keyword("DEFINE_VECTOR")
            deck.card(number, 0.0, 0.0, 0.0, *unit_vector(motion.direction).tolist(), 0)
            deck.keyword("BOUNDARY_PRESCRIBED_MOTION_SET")
            way = 4 if motion.across == "free" else -4
            deck.card(number, way, 2 if motion.kind == "travel" else 0, curve, 1.0, number)


def _node_set(deck: DeckText, number: int, ids: np.ndarray) -> None:
    deck.keyword("SET_NODE_LIST")
    deck.card(number, 0.0, 0.0, 0.0, 0.0)
    for k in range(0, len(ids), 8):
        deck.card(*ids[k : k + 8].tolist())
