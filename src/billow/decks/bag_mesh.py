"""The bag of a deck as start and reference mesh: its parts, seams, normals, open edges and flat cut."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import Block
from billow.decks.cards import Field
from billow.decks.flat_reference import NO_SURFACE, reference_of
from billow.decks.report import Report
from billow.decks.tables import Model
from billow.decks.units import Units
from billow.geometry import mesh_file
from billow.geometry.mesh_file import CellMesh
from billow.geometry.mesh_repair import (
    crowded,
    filling,
    flipped,
    free_edges,
    loops,
    merged,
    pieces,
    seam_tolerance,
    to_flip,
    volumes,
)

UNKNOWN_PART = InputError.declare(
    "E-DCK-010",
    "what part {part} of the bag is cannot be told",
    where="{place}",
    cause="a part without a material, or of *MAT_NULL, which may be a vent, the inflator's mouth or fabric",
    remedy="say it: --part {part}=fabric, =mouth or =vent",
)
OPEN_BAG = InputError.declare(
    "E-DCK-011",
    "the bag is open",
    where="{place}",
    cause="the hole that the inflator or a vent takes, or a seam whose nodes are not merged",
    remedy="say what closes them: --close 1=mouth, --close 2=vent, ...; or merge the seam with --merge LENGTH",
)
FLAT = 1e-6
"""Share of the volume of a ball of the same area below which the sign of a volume says nothing."""
KINDS = ("fabric", "mouth", "vent", "obstacle", "plate", "ignore")


@dataclass
class BagMesh:
    """start, reference: as a case wants them, in metres. parts: a table for each part, by number in the mesh. shell:
    row of each cell among the shells of the deck, -1 for virtual ones. turned: cells whose normals were turned. nodes:
    deck ids of the nodes of the start mesh; index: mesh node of each of them. held: directions in which each mesh node
    stands still by its own card, (nodes, 3) bool. birth: field of the birth time."""

    start: CellMesh
    reference: CellMesh | None
    parts: dict[int, dict]
    shell: np.ndarray
    turned: np.ndarray
    nodes: np.ndarray
    index: np.ndarray
    place: str
    held: np.ndarray
    birth: Field | None = None
    reference_source: str = ""

    def mesh_nodes(self, ids: np.ndarray) -> np.ndarray:
        """Mesh nodes of those ids that are nodes of the bag, sorted."""
        mine = self.index[np.isin(self.nodes, ids)]
        return np.unique(mine[mine >= 0])

    @property
    def mouth(self) -> np.ndarray:
        """Mesh nodes of parts that are mouths, sorted."""
        mouths = [number for number, part in self.parts.items() if part["kind"] == "mouth"]
        cells = self.start.cells[np.isin(self.start.part, mouths)]
        return np.unique(cells[cells >= 0])


@dataclass
class Choices:
    """What the options of the command say. parts: number -> kind. close: kinds of open edges, by number from 1, 0 for
    all. merge: [m], or None for the default."""

    parts: dict[int, str] = field(default_factory=dict)
    close: dict[int, str] = field(default_factory=dict)
    merge: float | None = None


def bag_mesh(
    model: Model, members: np.ndarray | None, segments: tuple[np.ndarray, str] | None, vents: set[int], place: str,
    units: Units, choices: Choices, report: Report, references=reference_of,
) -> BagMesh:  # fmt: skip
    """The bag of these parts, or of these segments. vents: parts that are vents. place: of the airbag's set.
    references: reads the flat cut, as `reference_of`.

    Raises InputError E-DCK-006 (an id), -010 (a part), -011 (open), -012 (no surface).
    """
    shells = model.shells
    if segments is None:
        members = np.array([m for m in members if choices.parts.get(int(m)) != "ignore"], dtype=np.int64)
        rows = np.flatnonzero(np.isin(shells.part, members))
        corners, part = shells.corners[rows], shells.part[rows]
        empty = np.setdiff1d(members, part)
        if len(empty):
            report.remarks.append(f"part {', '.join(map(str, empty))} of the bag has no shells")
    else:
        corners, rows, part = _of_segments(shells, segments[0])
    if not len(rows):
        raise NO_SURFACE(place=place, why="its set names no shells of the deck")
    if len(rows) > mesh_file.MOST_CELLS:
        why = f"it has {len(rows)} shells; at most {mesh_file.MOST_CELLS} are allowed"
        raise NO_SURFACE(place=place, why=why, remedy="take out of its set what is no fabric of the bag")
    cell_place = [shells.place(r) if r >= 0 else place for r in (rows[0], rows[-1])]
    kinds = _kinds(model, np.unique(part[rows >= 0]), vents, choices, place)
    outside = -1 if (part < 0).any() else None
    if outside is not None:
        kinds[outside] = "mouth"
        report.remarks.append("segments that are no shells close the bag: taken as the inflator's mouth")

    ids = np.unique(corners[corners >= 0])
    at = model.nodes.rows(ids, "a shell of the bag", cell_place[0])
    points = model.nodes.metres(at, units)
    own = np.where(corners >= 0, np.searchsorted(ids, corners), -1)
    own, kept = _sound(own, rows, shells, report)
    rows, part = rows[kept], part[kept]

    target = _merge(points, own, choices.merge, report, place)
    cells = np.where(own >= 0, target[own], -1)
    _require_edges(points, cells, rows, shells, place)
    try:
        turn = to_flip(cells)
    except ValueError as error:
        raise NO_SURFACE(place=place, why=error) from None
    cells, own = flipped(cells, turn), flipped(own, turn)
    around = _Around.of(model, np.unique(part), vents, ids, target)
    cells, own, rows, part, kinds = _closed(points, cells, own, rows, part, kinds, choices, around, report, place)
    inside_out = _inside_out(points, cells, report)
    cells, own = flipped(cells, inside_out), flipped(own, inside_out)
    turned = np.concatenate([turn, np.zeros(len(cells) - len(turn), bool)]) ^ inside_out
    if turned.any():
        report.remarks.append(f"{turned.sum()} of {len(cells)} cells turned so that all normals point out of the bag")

    used = np.unique(cells[cells >= 0])
    new = np.full(len(ids), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    start = CellMesh(points[used], np.where(cells >= 0, new[cells], -1), _numbered(part), {})
    reference, birth, source = references(model, ids, points, own, rows, turned, units, report)
    if reference is not None:
        reference = CellMesh(*reference, start.part, {})
    tables = {
        number: {"name": name, "number": number, "kind": kinds[deck]}
        for deck, number, name in _named(model, part)
    }  # fmt: skip
    index, held = new[target], np.zeros((len(used), 3), bool)
    np.logical_or.at(held, index[index >= 0], model.nodes.held[at][index >= 0])
    return BagMesh(start, reference, tables, rows, turned, ids, index, place, held, birth, source)


def _of_segments(shells, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners, rows and parts of the shells that segments lie on; -1 for segments that are no shells."""
    known_cells = {key: row for row, key in enumerate(map(tuple, np.sort(shells.corners, axis=1).tolist()))}
    rows = np.array([known_cells.get(tuple(sorted(c)), -1) for c in corners.tolist()], dtype=np.int64)
    return corners, rows, np.where(rows >= 0, shells.part[rows], -1) if len(shells.part) else np.full(len(rows), -1)


