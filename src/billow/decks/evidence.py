"""Numbers of a deck that tell its units, read without their meaning."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.decks.airbag_particle import UNIT_SYSTEMS, head
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.fabric import fabric_cards
from billow.decks.fields import known
from billow.decks.report import Report
from billow.decks.tables import Model
from billow.decks.units import SYSTEMS, Evidence


def evidence_of(model: Model, block: Block | None, bag: list[int]) -> Iterator[Evidence]:
    """bag: parts that are said to be fabric, all if there are none."""
    deck = model.deck
    for one in model.all("MAT_FABRIC", "MAT_034", "MAT_34"):
        context = Context(model, SYSTEMS["kg-m-s"], Report())
        f = fabric_cards(context, one)
        for kind, name in (("density of fabric", "RO"), ("modulus of fabric", "EA")):
            if f[name].number > 0.0:
                yield Evidence(kind, f[name].number, f[name].place)
        fabric_id = f["MID"].whole
        for part in model.parts.values():
            section = model.thicknesses.get(part.section)
            if part.material == fabric_id and section and section[0]:
                yield Evidence("thickness of fabric", section[0], section[2].place)
    if block is not None:
        yield from _gas_evidence(model, block)
    for one in model.all("CONTROL_TERMINATION"):
        end = Cards(deck.parameters, one).optional("termination", "ENDTIM")["ENDTIM"]
        if end.number:
            yield Evidence("end of the run", end.number, end.place)
    shells = model.shells
    rows = np.isin(shells.part, bag) if bag else np.ones(len(shells.part), bool)
    ids = np.unique(shells.corners[rows][shells.corners[rows] >= 0])
    if len(ids) and len(model.nodes.number):
        at = np.minimum(np.searchsorted(model.nodes.number, ids), len(model.nodes.number) - 1)
        size = float(np.ptp(model.nodes.points[at], axis=0).max())
        yield Evidence("size of the bag", size, deck.path.name)


def told(model: Model, block: Block | None) -> tuple[str, str] | None:
    """The system that UNIT of *AIRBAG_PARTICLE names, and where; None if it names none."""
    if block is None or known(block.name) != "AIRBAG_PARTICLE":
        return None
    _, _, found = head(Context(model, SYSTEMS["kg-m-s"], Report()), block)
    unit = found["UNIT"]
    return (UNIT_SYSTEMS[unit.text], unit.place) if unit.text in UNIT_SYSTEMS else None


def _inflator_evidence(reader: Context) -> Iterator[Evidence]:
    for block in reader.model.all("DEFINE_ALEBAG_INFLATOR"):
        cards = reader.cards(block)
        for _ in range(reader.card(cards, "inflator")["NGAS"].whole):
            mass = reader.card(cards, "gas")["MWGAS"]
            if mass.number:
                yield Evidence("molar mass", mass.number, mass.place)


def _gas_evidence(model: Model, block: Block) -> Iterator[Evidence]:
    """Numbers of the airbag's cards that tell the units, read without meaning."""
    reader = Context(model, SYSTEMS["kg-m-s"], Report())
    cards = reader.cards(block)
    kind = known(block.name)
    names = {"AIRBAG_HYBRID": ("ambient",), "AIRBAG_WANG_NEFSKE": ("gas", "exits", "ambient"),
             "AIRBAG_SIMPLE_AIRBAG_MODEL": ("gas",), "AIRBAG_ALE": ("ambient",),
             "AIRBAG_ADIABATIC_GAS_MODEL": ("gas",)}.get(kind, ())  # fmt: skip
    found: dict[str, Field] = {}
    if kind == "AIRBAG_ADVANCED_ALE":
        yield from _inflator_evidence(reader)
        return
    if kind == "AIRBAG_PARTICLE":
        _, _, found = head(reader, block)
        if found["PATM"].number != 1.0 and found["PATM"].number:
            yield Evidence("ambient pressure", found["PATM"].number, found["PATM"].place)
        return
    reader.card(cards, "core")
    for card in names:
        found |= reader.card(cards, card)
    if kind in ("AIRBAG_HYBRID", "AIRBAG_ALE") and found["GC"].number:
        yield Evidence("gas constant", found["GC"].number, found["GC"].place)
    for name in ("ATMOSP", "PE"):
        if name in found and found[name].number:
            yield Evidence("ambient pressure", found[name].number, found[name].place)
