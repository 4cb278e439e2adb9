"""Several chambers in an *AIRBAG_PARTICLE: its outer surface, what lies inside, and *DEFINE_CPM_CHAMBER."""

from __future__ import annotations

import numpy as np

from billow.decks.deck_text import DeckText
from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE, Chambers

OUTER, INNER, FIRST = 2, 3, 4
"""Numbers of part sets: SID1, SID2, and the first of two for each chamber."""


def part_sets(chambers: Chambers, part: np.ndarray) -> dict[int, np.ndarray]:
    """Numbers of parts by number of their set; part: that of each triangle. The two of a chamber are parts with normals
    into it, and out of it. Empty ones are left out."""
    outer = (chambers.behind == OUTSIDE) | (chambers.ahead == OUTSIDE)
    sets = {OUTER: part[outer], INNER: part[~outer]}
    for c in range(chambers.count):
        sets |= {FIRST + 2 * c: part[chambers.ahead == c], FIRST + 2 * c + 1: part[chambers.behind == c]}
    return {number: np.unique(parts) for number, parts in sets.items() if len(parts)}


def openings(shape: BagShape) -> dict[int, tuple[int, int]]:
    """Number of each part that is an opening, and of the chambers behind and ahead of it."""
    surface, chambers = shape.surface, shape.surface.chambers
    found = {}
    for number, (name, kind) in enumerate(zip(surface.part_names, surface.part_kinds, strict=True), 1):
        if kind == "opening":
            first = surface.triangles_of(name)[0]
            found[number] = int(chambers.behind[first]) + 1, int(chambers.ahead[first]) + 1
    return found


def put_chambers(deck: DeckText, shape: BagShape) -> int:
    """*DEFINE_CPM_CHAMBER of the bag; its number, 0 for a bag of one chamber."""
    chambers = shape.surface.chambers
    if chambers.count == 1:
        return 0
    written = part_sets(chambers, shape.surface.part)
    deck.keyword("DEFINE_CPM_CHAMBER")
    deck.card(1, chambers.count)
    for c in range(chambers.count):
        into, out_of = (number if number in written else 0 for number in (FIRST + 2 * c, FIRST + 2 * c + 1))
        holes = [(part, sum(ends) - c - 1) for part, ends in openings(shape).items() if c + 1 in ends]
        deck.card(into, out_of, len(holes), c + 1)
        for part, other in holes:
            deck.card(part, 0, other)
    return 1