def material_of(model: Model, part: int) -> tuple[str, Block] | None:
    """Keyword, as `fields` knows it, and block of a part's material; None if the deck has none."""
    return model.material_of(part)


def _kinds(model: Model, parts: np.ndarray, vents: set[int], choices: Choices, place: str) -> dict[int, str]:
    kinds = {}
    for part in parts.tolist():
        found = material_of(model, part)
        by_material = {"MAT_FABRIC": "fabric", "MAT_RIGID": "mouth"}.get(found[0] if found else "")
        kind = choices.parts.get(part) or ("vent" if part in vents else by_material)
        if kind is None:
            why = f"its material is {found[1].shown}" if found else "it has no material"
            raise UNKNOWN_PART(part=part, place=model.parts[part].place if part in model.parts else place, why=why)
        kinds[part] = kind
    return kinds


def _sound(own: np.ndarray, rows: np.ndarray, shells, report: Report) -> tuple[np.ndarray, np.ndarray]:
    """Cells whose corners are distinct, quads with two equal corners made triangles; and which are kept."""
    out, kept = own.copy(), np.ones(len(own), dtype=bool)
    for k in np.flatnonzero((np.sort(own, axis=1)[:, 1:] == np.sort(own, axis=1)[:, :-1]).any(axis=1)):
        distinct = list(dict.fromkeys(c for c in own[k].tolist() if c >= 0))
        kept[k] = len(distinct) == 3
        if kept[k]:
            out[k] = [*distinct, -1]
        else:
            place = shells.place(rows[k]) if rows[k] >= 0 else "a segment"
            report.remarks.append(f"{place}: a shell without area left out")
    return out[kept], kept


def _merge(points: np.ndarray, cells: np.ndarray, tolerance: float | None, report: Report, place: str) -> np.ndarray:
    chosen = seam_tolerance(points, cells) if tolerance is None else tolerance
    if not chosen > 0.0:
        return np.arange(len(points))
    try:
        target, count = merged(points, cells, chosen)
    except ValueError as error:
        raise NO_SURFACE(place=place, why=error, remedy="choose a smaller --merge, or 0 to merge nothing") from None
    if count:
        report.remarks.append(f"{count} nodes on open edges merged with others within {1e3 * chosen:.3g} mm")
    return target


def _require_edges(points: np.ndarray, cells: np.ndarray, rows: np.ndarray, shells, place: str) -> None:
    found = crowded(cells)
    if found is None:
        return
    ends, sharing = found
    at = ", ".join(f"{v:.4g}" for v in points[ends].mean(axis=0))
    named = [rows[k] for k in sharing if rows[k] >= 0]
    listed = ", ".join(str(shells.number[r]) for r in named)
    parts = ", ".join(str(p) for p in np.unique(shells.part[named]))
    raise NO_SURFACE(
        place=shells.place(named[0]) if named else place,
        why=f"{len(sharing)} shells share one edge at ({at}) m: shells {listed} of part {parts}",
    )


