"""A starter deck of Radioss as the draft of a case and its meshes; the report has a row for each of its fields."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from billow.base.toml_file import read_toml
from billow.decks.airbag import NO_CHOICE
from billow.decks.airbag_gas import put_silence
from billow.decks.bag_mesh import BagMesh, Choices, bag_mesh
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import said
from billow.decks.fixed import settle
from billow.decks.obstacles import put_by_name
from billow.decks.radioss.bodies import bodies_of, constraint_of, meshes
from billow.decks.radioss.cloth import put_cloth
from billow.decks.radioss.columns import card
from billow.decks.radioss.flat_cut import reference_of
from billow.decks.radioss.motions import motions_of, velocities_of
from billow.decks.radioss.starter_file import StarterDeck, kind_of, words
from billow.decks.radioss.starter_model import StarterModel, directions, number_of
from billow.decks.radioss.surroundings import put_interfaces, put_run, walls
from billow.decks.radioss.volume import airbag1, communications
from billow.decks.report import Report
from billow.decks.several_bags import area_of, chamber, join, put_hole
from billow.decks.shared_tables import NO_AIRBAG, Options, put_bag_tables, rest_of_base
from billow.decks.units import SYSTEMS

ALWAYS = {"BEGIN", "END", "TITLE", "UNIT"}
BY_FIELD = ("MONVOL", "MAT", "INTER")
"""Keywords of which every line is named."""
NOTHING = {("MAT", "VOID"), ("MAT", "LAW0")}
READ = ("AIRBAG1", "COMMU1")


def translated(path: Path, options: Options) -> tuple[Context, BagMesh]:
    """Raises InputError E-DCK-160, -161 and those of `import_deck`."""
    model = StarterModel(StarterDeck(path, options.allow_outside))
    report = Report()
    if options.units != "auto":
        model.deck.units = SYSTEMS[options.units]
        report.remarks.append(f"units {options.units}, as said")
    else:
        report.remarks.append(f"units {model.deck.units.name}, as /BEGIN says")
    context = Context(model, model.deck.units, report)
    base = read_toml(options.base) if options.base is not None else {}
    context.tables |= {"title": _title(model), "bag": {}, "fabric": {}, "gas": {}}
    block = _choose(model, options.airbag)
    if options.airbag is None and block is not None and kind_of(block) == "COMMU1":
        bag, place = _bags(context, Choices(options.parts, options.close, options.merge))
    else:
        bag, place = _bag(context, block, options)
    put_silence(context)
    put_cloth(context, bag, place, options, base)
    rest_of_base(context, base, block is None, path)
    put_run(context, base)
    bodies, motions, velocities = bodies_of(context), motions_of(context), velocities_of(context)
    attached = settle(context, bag, motions, bag.held.copy(), ["/BCS"], [b.part for b in bodies], constraint_of)
    _fixed(context, bag)
    put_bag_tables(context, bag)
    free = [body for body in bodies if body.part.number not in attached]
    made = walls(context, bag) + meshes(context, bag, free, motions, velocities, options.parts)
    put_by_name(context, made)
    velocities.put(context, bag)
    velocities.finish(context)
    motions.rest(context)
    put_interfaces(context, bag)
    report.keywords = _rest(context)
    report.finish()
    return context, bag


def _title(model: StarterModel) -> str:
    for block in model.find("TITLE") + model.find("BEGIN"):
        cards = Cards(model.deck.parameters, block)
        text = cards.text() if cards.left else ""
        if text and text.isprintable():
            return text
    return model.deck.path.stem


def _choose(model: StarterModel, wanted: int | None) -> Block | None:
    """The monitored volume to import. Raises InputError E-DCK-015."""
    bags = [b for b in model.find("MONVOL") if kind_of(b) in READ]
    if not bags:
        return None
    listed = "; ".join(f"{k}: {b.name} at {b.place}" for k, b in enumerate(bags, 1))
    joined = all(kind_of(b) == "COMMU1" for b in bags)
    if (wanted is None and len(bags) > 1 and not joined) or (wanted is not None and not 1 <= wanted <= len(bags)):
        raise NO_CHOICE(count=len(bags), listed=listed, place=bags[0].place)
    return bags[(wanted or 1) - 1]


def _bag(context: Context, block: Block | None, options: Options) -> tuple[BagMesh, str]:
    choices = Choices(options.parts, options.close, options.merge)
    model: StarterModel = context.model
    vents: set[int] = set()
    segments = None
    if block is None:
        members = np.array([n for n, kind in options.parts.items() if kind in ("fabric", "mouth", "vent")], np.int64)
        place = f"{model.deck.path.name}:1"
        if not len(members):
            parts = "; ".join(f"{p.number} {p.title}" for p in model.parts.values()) or "none"
            volumes = ", ".join(b.name for b in model.find("MONVOL")) or "none"
            raise NO_AIRBAG(
                what="which parts are the bag", place=place,
                why=f"it has no /MONVOL/AIRBAG1; its volumes are {volumes}, its parts {parts}",
                remedy="name them: --part 3=fabric, with the gas from --base CASE.toml",
            )  # fmt: skip
    else:
        airbag = airbag1(context, block)
        members, segments, place, vents = airbag.parts, airbag.segments, airbag.place, airbag.vents
        context.airbag = airbag
    return bag_mesh(model, members, segments, vents, place, context.units, choices, context.report, reference_of), place


def _bags(context: Context, choices: Choices) -> tuple[BagMesh, str]:
    """All /MONVOL/COMMU1 as chambers of one case, and the holes between them."""
    model, report = context.model, context.report
    blocks = {number_of(b): b for b in model.find("MONVOL", "COMMU1")}
    bag, place = join(context, blocks, airbag1, choices, reference_of)
    pairs: dict[tuple[int, int], int] = {}
    for number, block in blocks.items():
        own = replace(context, units=model.deck.units_of(block))
        for f in communications(context, block):
            other = f["bag_ID"].whole
            if other not in blocks:
                raise f["bag_ID"].bad(f"the volumes that communicate are {', '.join(map(str, blocks))}")
            report.mapped(f["bag_ID"], chamber(other), "gas.orifices.between")
            for name in ("dPCdef", "Tcom", "dtPCdef", "fct_IDCt", "fct_IDCP"):
                if f[name].number:
                    report.refused(f[name], "a hole between chambers is open from the start, and its area constant")
            pair = (min(number, other), max(number, other))
            pairs[pair] = pairs.get(pair, 0) + 1
            area = own.si(f["Acom"], "area")
            if f["surf_IDc"].whole:
                area = (f["Acom"].number or 1.0) * area_of(bag, model.surface(f["surf_IDc"].whole, f["surf_IDc"])[0])
                report.approximated(f["surf_IDc"], "a hole of its area at the start", area, "gas.orifices.area")
            report.mapped(f["Acom"], area, "gas.orifices.area")
            if pairs[pair] == 1 and area:
                put_hole(context, [chamber(number), chamber(other)], said(area, f["Acom"]), said(1.0, f["Acom"]))
    for (one, other), count in pairs.items():
        if count == 1:
            report.remarks.append(f"volumes {one} and {other}: gas flows both ways, though one of them alone says so")
    return bag, place


def _fixed(context: Context, bag: BagMesh) -> None:
    """Rows of /BCS."""
    model, report = context.model, context.report
    for block in model.find("BCS"):
        if len(words(block)) != 2:
            model.used.discard(block.name)
            continue
        f = card(context, model.cards(block), "BCS", "bcs")
        ways = directions(f["Trarot"])
        mine = np.isin(model.group(f["grnd_ID"].whole, f["grnd_ID"]), bag.nodes).sum()
        key = "bag.fixed_nodes" if ways[:3].all() else "nodes.motion.directions"
        if f["skew_ID"].whole and mine:
            report.refused(f["skew_ID"], "directions of a skew: hold the nodes along x, y or z of the deck")
        elif ways.any():
            report.mapped(f["Trarot"], f["Trarot"].text, key)
            report.mapped(f["grnd_ID"], f"{mine} nodes of the bag", key)


def _rest(context: Context) -> dict[str, int]:
    """Rows for lines of volumes, materials and interfaces that nobody read; and the keywords that were not read."""
    model, report, missed = context.model, context.report, []
    places = {field.place for field in report.fields}
    for block in model.deck.blocks:
        word = words(block)[0]
        if word in ALWAYS:
            continue
        seen = any(f"{block.file}:{line}" in places for line, _ in block.lines())
        if word in BY_FIELD and not seen:
            for line, text in block.lines():
                shown = text.decode("latin-1").strip()
                one = Field(block.name, f"line_{line - block.line}", shown, f"{block.file}:{line}")
                report.take([one])
                report.ignored(one, "no part, volume or interface that is imported needs it")
        if words(block)[:2] in NOTHING:
            continue
        if block.name not in model.used or (word in BY_FIELD and not seen):
            missed.append("/" + "/".join(w for w in words(block) if not w.isdecimal()))
    return dict(Counter(missed))
