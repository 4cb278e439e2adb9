"""Chambers of *AIRBAG_PARTICLE: *DEFINE_CPM_CHAMBER lists the parts around each, and an inner vent is an opening."""

from __future__ import annotations

from collections import Counter

import numpy as np

from billow.decks.airbag_gas import Airbag
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import plain, said
from billow.decks.tables import NOT_THERE


def put_chambers(context: Context, airbag: Airbag, one: Field) -> None:
    """The chambers that CHM names, each by the parts around it, whichever way their normals point; parts by which they
    interact are openings. Raises InputError E-DCK-006."""
    report, model, holes = context.report, context.model, []
    for block in model.all("DEFINE_CPM_CHAMBER"):
        cards = context.cards(block)
        head = cards.card("head", "ID NCHM")
        if head["ID"].whole != one.whole:
            continue
        report.take(head.values())
        for k in range(1, head["NCHM"].whole + 1):
            f = context.card(cards, "chamber", f"[{k}]")
            sets = [f[name] for name in ("SID1", "SID2") if f[name].whole]
            parts = [model.set_of("PART", s.whole, s.shown, s.place) for s in sets]
            airbag.chambers[f["CHM_ID"].whole or k] = np.unique(np.concatenate([np.empty(0, np.int64), *parts]))
            for field in (*sets, f["CHM_ID"]):
                report.mapped(field, field.whole, "bag.parts")
            for n in range(f["NINTER"].whole):
                holes.append((list(airbag.chambers)[-1], context.card(cards, "interaction", f"[{k}.{n + 1}]")))
        report.mapped(one, one.whole, "bag.parts", f"{len(airbag.chambers)} chambers")
        if len(airbag.chambers) < 2:
            airbag.chambers.clear()
        for number, hole in holes:
            _interaction(context, airbag, number, hole)
        _require_all(context, airbag, one)
        return
    raise NOT_THERE(kind="chambers of *DEFINE_CPM_CHAMBER", number=one.whole, who=one.shown, place=one.place)


def _interaction(context: Context, airbag: Airbag, number: int, f: dict[str, Field]) -> None:
    """A part through which gas flows from a chamber to another."""
    one, report = f["SID3"], context.report
    named = context.model.set_of("PART", one.whole, one.shown, one.place) if f["ITYPE3"].whole else [one.whole]
    parts = {int(part) for part in named}
    ends = {number, f["TOCHM"].whole}
    if len(ends) == 2 and all(parts <= set(airbag.chambers.get(end, np.empty(0)).tolist()) for end in ends):
        airbag.openings |= parts
        for field in f.values():
            report.mapped(field, field.whole, "bag.parts")
    else:
        report.refused(one, "gas flows from chamber to chamber through a part that both of them have")


def _require_all(context: Context, airbag: Airbag, one: Field) -> None:
    """Say which parts of the bag no chamber has."""
    listed = np.concatenate([np.empty(0, np.int64), *airbag.chambers.values()])
    left = np.setdiff1d(airbag.parts, listed)
    if airbag.chambers and len(left):
        why = f"no chamber has part {', '.join(map(str, left))} of the bag, which is left out: add it to a set"
        context.report.refused(one, why)


def within(airbag: Airbag) -> set[int]:
    """Parts that two chambers have."""
    count = Counter(part for parts in airbag.chambers.values() for part in parts.tolist())
    return {part for part, times in count.items() if times > 1}


def walls(context: Context, airbag: Airbag, f: dict[str, Field]) -> None:
    """SID2: parts inside the bag, which chambers must name."""
    report, one, kind = context.report, f["SID2"], f["STYPE2"]
    if airbag.chambers and kind.whole < 2:
        named = context.model.set_of("PART", one.whole, one.shown, one.place) if kind.whole else [one.whole]
        missing = set(map(int, named)) - within(airbag)
        if not missing:
            report.mapped(one, one.whole, "bag.parts")
            report.mapped(kind, kind.whole)
            return
        why = f"part {', '.join(map(str, sorted(missing)))} is not between two chambers: left out"
    else:
        why = "walls inside a bag whose chambers are not listed: say them by CHM and *DEFINE_CPM_CHAMBER"
    report.refused(one, why)


def put_opening(context: Context, f: dict[str, Field], airbag: Airbag, parts: set[int]) -> None:
    """A vent inside the bag: its parts are openings of their present area."""
    report, share = context.report, f["C23"].number if not f["C23"].is_blank else 1.0
    airbag.openings |= parts
    report.mapped(f["SID3"], f["SID3"].whole, "bag.parts", "an opening of the present area of the part")
    for name in ("LCTC23", "LCPC23", "PPOP"):
        if f[name].number:
            report.refused(f[name], "an opening of a case is open from the start, and its coefficient a number")
    if f["ENH_V"].whole == 2:
        report.mapped(f["ENH_V"], 2, note="gas flows both ways")
    else:
        report.refused(f["ENH_V"], "gas flows both ways through an opening of a case: ENH_V 2")
    gas = context.tables.setdefault("gas", {})
    if plain(gas.setdefault("opening_discharge", said(share, f["C23"]))) != share:
        report.refused(f["C23"], "openings of a case share one coefficient: that of the first is used")
    else:
        report.mapped(f["C23"], share, "gas.opening_discharge")


def put_source(context: Context, airbag: Airbag, f: dict[str, Field], infos: list[int]) -> None:
    """The chamber that an orifice blows into, for the inflators it belongs to. Raises InputError E-DCK-004."""
    one = f["CHM_ID"]
    if one.whole not in airbag.chambers:
        raise one.bad(f"the chambers are {', '.join(map(str, airbag.chambers))}")
    chamber = f"chamber_{one.whole}"
    for inflator, info in zip(context.tables["inflator"], infos, strict=True):
        if info != (f["INFO"].whole or 1):
            continue
        if plain(inflator.setdefault("chamber", said(chamber, one))) != chamber:
            context.report.refused(one, "all orifices of an inflator blow into one chamber: that of the first")
            return
    context.report.mapped(one, chamber, "inflator.chamber")
