"""Bags that *AIRBAG_INTERACTION joins, as the chambers of one case: a mesh in which shells of two bags stand once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from billow.decks.airbag import put_airbag
from billow.decks.airbag_gas import Airbag
from billow.decks.bag_mesh import BagMesh, Choices, bag_mesh
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import Said, plain, said
from billow.decks.fields import CARDS
from billow.decks.flat_reference import NO_SURFACE, reference_of
from billow.decks.jets import put_jets
from billow.geometry.mesh_file import CellMesh
from billow.geometry.mesh_repair import flipped

SHARED = ("model", "cell", "switch_time", "particles", "heat_transfer")
"""Keys of `[gas]` of which a case has one for all chambers."""
FAR = 1_000_000
"""What numbers of virtual parts are moved by from bag to bag."""


def put_bags(context: Context, blocks: list[Block], choices: Choices) -> tuple[BagMesh, str]:
    """One mesh and the tables of the gas of all bags; each is a chamber, bag_ID. Raises InputError as for one bag."""
    names = {_number(context, block) or k: block for k, block in enumerate(blocks, 1)}
    openings = dict.fromkeys(_openings(context), "opening")
    bag, place = join(context, names, put_airbag, replace(choices, parts=openings | choices.parts), reference_of)
    for block in context.model.all("AIRBAG_INTERACTION"):
        _interaction(context, block, names, bag)
    return bag, place


def _openings(context: Context) -> list[int]:
    """Parts without fabric by whose area *AIRBAG_INTERACTION joins two bags."""
    found = []
    for block in context.model.all("AIRBAG_INTERACTION"):
        f = Cards(context.model.deck.parameters, block).card("interaction", CARDS["AIRBAG_INTERACTION"]["interaction"])
        material = context.model.material_of(f["PID"].whole)
        if not f["AREA"].number and f["SF"].number >= 0.0 and (material is None or material[0] != "MAT_FABRIC"):
            found.append(f["PID"].whole)
    return [part for part in found if part in context.model.parts]


def chamber(number: int) -> str:
    """Name of the chamber that an airbag becomes."""
    return f"bag_{number}"


def join(
    context: Context, blocks: dict[int, Block], put: Callable[[Context, Block], Airbag], choices: Choices, references
) -> tuple[BagMesh, str]:
    """blocks: of airbags, by number. put: reads one. references: as `bag_mesh` has it."""
    meshes: list[tuple[str, BagMesh]] = []
    for number, block in blocks.items():
        own = replace(context, tables={"bag": {}, "gas": {}})
        airbag = put(own, block)
        bag = bag_mesh(
            context.model, airbag.parts, airbag.segments, airbag.vents, airbag.place, context.units, choices,
            context.report, references,
        )  # fmt: skip
        put_jets(own, airbag, bag)
        _join_tables(context, own.tables, chamber(number), block)
        context.airbag = context.airbag or airbag
        meshes.append((chamber(number), bag))
    return _joined(context, meshes), meshes[0][1].place


def put_chambers(context: Context, airbag: Airbag, choices: Choices) -> BagMesh:
    """One mesh of an airbag whose chambers its cards list, and its jets."""
    choices = replace(choices, parts=dict.fromkeys(airbag.openings, "opening") | choices.parts)
    meshes = [
        (f"chamber_{number}", bag_mesh(
            context.model, parts, None, airbag.vents, airbag.place, context.units, choices, context.report
        ))
        for number, parts in airbag.chambers.items()
    ]  # fmt: skip
    bag = _joined(context, meshes)
    put_jets(context, airbag, bag)
    return bag


def _number(context: Context, block: Block) -> int:
    """Id of an airbag, 0 if it has none."""
    if "_ID" not in block.name:
        return 0
    return Cards(context.model.deck.parameters, block).card("id", "ABID")["ABID"].whole


def _join_tables(context: Context, own: dict[str, Any], name: str, block: Block) -> None:
    """The gas of one bag into the case: its names begin with the bag's, but gases that are alike are one."""
    tables, report = context.tables, context.report
    gas, mine = tables.setdefault("gas", {}), own["gas"]

    species = gas.setdefault("species", {})
    alike = {
        key: next((old for old, terms in species.items() if plain(terms) == plain(value)), f"{name}_{key}")
        for key, value in mine.get("species", {}).items()
    }

    def called(text: str) -> str:
        return alike.get(text, f"{name}_{text}")

    def differs(what: str) -> None:
        one = Field(block.name, what, "", block.place)
        report.take([one])
        report.refused(one, f"all bags of a case share it; that of the first counts for {name}")

    for key, value in mine.get("species", {}).items():
        species.setdefault(called(key), value)
    for one in own.get("inflator", []):
        one |= {
            "name": f"{name}_{one['name']}",
            "chamber": name,
            "gas": {called(g): share for g, share in one["gas"].items()},
        }
        tables.setdefault("inflator", []).append(one)
    for one in mine.get("orifices", []):
        ends = [name if end == "bag" else end for end in one["between"]]
        gas.setdefault("orifices", []).append(one | {"name": f"{name}_{one['name']}", "between": ends})
    first = "initial" not in gas
    initial = dict(mine.get("initial", {}))
    if "gas" in initial:
        initial["gas"] = {called(g): share for g, share in initial["gas"].items()}
    if first:
        gas["initial"] = initial
    elif _state(gas, gas["initial"]) != _state(gas, initial):
        differs("gas at the start")
    for key in SHARED:
        if first and key in mine:
            gas[key] = mine[key]
        elif plain(gas.get(key)) != plain(mine.get(key)):
            differs(f"gas.{key}")
    for key, source in (("ambient", own), ("vents", own["bag"])):
        place = tables if key == "ambient" else tables["bag"]
        if key not in source:
            continue
        if plain(place.setdefault(key, source[key])) != plain(source[key]):
            differs(key)


