"""Straps of a case in a deck: seat belts, which only pull; those that pull at the start, springs."""

from __future__ import annotations

import numpy as np

from billow.case.bag.build_bag import build_straps
from billow.case.fabric.build_fabric import build_fabric
from billow.case.schema import Case
from billow.decks.deck_text import DeckText
from billow.geometry.bag_shapes import BagShape

SAME = 1e-9
"""Lengths [m] that differ by less are one."""
FAR = 1.0
"""Strain to which the force of a belt is drawn: a straight line, which goes on."""


def put_straps(deck: DeckText, case: Case, shape: BagShape, part: int, notes: list[str]) -> None:
    """A part for bars of like stiffness and mass of a strap. part: the last number of a part."""
    if not shape.straps:
        return
    straps = build_straps(shape, build_fabric(case.fabric))
    ends = shape.positions[straps.bars]
    apart = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    slack = np.where(np.abs(straps.length - apart) < SAME, 0.0, straps.length - apart)
    belts, springs = slack >= 0.0, np.flatnonzero(slack < 0.0)
    number = 0
    for strap in range(straps.strap_count):
        bars = np.flatnonzero((straps.strap == strap) & belts)
        if not len(bars):
            continue
        part += 1
        stiffness, mass = float(straps.stiffness[bars[0]]), float(straps.mass[bars[0]] / straps.length[bars[0]])
        curve = deck.curve([0.0, FAR], [0.0, FAR * stiffness], "-", "force", f"{straps.name(strap)} tension")
        _part(deck, part, straps.name(strap))
        deck.keyword("SECTION_SEATBELT")
        deck.card(part)
        deck.keyword("MAT_SEATBELT")
        deck.card(part, deck.of(mass, "mass per length"), curve, 0, 0.0)
        deck.keyword("ELEMENT_SEATBELT")
        for bar in bars.tolist():
            number += 1
            a, b = (int(node) + 1 for node in straps.bars[bar])
            deck.card(number, part, a, b, 0, deck.of(slack[bar], "length"))
    for number, bar in enumerate(springs.tolist(), 1):
        part += 1
        a, b = (int(node) + 1 for node in straps.bars[bar])
        _part(deck, part, f"{straps.name(int(straps.strap[bar]))} spring {number}")
        deck.keyword("SECTION_DISCRETE")
        deck.card(part, 0)
        deck.card(0.0, 0.0)
        deck.keyword("MAT_SPRING_ELASTIC")
        deck.card(part, deck.of(straps.stiffness[bar] / straps.length[bar], "stiffness"))
        deck.keyword("ELEMENT_DISCRETE")
        deck.card(number, part, a, b, 0, 1.0, 0, deck.of(-slack[bar], "length"))
    if len(springs):
        notes.append(f"bag.straps: {len(springs)} bars that pull at the start are springs, without mass; they push too")
    if np.isfinite(straps.failure).any():
        notes.append("bag.straps: the tension at which a strap tears is not written")


def _part(deck: DeckText, part: int, title: str) -> None:
    deck.keyword("PART")
    deck.text(title)
    deck.card(part, part, part, 0, 0, 0, 0, 0)
