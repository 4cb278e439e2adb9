"""`billow import-deck`: from a deck to a case that loads, its meshes, curves, and a report of every field."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.base.toml_file import read_toml
from billow.case.schema import Case
from billow.decks import airbag as gas
from billow.decks.airbag_gas import put_silence
from billow.decks.bag_mesh import BagMesh, Choices, bag_mesh, material_of
from billow.decks.block import Block
from billow.decks.cards import Field
from billow.decks.contacts import put_contact
from billow.decks.context import Context
from billow.decks.draft import case_text, plain, said, source_of
from billow.decks.evidence import evidence_of, told
from billow.decks.fabric import added_leakage, fabric_cards, leakage, put_fabric, same_fabric
from billow.decks.fixed import put_fixed
from billow.decks.jets import put_jets
from billow.decks.keyword_file import Deck
from billow.decks.mesh_model import mesh_model
from billow.decks.motions import motions_of
from billow.decks.obstacles import put_obstacles
from billow.decks.radioss.starter_file import is_starter
from billow.decks.radioss.translate import translated as of_starter
from billow.decks.report import Report
from billow.decks.several_bags import put_bags, put_chambers
from billow.decks.shared_tables import NO_AIRBAG, Options, put_bag_tables, rest_of_base
from billow.decks.straps import put_straps
from billow.decks.tables import Model
from billow.decks.units import SYSTEMS, Units, find_units
from billow.decks.unread import name_the_rest
from billow.decks.velocities import velocities_of
from billow.decks.warp import put_warp
from billow.geometry.mesh_file import SUFFIXES
from billow.geometry.mesh_writing import write_mesh
from billow.results.atomic import new_folder, new_place

NO_SUCH_CASE = InputError.declare(
    "E-DCK-018",
    "{key} cannot be what the deck says",
    where="{place}",
    cause="a number in another unit, or a model beyond what Billow is made for",
    remedy="check the field and --units; the case it would have made was not written",
)


def import_deck(path: str | Path, out: str | Path, options: Options | None = None) -> Report:
    """Write a case folder from a deck; the report says what became of each field.

    Raises InputError E-DCK-001..018 and those of a case; nothing is written then. E-RES-009 if out exists.
    """
    path, options = Path(path), options or Options()
    new_place(Path(out))
    context, bag = translated(path, options)
    case, report = context.tables, context.report
    head = [f"From {path.name}, units {context.units.name}. What became of each field: import.md."]
    with new_folder(Path(out)) as folder:
        (folder / "curves").mkdir()
        write_mesh(folder / "start.vtkhdf", bag.start)
        if bag.reference is not None:
            write_mesh(folder / "reference.vtkhdf", bag.reference)
        if context.meshes:
            (folder / "obstacles").mkdir()
        for name, mesh in context.meshes.items():
            write_mesh(folder / name, mesh)
        for name, text in context.curves.items():
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "case.toml").write_text(case_text(head, case), encoding="utf-8")
        report.write(folder, path.name)
        _require_loadable(folder / "case.toml", case, path, bag.place)
    return report


def translated(path: Path, options: Options) -> tuple[Context, BagMesh]:
    """The draft of a case and its meshes."""
    if is_starter(path):
        return of_starter(path, options)
    is_mesh = path.suffix.lower() in SUFFIXES
    model = mesh_model(path) if is_mesh else Model(Deck(path, options.allow_outside))
    report = Report()
    joined = gas.joined(model.all("AIRBAG")) if options.airbag is None else []
    block = joined[0] if joined else gas.choose(model.all("AIRBAG"), options.airbag)
    units = _units(model, block, options, path, report)
    context = Context(model, units, report)
    base = read_toml(options.base) if options.base is not None else {}
    context.tables |= {"title": _title(model), "bag": {}, "fabric": {}, "gas": {}}
    if joined:
        bag, place = put_bags(context, joined, Choices(options.parts, options.close, options.merge))
    else:
        bag, place = _bag(context, block, options)
    put_silence(context)
    _fabric(context, bag, place, options, base)
    rest_of_base(context, base, block is None, path)
    _run(context, base)
    motions = motions_of(context)
    attached = put_fixed(context, bag, motions)
    put_straps(context, bag)
    put_bag_tables(context, bag)
    velocities = velocities_of(context)
    put_obstacles(context, set(bag.parts) | attached, options.parts, motions, velocities, bag.start.points)
    velocities.put(context, bag)
    velocities.finish(context)
    motions.rest(context)
    put_contact(context, set(bag.parts))
    report.keywords = name_the_rest(context)
    report.finish()
    return context, bag


def _title(model: Model) -> str:
    for block in model.all("TITLE"):
        text = " ".join(line.decode("latin-1") for _, line in block.lines()).strip()
        if text and text.isprintable():
            return text
    return model.deck.path.stem


def _units(model: Model, block: Block | None, options: Options, path: Path, report: Report) -> Units:
    if options.units != "auto":
        report.remarks.append(f"units {options.units}, as said")
        return SYSTEMS[options.units]
    cloth = [number for number, kind in options.parts.items() if kind == "fabric"]
    said_by_deck = told(model, block)
    found = find_units(list(evidence_of(model, block, cloth)), str(path), said_by_deck)
    how = f"as UNIT at {said_by_deck[1]} says" if said_by_deck else "the one system in which everything fits"
    report.remarks.append(f"units {found.name}: {how}")
    return found


def _bag(context: Context, block: Block | None, options: Options) -> tuple[BagMesh, str]:
    choices = Choices(options.parts, options.close, options.merge)
    if block is None:
        members = np.array([n for n, kind in options.parts.items() if kind in ("fabric", "mouth", "vent")], np.int64)
        place = f"{context.model.deck.path.name}:1"
        if not len(members):
            parts = "; ".join(f"{p.number} {p.title}" for p in context.model.parts.values()) or "none"
            raise NO_AIRBAG(
                what="which parts are the bag",
                place=place,
                why=f"it has no *AIRBAG that is read; its parts are {parts}",
                remedy="name them: --part 3=fabric",
            )
        vents: set[int] = set()
        segments = None
    else:
        airbag = gas.put_airbag(context, block)
        members, segments, place, vents = airbag.parts, airbag.segments, airbag.place, airbag.vents
        context.airbag = airbag
        if airbag.chambers:
            return put_chambers(context, airbag, choices), place
    bag = bag_mesh(context.model, members, segments, vents, place, context.units, choices, context.report)
    if block is not None:
        put_jets(context, context.airbag, bag)
    return bag, place


def _fabric(context: Context, bag: BagMesh, place: str, options: Options, base: dict[str, Any]) -> None:
    """The fabric of the bag, and what of it differs from part to part: thickness and leakage."""
    model = context.model
    found: dict[int, dict[str, Field]] = {}
    cloth = [n for n, table in bag.parts.items() if table["kind"] == "fabric"]
    for number in cloth:
        material = material_of(model, number)
        if material and material[0] == "MAT_FABRIC":
            found[number] = fabric_cards(context, material[1])
    if not found:
        if "fabric" not in base:
            raise NO_AIRBAG(what="what the fabric is", place=place, why="no part of the bag has *MAT_FABRIC")
        return
    fabrics = _fabrics(context, bag, found)
    (first, *_), *others = fabrics
    put_fabric(context, found[first], options.measure)
    for number in (n for members in fabrics for n in members if n != first):
        if number in fabrics[0]:
            for name, one in found[number].items():
                if not context.report.settled(one) and name in found[first]:
                    context.report.mapped(one, note="as the fabric of the bag")
        else:
            put_fabric(context, found[number], options.measure, f"fabric.parts.{bag.parts[number]['name']}")
    thick = {n: _thickness(context, bag, n) for n in cloth}
    if not any(thick.values()) and "thickness" not in base.get("fabric", {}):
        raise NO_AIRBAG(what="how thick the fabric is", place=place, why="its parts have no *SECTION_SHELL")
    of_parts = [n for members in others for n in members]
    groups = [([n for n in cloth if n not in of_parts], "fabric")]
    groups += [([n], f"fabric.parts.{bag.parts[n]['name']}") for n in of_parts]
    for members, key in groups:
        # Layers are counted from the thinnest part of a fabric on.
        known = {n: thick[n] for n in members if thick[n]}
        if not known:
            continue
        thinnest = min(known, key=known.get)
        source = model.thicknesses.get(model.parts[thinnest].section) if thinnest in model.parts else None
        context.set(f"{key}.thickness", known[thinnest], source[2] if source else "ELEMENT_SHELL_THICKNESS")
        for number, value in known.items():
            if not math.isclose(value, known[thinnest], rel_tol=1e-9):
                bag.parts[number]["layers"] = value / known[thinnest]
    option = context.airbag.option if context.airbag is not None else 0
    laws = {n: leakage(context, added_leakage(context, g), option) for n, g in found.items()}
    if any(laws.values()):
        if all(plain(law) == plain(laws[first]) for law in laws.values()) and len(laws) == len(cloth):
            context.tables["leakage"] = {**context.tables.get("leakage", {}), **laws[first]}
        else:
            names = {bag.parts[n]["name"]: law for n, law in laws.items() if law}
            context.tables.setdefault("leakage", {})["parts"] = names
    put_warp(context, bag, found)


def _fabrics(context: Context, bag: BagMesh, found: dict[int, dict[str, Field]]) -> list[list[int]]:
    """Parts of the same fabric together, the fabric of most shells first."""
    groups: list[list[int]] = []
    for number, f in found.items():
        mine = next((members for members in groups if same_fabric(context, found[members[0]], f)), None)
        if mine is None:
            groups.append(mine := [])
        mine.append(number)
    groups.sort(key=lambda members: -int(np.isin(bag.start.part, members).sum()))
    if len(groups) > 1:
        names = "; ".join(", ".join(bag.parts[n]["name"] for n in members) for members in groups)
        context.report.remarks.append(f"{len(groups)} fabrics, of parts {names}: the first is [fabric]")
    return groups


def _thickness(context: Context, bag: BagMesh, number: int) -> float | None:
    """Of a part [m]: of its shells if they say it, else of its section."""
    shells, model = context.model.shells, context.model
    mine = bag.shell[(bag.shell >= 0) & (bag.start.part == number)]
    own = shells.thickness[mine]
    if (own > 0.0).all():
        spread = float(np.ptp(own) / own.mean())
        if spread > 1e-6:
            context.report.remarks.append(f"part {number}: thickness varies by {100 * spread:.2g} %; its mean is used")
        return float(own.mean()) * context.units.length
    section = model.thicknesses.get(model.parts[number].section) if number in model.parts else None
    if section is None:
        return None
    context.report.take([section[2]])
    context.report.mapped(section[2], section[0] * context.units.length, "fabric.thickness")
    return section[0] * context.units.length or None


def _run(context: Context, base: dict[str, Any]) -> None:
    run = dict(base.get("run", {}))
    model, report = context.model, context.report
    end = None
    for block in model.all("CONTROL_TERMINATION"):
        f = context.card(context.cards(block), "termination")
        if f["ENDTIM"].number:
            end = context.si(f["ENDTIM"], "time")
            run["end_time"] = said(end, f["ENDTIM"])
            report.mapped(f["ENDTIM"], end)
    frame = None
    for name, key in (("DATABASE_BINARY_D3PLOT", "frames"), ("DATABASE_ABSTAT", "histories_per_frame")):
        for block in model.all(name):
            one = context.card(context.cards(block), "interval")["DT"]
            step = context.si(one, "time")
            whole = end if key == "frames" else frame
            if not step > 0.0 or not whole:
                continue
            count = max(1, min(round(whole / step), 1000))
            frame = end / count if key == "frames" else frame
            run[key] = said(count, one)
            report.mapped(one, count, f"run.{key}")
    for block in model.all("LOAD_BODY"):
        axis = "XYZ".find(block.name.removeprefix("LOAD_BODY_")[:1])
        f = context.card(context.cards(block), "load")
        if axis < 0 or block.name.startswith("LOAD_BODY_R"):
            report.refused(f["LCID"], "a body load of this kind has no counterpart")
            continue
        points = model.curve(f["LCID"]).points
        value = context.units.si(float(points[0, 1]) * (f["SF"].number or 1.0), "acceleration")
        gravity = list(plain(run.get("gravity", [0.0, 0.0, 0.0])))
        gravity[axis] -= value  # the load is an acceleration of the frame: bodies go the other way
        run["gravity"] = said(gravity, f["LCID"])
        if np.ptp(points[:, 1]):
            report.approximated(f["LCID"], "it varies in time; its first value is kept", -value, "run.gravity")
        else:
            report.mapped(f["LCID"], -value, "run.gravity")
    context.tables["run"] = run


def _require_loadable(path: Path, tables: dict[str, Any], deck: Path, bag_place: str) -> None:
    """Raises InputError E-DCK-018, with the field that a value comes from, if the case does not load."""
    try:
        Case.load(path)
    except InputError as error:
        key = error.where.partition(", key ")[2].partition(",")[0]
        source = source_of(tables, key.split(".")) or f"{bag_place} (the bag)"
        raise NO_SUCH_CASE(key=key or "the case", place=f"{deck}: {source}", why=f"{error.what}: {error.why}") from None