def _state(gas: dict[str, Any], initial: dict[str, Any]) -> list[Any]:
    """A state at the start without names of gases."""
    shares = plain(initial.get("gas", {}))
    kinds = sorted((sorted(plain(gas["species"].get(name, {})).items()), share) for name, share in shares.items())
    return [kinds, {key: plain(value) for key, value in initial.items() if key != "gas"}]


def _joined(context: Context, meshes: list[tuple[str, BagMesh]]) -> BagMesh:
    """One mesh: nodes by their ids in the deck, shells of two bags once, with the second bag ahead of them."""
    of_id: dict[int, int] = {}
    owner: dict[int, int] = {}
    points, flat, start_cells, flat_cells, part, shell, turned_, held = ([] for _ in range(8))
    nodes, index, tables, count, flat_count = [], [], {}, 0, 0
    any_flat = any(bag.reference is not None for _, bag in meshes)
    for k, (name, bag) in enumerate(meshes):
        new = np.full(len(bag.start.points), -1, np.int64)
        for number, at in zip(bag.nodes.tolist(), bag.index.tolist(), strict=True):
            if at >= 0 and number in of_id:
                new[at] = of_id[number]
        fresh = np.flatnonzero(new < 0)
        new[fresh] = count + np.arange(len(fresh))
        count += len(fresh)
        points.append(bag.start.points[fresh])
        mine = bag.index >= 0
        of_id |= dict(zip(bag.nodes[mine].tolist(), new[bag.index[mine]].tolist(), strict=True))
        nodes.append(bag.nodes[mine])
        index.append(new[bag.index[mine]])
        twice = np.array([row in owner for row in bag.shell.tolist()]) & (bag.shell >= 0)
        for number in np.unique(bag.start.part[twice]).tolist():
            if not twice[bag.start.part == number].all():
                why = f"part {number} belongs to two bags, but not all of its shells"
                raise NO_SURFACE(place=bag.place, why=why, remedy="make what both bags share a part of its own")
            tables[number]["ahead"] = name
        move = {}
        for number, table in bag.parts.items():
            if number in np.unique(bag.start.part[twice]):
                continue
            move[number] = number if number in context.model.parts else number + k * FAR
            taken = {other["name"] for other in tables.values()}
            title = f"{table['name']}_{name}" if table["name"] in taken else table["name"]
            tables[move[number]] = {**table, "number": move[number], "name": title, "behind": name}
        kept = ~twice
        owner |= dict.fromkeys(bag.shell[kept & (bag.shell >= 0)].tolist(), k)
        cells = bag.start.cells[kept]
        start_cells.append(np.where(cells >= 0, new[cells], -1))
        part.append(np.array([move[number] for number in bag.start.part[kept].tolist()], np.int64))
        cut = bag.reference if bag.reference is not None else bag.start
        cells = cut.cells[kept]
        flat_cells.append(np.where(cells >= 0, cells + flat_count, -1))
        flat.append(cut.points)
        flat_count += len(cut.points)
        shell.append(bag.shell[kept])
        turned_.append(bag.turned[kept])
        held.append((new, bag.held))
    still = np.zeros((count, 3), bool)
    for new, of_bag in held:
        np.logical_or.at(still, new, of_bag)
    numbers = np.concatenate(part)
    whole = BagMesh(
        CellMesh(np.concatenate(points), np.concatenate(start_cells), numbers, {}),
        CellMesh(np.concatenate(flat), np.concatenate(flat_cells), numbers, {}) if any_flat else None,
        tables, np.concatenate(shell), np.concatenate(turned_), np.concatenate(nodes), np.concatenate(index),
        meshes[0][1].place, still, meshes[0][1].birth, meshes[0][1].reference_source,
    )  # fmt: skip
    return _in_order(_walls_as_written(whole))