@dataclass(frozen=True)
class _Around:
    """What closes open edges by itself: parts beside the bag, with those nodes of the bag that each has, (nodes,)."""

    rigid: dict[int, np.ndarray]
    vents: dict[int, np.ndarray]

    @classmethod
    def of(cls, model: Model, members: np.ndarray, vents: set[int], ids: np.ndarray, target: np.ndarray) -> _Around:
        """members: parts of the bag; vents: parts that are vents, in the bag or beside it. ids: of the nodes of the
        bag; target: to which each is merged."""
        shells = model.shells
        found: tuple[dict[int, np.ndarray], dict[int, np.ndarray]] = {}, {}
        for part in np.setdiff1d(shells.part, members).tolist():
            material = material_of(model, part)
            is_rigid = material is not None and material[0] == "MAT_RIGID"
            if not (is_rigid or part in vents):
                continue
            touched = np.zeros(len(ids), bool)
            touched[target[np.isin(ids, shells.corners[shells.part == part])]] = True
            found[part in vents][part] = touched
        return cls(*found)

    def closes(self, loop: np.ndarray) -> tuple[str, str] | None:
        """Kind of an open edge with these nodes, and why; None if nothing says it, or more than one part does."""
        answers = [(kind, f"all its nodes belong to {called} {part}") for kind, called, parts in (
            ("mouth", "the rigid part", self.rigid), ("vent", "the vent, part", self.vents)
        ) for part, touched in parts.items() if touched[loop].all()]  # fmt: skip
        return answers[0] if len({kind for kind, _ in answers}) == 1 else None


def _closed(points, cells, own, rows, part, kinds, choices: Choices, around: _Around, report: Report, place: str):
    """Everything again, with virtual triangles that close the open edges."""
    if not len(free_edges(cells)):
        return cells, own, rows, part, kinds
    try:
        found = loops(cells)
    except ValueError as error:
        raise NO_SURFACE(place=place, why=error, remedy="merge the seam with --merge LENGTH") from None
    kinds = dict(kinds)
    told, added, numbers, missing = [], [], [], False
    for k, loop in enumerate(found, 1):
        middle = points[loop].mean(axis=0)
        size = 2.0 * float(np.linalg.norm(points[loop] - middle, axis=1).mean())
        at = ", ".join(f"{v:.4g}" for v in middle)
        told.append(f"{k}: {len(loop)} nodes, {1e3 * size:.4g} mm wide, around ({at}) m")
        clear = around.closes(loop)
        asked = choices.close.get(k, choices.close.get(0))
        kind = asked or (clear[0] if clear else None)
        if kind is None:
            missing = True
        else:
            number = -10 - k
            kinds[number] = kind
            triangles = filling(points, loop)
            added.append(np.column_stack([triangles, np.full(len(triangles), -1)]))
            numbers += [number] * len(triangles)
            why = f": {clear[1]}" if clear and not asked else ""
            report.remarks.append(f"open edge {told[-1]}, closed as {kind}{why}")
    if missing:
        raise OPEN_BAG(place=place, why="its open edges are " + "; ".join(told))
    more = np.concatenate(added)
    none = np.full(len(more), -1, dtype=np.int64)
    return (
        np.concatenate([cells, more]), np.concatenate([own, more]), np.concatenate([rows, none]),
        np.concatenate([part, numbers]), kinds,
    )  # fmt: skip


def _inside_out(points: np.ndarray, cells: np.ndarray, report: Report) -> np.ndarray:
    """Cells of pieces whose volume is negative, (cells,) bool."""
    piece = pieces(cells, len(points))
    out = np.zeros(len(cells), dtype=bool)
    for one, (volume, ball) in volumes(points, cells, piece).items():
        if abs(volume) < FLAT * ball:
            report.remarks.append("a piece of the bag lies flat: its normals are those of most of its shells")
        elif volume < 0.0:
            out |= piece == one
    return out


def _numbered(part: np.ndarray) -> np.ndarray:
    """Numbers as the mesh has them: those of the deck, virtual parts behind them."""
    top = max(int(part.max()), 0)
    return np.where(part >= 0, part, top - part)


def _named(model: Model, part: np.ndarray):
    """Deck number, number in the mesh and name of each part."""
    taken: set[str] = set()
    numbers = _numbered(part)
    for deck in np.unique(part).tolist():
        title = model.parts[deck].title if deck in model.parts else ""
        name = plain_name(title) or (f"part_{deck}" if deck >= 0 else f"edge_{abs(deck) - 10}")
        if deck == -1:
            name = "segments"
        name = f"{name}_{deck}" if name in taken and deck >= 0 else name
        taken.add(name)
        yield deck, int(numbers[np.argmax(part == deck)]), name


def plain_name(title: str) -> str:
    """A title as a name that a case may use; empty if nothing of it is left."""
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", title):
        return title
    word = re.sub(r"[^A-Za-z0-9]+", "_", title).strip("_")[:30].lower()
    return word if re.match(r"[a-z]", word) else ""
