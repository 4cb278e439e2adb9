"""What of a deck nobody asked for: every field of its airbag, material and contact cards still gets a row, and other
keywords are listed."""

from __future__ import annotations

from collections import Counter

from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.fields import CARDS, known
from billow.decks.tables import has_title

BY_FIELD = ("AIRBAG", "MAT", "CONTACT")
"""Keywords of which every field is named."""
BY_REPORT = (*BY_FIELD, "RIGIDWALL", "INITIAL", "LOAD", "BOUNDARY", "CONTROL", "DATABASE", "CONSTRAINED")
"""Keywords that count as read if one of their fields is in the report; others, if their name was asked for."""
ALWAYS = {"KEYWORD", "END", "TITLE", "COMMENT"}
WHY = {
    "AIRBAG": "another airbag than the one that was chosen: --airbag takes it",
    "MAT": "the material of no part that is imported",
    "CONTACT": "a contact whose cards are not read: a case keeps all fabric apart from itself and from obstacles",
}


def name_the_rest(context: Context) -> dict[str, int]:
    """Rows for the fields that are left, and the keywords that were not read, with how often."""
    report, missed = context.report, []
    places = {field.place for field in report.fields}
    for block in context.model.deck.blocks:
        group = next((g for g in BY_REPORT if block.is_a(g)), None)
        if block.name in ALWAYS:
            continue
        if group is None or "REFERENCE" in block.name:
            if block.name not in context.model.used:
                missed.append(block.name)
            continue
        if any(f"{block.file}:{line}" in places for line, _ in block.lines()):
            continue
        if block.name == "AIRBAG_INTERACTION" or group not in BY_FIELD:
            missed.append(block.name)
        if group in BY_FIELD:
            for field in _fields(context, block):
                report.take([field])
                if block.name == "AIRBAG_INTERACTION" and not field.is_blank:
                    report.refused(field, "gas that flows from bag to bag: join them in one mesh, with bag.parts")
                elif not field.is_blank:
                    report.ignored(field, WHY[group])
    return dict(Counter(missed))


def _fields(context: Context, block: Block) -> list[Field]:
    """All fields of a block: by name where its cards are known and always there, else by card and column."""
    cards = Cards(context.model.deck.parameters, block)
    if (has_title(block) or "_ID" in block.name) and cards.left:
        cards.text()
    fixed = block.is_a("MAT_ADD_AIRBAG_POROSITY_LEAKAGE") or known(block.name) in ("MAT_RIGID", "MAT_NULL")
    names = list(CARDS[known(block.name)].values()) if fixed else []
    found, k = [], 0
    while cards.left:
        k += 1
        columns = names[k - 1] if k <= len(names) else " ".join(f"card_{k}_column_{c}" for c in range(1, 9))
        found += cards.card(str(k), columns).values()
    return found