def _walls_as_written(bag: BagMesh) -> BagMesh:
    """Walls of which every shell was turned, because the second bag was read before the first, turned back: what lies
    behind and ahead of them changes places."""
    back = np.zeros(len(bag.shell), bool)
    for number, table in bag.parts.items():
        mine = bag.start.part == number
        if "ahead" in table and bag.turned[mine].all():
            back |= mine
            table["behind"], table["ahead"] = table["ahead"], table["behind"]
    start, cut = (mesh and replace(mesh, cells=flipped(mesh.cells, back)) for mesh in (bag.start, bag.reference))
    return replace(bag, start=start, reference=cut, turned=bag.turned ^ back)


def _in_order(bag: BagMesh) -> BagMesh:
    """Cells in the order of the deck's shells, virtual ones behind them; nodes in that of their lowest ids, parts in
    that of their numbers."""
    cell = np.argsort(np.where(bag.shell < 0, bag.shell.max(initial=0) + 1, bag.shell), kind="stable")
    lowest = np.full(len(bag.start.points), np.iinfo(np.int64).max)
    np.minimum.at(lowest, bag.index, bag.nodes)
    node = np.argsort(lowest, kind="stable")
    new = np.argsort(node)
    cells = bag.start.cells[cell]
    part = bag.start.part[cell]
    return replace(
        bag, start=CellMesh(bag.start.points[node], np.where(cells >= 0, new[cells], -1), part, {}),
        reference=bag.reference and CellMesh(bag.reference.points, bag.reference.cells[cell], part, {}),
        parts=dict(sorted(bag.parts.items())),
        shell=bag.shell[cell], turned=bag.turned[cell], index=new[bag.index], held=bag.held[node],
    )  # fmt: skip


def _interaction(context: Context, block: Block, names: dict[int, Block], bag: BagMesh) -> None:
    """A hole between two bags: AREA, or that of the part PID, times SF."""
    report, cards = context.report, Cards(context.model.deck.parameters, block)
    f = context.card(cards, "interaction")
    ends = []
    for name in ("AB1", "AB2"):
        if f[name].whole not in names:
            raise f[name].bad(f"the airbags of the deck are {', '.join(map(str, names))}")
        ends.append(chamber(f[name].whole))
        report.mapped(f[name], ends[-1])
    if f["LCID"].whole:
        report.refused(f["LCID"], "a flow against a difference of pressure: give AREA and SF")
    if f["IFLOW"].whole:
        report.refused(f["IFLOW"], "gas flows both ways through a hole of a case")
    area, share = context.si(f["AREA"], "area"), f["SF"].number
    if bag.parts.get(f["PID"].whole, {}).get("kind") == "opening":
        _opening(context, f, bag.parts[f["PID"].whole])
        return
    if area < 0.0:
        report.refused(f["AREA"], "an area against pressure has no counterpart: give a number")
        return
    if area:
        report.mapped(f["AREA"], area)
        report.ignored(f["PID"], "AREA counts")
    else:
        area = area_of(bag, [f["PID"].whole])
        if not area:
            raise f["PID"].bad("AREA is 0, and no part of the bags has this number")
        for name in ("AREA", "PID"):
            report.approximated(f[name], f"a hole of the area of part {f['PID'].whole} at the start", area)
    discharge: object = min(share, 1.0)
    if share < 0.0:
        discharge = context.curve(f["SF"], "time", "-", "a coefficient of a hole")
    elif share > 1.0:
        area *= share
    report.mapped(f["SF"], "curve" if share < 0.0 else share)
    put_hole(context, ends, said(area, f["AREA"]), said(discharge, f["SF"]))


def _opening(context: Context, f: dict[str, Field], part: dict[str, Any]) -> None:
    """A part that both bags have, through which gas flows over its present area. Raises InputError E-DCK-004."""
    report, share = context.report, f["SF"].number or 1.0
    if "ahead" not in part:
        raise f["PID"].bad("AREA is 0, and the part is not in the sets of both bags")
    for name in ("AREA", "PID"):
        report.mapped(f[name], part["name"], "bag.parts", "an opening of the present area of the part")
    gas = context.tables["gas"]
    if plain(gas.setdefault("opening_discharge", said(min(share, 1.0), f["SF"]))) != min(share, 1.0):
        report.refused(f["SF"], "openings of a case share one coefficient: that of the first is used")
    elif share > 1.0:
        report.approximated(f["SF"], "an opening is at most as large as its part", 1.0, "gas.opening_discharge")
    else:
        report.mapped(f["SF"], share, "gas.opening_discharge")


def area_of(bag: BagMesh, parts: Iterable[int]) -> float:
    """Of parts of the mesh at the start [m^2]."""
    cells = bag.start.cells[np.isin(bag.start.part, list(parts))]
    a, b, c, d = (bag.start.points[np.where(cells[:, k] < 0, cells[:, 2], cells[:, k])] for k in range(4))
    return float(0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1).sum())


def put_hole(context: Context, ends: list[str], area: Said, discharge: Said) -> None:
    """An orifice between two chambers."""
    orifices = context.tables["gas"].setdefault("orifices", [])
    name = f"interaction_{len(orifices) + 1}"
    orifices.append({"name": name, "between": ends, "area": area, "discharge": discharge})
