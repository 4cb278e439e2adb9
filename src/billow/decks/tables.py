"""The mesh of a deck and what its ids mean: nodes, shells, parts, sets, curves, with the offsets of *INCLUDE_TRANSFORM.

Ids of one kind are kept in dictionaries or sorted arrays; whatever names an id that is not there is refused with the
place of the name.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import Block
from billow.decks.cards import Cards, Field, Table, split, table
from billow.decks.exact_lengths import metres
from billow.decks.fields import known
from billow.decks.keyword_file import Deck
from billow.decks.parameters import Parameters
from billow.decks.units import Units

NOT_THERE = InputError.declare(
    "E-DCK-006",
    "the deck has no {kind} {number}",
    where="{place}",
    why="{who} names it",
    cause="a file that is not included, a misspelt id, or ids that are shifted by an offset",
    remedy="include the file that defines it, or correct the id",
)
TWICE = InputError.declare(
    "E-DCK-007",
    "{kind} {number} is defined twice",
    where="{place}",
    why="the first stands in {first}; which of the two is meant cannot be told",
    cause="a file that is included twice, or two models whose ids overlap",
    remedy="remove one, or shift the ids of one with *INCLUDE_TRANSFORM",
)
NOT_TRANSFORMED = InputError.declare(
    "E-DCK-008",
    "*{keyword} stands in a file that is included with other units or ids",
    where="{place}",
    why="*INCLUDE_TRANSFORM in {included} changes what its fields mean; only meshes, parts and curves are converted",
    cause="an airbag or a material in the transformed file",
    remedy="put that keyword into the main file, in its units and with its ids",
)

NODE = (("nid", 8, "i"), ("x", 16, "f"), ("y", 16, "f"), ("z", 16, "f"), ("tc", 8, "i"), ("rc", 8, "i"))
SHELL = tuple((name, 8, "i") for name in ("eid", "pid", "n1", "n2", "n3", "n4"))
REFERENCE = NODE[:4]
WIDE_REFERENCE = (("nid", 10, "i"), ("x", 20, "f"), ("y", 20, "f"), ("z", 20, "f"))
HELD = {0: "", 1: "x", 2: "y", 3: "z", 4: "xy", 5: "yz", 6: "zx", 7: "xyz"}
"""Directions by codes: TC of *NODE, CON1 and CON2 of *MAT_RIGID."""
_THICKNESS = (*((f"t{k}", 16, "f") for k in range(1, 5)), ("beta", 16, "f"))
_SECOND_LINE = ("THICKNESS", "BETA", "MCID", "OFFSET")
_UNSHIFTED = ("NODE", "ELEMENT_SHELL", "PART", "SECTION_SHELL", "SET", "DEFINE_CURVE", "COMMENT", "TITLE")


@dataclass(frozen=True)
class Nodes:
    """number: sorted ids, (nodes,). points: [unit of the deck], (nodes, 3). texts: the same as bytes, (nodes, 3), None
    if they come from no text.
    scale: factor of each on its texts, from *INCLUDE_TRANSFORM. held: whether each translation is constrained, (nodes,
    3).
    place: where a table begins, by row."""

    number: np.ndarray
    points: np.ndarray
    texts: np.ndarray | None
    scale: np.ndarray
    held: np.ndarray

    def metres(self, rows: np.ndarray, units: Units) -> np.ndarray:
        """Coordinates of some nodes [m], (n, 3)."""
        texts = None if self.texts is None else self.texts[rows]
        return metres(texts, self.points[rows], self.scale[rows], units)

    def rows(self, numbers: np.ndarray, who: str, place: str, kind: str = "node") -> np.ndarray:
        """Row of each node id. Raises InputError E-DCK-006."""
        return find(self.number, numbers, kind, who, place)


def find(sorted_ids: np.ndarray, numbers: np.ndarray, kind: str, who: str, place: str) -> np.ndarray:
    """Index of each id. Raises InputError E-DCK-006."""
    rows = np.searchsorted(sorted_ids, numbers)
    rows = np.minimum(rows, max(len(sorted_ids) - 1, 0))
    missing = sorted_ids[rows] != numbers if len(sorted_ids) else np.ones(np.shape(numbers), bool)
    if np.any(missing):
        absent = int(np.asarray(numbers)[missing].ravel()[0])
        raise NOT_THERE(kind=kind, number=absent, who=who, place=place)
    return rows


@dataclass(frozen=True)
class Shells:
    """number, part: (shells,). corners: node ids (shells, 4), -1 last for triangles. beta: angle [deg] of the material,
    (shells,). thickness: [unit of the deck] or 0, (shells,). place: file and line of each, as (file, line)."""

    number: np.ndarray
    part: np.ndarray
    corners: np.ndarray
    beta: np.ndarray
    thickness: np.ndarray
    file: np.ndarray
    line: np.ndarray

    def place(self, row: int) -> str:
        return f"{self.file[row]}:{self.line[row]}"


@dataclass(frozen=True)
class Part:
    number: int
    title: str
    section: int
    material: int
    place: str


@dataclass(frozen=True)
class DeckCurve:
    """points: (n, 2), offsets and scales applied, in the units of the deck."""

    number: int
    points: np.ndarray
    title: str
    place: str


@dataclass
class Model:
    """What a deck defines by id. used: names of keywords that something here has read."""

    deck: Deck
    used: set[str] = field(default_factory=set)

    def __post_init__(self):
        for block in self.deck.blocks:
            moved = [t for t in block.transforms if any(t.offsets.values()) or t.factors != (1.0, 1.0, 1.0)]
            plain = any(block.is_a(name) for name in _UNSHIFTED)
            if moved and not plain:
                raise NOT_TRANSFORMED(keyword=block.name, place=block.place, included=moved[0].place)

    def all(self, *names: str) -> list[Block]:
        found = self.deck.all(*names)
        self.used |= {block.name for block in found}
        return found

    @cached_property
    def nodes(self) -> Nodes:
        tables = self._node_tables()
        ids = [t["nid"] + shift(t.block, "node") for t in tables]
        if not ids:
            empty = np.empty((0, 3))
            return Nodes(np.empty(0, np.int64), empty, empty.astype("S1"), np.empty(0), empty.astype(bool))
        numbers = np.concatenate(ids)
        order = np.argsort(numbers, kind="stable")
        scale = np.concatenate([np.full(len(t), length_factor(t.block)) for t in tables])
        points = np.concatenate([np.column_stack([t[c] for c in "xyz"]) for t in tables]) * scale[:, None]
        texts = np.concatenate([np.column_stack([t.texts[c] for c in "xyz"]) for t in tables])
        held = np.concatenate([self._held(t) for t in tables])
        sorted_ids = numbers[order]
        twice = np.flatnonzero(sorted_ids[1:] == sorted_ids[:-1])
        if len(twice):
            same = (points[order[twice]] == points[order[twice + 1]]).all(axis=1)
            if not same.all():
                k = twice[np.argmin(same)]
                places = [f"{t.block.file}:{line}" for t in tables for line in t.line]
                first, second = places[order[k]], places[order[k + 1]]
                raise TWICE(kind="node", number=int(sorted_ids[k]), place=second, first=first)
            order = order[np.concatenate([[True], sorted_ids[1:] != sorted_ids[:-1]])]
        return Nodes(numbers[order], points[order], texts[order], scale[order], held[order])

    def _node_tables(self) -> list[Table]:
        """Tables of nodes: nid, x, y, z, the texts of the last three, and what `_held` reads."""
        blocks = [block for block in self.all("NODE") if block.name == "NODE"]
        return [table(self.deck.parameters, block, NODE, keep=("x", "y", "z")) for block in blocks]

    def _held(self, nodes: Table) -> np.ndarray:
        """Directions in which nodes stand still, (n, 3) bool."""
        ways = [[axis in HELD[code] for axis in "xyz"] for code in range(len(HELD))]
        return np.array(ways)[np.where((nodes["tc"] > 0) & (nodes["tc"] < len(HELD)), nodes["tc"], 0)]

    def _shell_tables(self) -> list[tuple[np.ndarray, ...]]:
        """Fields of `Shells` for each table of shells."""
        return [self._shell_block(block) for block in self.all("ELEMENT_SHELL") if "REFERENCE" not in block.name]

    @cached_property
    def shells(self) -> Shells:
        found = self._shell_tables()
        if not found:
            no = np.empty(0, np.int64)
            return Shells(no, no, no.reshape(0, 4), np.empty(0), np.empty(0), np.empty(0, object), no)
        shells = Shells(*(np.concatenate(arrays) for arrays in zip(*found, strict=True)))
        order = np.argsort(shells.number, kind="stable")
        twice = np.flatnonzero(np.diff(shells.number[order]) == 0)
        if len(twice):
            first, second = order[twice[0]], order[twice[0] + 1]
            raise TWICE(
                kind="shell", number=int(shells.number[first]), place=shells.place(second), first=shells.place(first)
            )
        return shells

    def _shell_block(self, block: Block) -> tuple[np.ndarray, ...]:
        options = block.name.removeprefix("ELEMENT_SHELL").split("_")
        lines = 1 + any(option in _SECOND_LINE for option in options)
        cells = table(self.deck.parameters, block, SHELL, every=lines)
        corners = corners_of(cells)
        beta, thick = np.zeros(len(cells)), np.zeros(len(cells))
        if lines == 2:
            second = table(self.deck.parameters, block, _THICKNESS, every=2, first=1)
            if len(second) < len(cells):
                place = cells.place(len(cells) - 1)
                raise NOT_THERE(kind="second line of shell", number=int(cells["eid"][-1]), who=block.name, place=place)
            thick, beta = second["t1"] * length_factor(block), second["beta"]
        file = np.full(len(cells), block.file, dtype=object)
        numbers, part = cells["eid"] + shift(block, "element"), cells["pid"] + shift(block, "part")
        return numbers, part, corners, beta, thick, file, cells.line

    @cached_property
    def parts(self) -> dict[int, Part]:
        found: dict[int, Part] = {}
        for block in self.all("PART"):
            if block.name not in ("PART", "PART_INERTIA", "PART_CONTACT", "PART_PRINT"):
                continue
            cards = Cards(self.deck.parameters, block)
            while cards.left:
                title = cards.text()
                place = cards.place
                card = cards.card("part", "PID SECID MID EOSID HGID GRAV ADPOPT TMID")
                number = card["PID"].whole + shift(block, "part")
                section, material = card["SECID"].whole, card["MID"].whole
                section += shift(block, "section") if section else 0
                material += shift(block, "material") if material else 0
                if number in found:
                    raise TWICE(kind="part", number=number, place=place, first=found[number].place)
                found[number] = Part(number, title, section, material, place)
                if block.name != "PART":  # its further cards are not those of a second part
                    break
        return found

    @cached_property
    def thicknesses(self) -> dict[int, tuple[float, int, Field]]:
        """Of *SECTION_SHELL by id: T1 [unit of the deck], ELFORM, and the field."""
        found = {}
        for block in self.all("SECTION_SHELL"):
            cards = Cards(self.deck.parameters, block)
            while cards.left >= 2 + has_title(block):
                if has_title(block):
                    cards.text()
                head = cards.card("section", "SECID ELFORM SHRF NIP PROPT QR ICOMP SETYP")
                thick = cards.card("thickness", "T1 T2 T3 T4 NLOC MAREA IDOF EDGSET")
                value = thick["T1"].number * length_factor(block)
                found[head["SECID"].whole + shift(block, "section")] = value, head["ELFORM"].whole, thick["T1"]
                if head["ICOMP"].whole:  # cards of angles follow
                    break
        return found

    @cached_property
    def curves(self) -> dict[int, DeckCurve]:
        found: dict[int, DeckCurve] = {}
        for block in self.all("DEFINE_CURVE"):
            if block.name not in ("DEFINE_CURVE", "DEFINE_CURVE_TITLE"):
                continue
            cards = Cards(self.deck.parameters, block)
            title = cards.text() if has_title(block) and cards.left else ""
            place = cards.place
            head = cards.card("curve", "LCID SIDR SFA SFO OFFA OFFO DATTYP LCINT")
            scale = [head[name].number or 1.0 for name in ("SFA", "SFO")]
            offset = [head[name].number for name in ("OFFA", "OFFO")]
            points = []
            while cards.left:
                x, y = cards.card("point", "A1 O1", widths=(20, 20)).values()
                points.append(((x.number + offset[0]) * scale[0], (y.number + offset[1]) * scale[1]))
            curve_id = head["LCID"].whole + shift(block, "curve")
            if curve_id in found:
                raise TWICE(kind="curve", number=curve_id, place=place, first=found[curve_id].place)
            found[curve_id] = DeckCurve(curve_id, np.array(points).reshape(-1, 2), title, place)
        return found

    def material_of(self, part: int) -> tuple[str, Block] | None:
        """Keyword, as `fields` knows it, and block of a part's material; None if the deck has none."""
        if part not in self.parts or not self.parts[part].material:
            return None
        for block in self.all("MAT"):
            cards = Cards(self.deck.parameters, block)
            if block.name.endswith("_TITLE") and cards.left:
                cards.text()
            if cards.left and "ADD" not in block.name:
                number = cards.card("id", "MID")["MID"]
                try:
                    same = number.whole + shift(block, "material") == self.parts[part].material
                except InputError:  # a material that is named by a text
                    continue
                if same:
                    return known(block.name) or block.name, block
        return None

    def curve(self, named: Field) -> DeckCurve:
        """The curve that a field names, whatever its sign. Raises InputError E-DCK-006."""
        wanted = abs(named.whole)
        if wanted not in self.curves:
            raise NOT_THERE(kind="curve", number=wanted, who=named.shown, place=named.place)
        return self.curves[wanted]

    def set_of(self, kind: str, wanted: int, who: str, place: str) -> np.ndarray:
        """Ids in a *SET_PART or *SET_NODE. Raises InputError E-DCK-006."""
        for block in self.all(f"SET_{kind}"):
            cards = titled(self.deck.parameters, block)
            if not cards.left:
                continue
            widths = (10,) * 8
            head = [self._whole(text, cards.place) for text in _cells(self.deck.parameters, cards, widths)]
            if head[0] + shift(block, "set") != wanted:
                continue
            by = shift(block, kind.lower())
            ids: list[int] = []
            while cards.left:
                at = cards.place
                row = [self._whole(text, at) for text in _cells(self.deck.parameters, cards, widths) if text]
                if "GENERATE" in block.name:
                    for a, b in zip(row[::2], row[1::2], strict=False):
                        if a and b - a > 10_000_000:
                            raise NOT_THERE(kind=f"{kind.lower()} up to", number=b, who=block.name, place=at)
                        ids += [i + by for i in range(a, b + 1) if a]
                elif "ADD" in block.name:
                    for other in row:
                        if other and other + shift(block, "set") != wanted:
                            ids += self.set_of(kind, other + shift(block, "set"), block.name, at).tolist()
                else:
                    ids += [i + by for i in row if i]
            return np.array(list(dict.fromkeys(ids)), np.int64)
        raise NOT_THERE(kind=f"{kind.lower()} set", number=wanted, who=who, place=place)

    def segments(self, wanted: int, who: str, place: str) -> tuple[np.ndarray, str]:
        """Corners (n, 4) of a *SET_SEGMENT, -1 last for triangles, and its place. Raises InputError E-DCK-006."""
        for block in self.all("SET_SEGMENT"):
            cards = titled(self.deck.parameters, block)
            if not cards.left:
                continue
            at = cards.place
            number_ = self._whole(_cells(self.deck.parameters, cards, (10,) * 5)[0], at) + shift(block, "set")
            if number_ != wanted:
                continue
            skip = 2 if has_title(block) else 1
            spec = tuple((name, 10, "i") for name in ("n1", "n2", "n3", "n4"))
            rows = table(self.deck.parameters, rest(block, skip), spec)
            return corners_of(rows), at
        raise NOT_THERE(kind="segment set", number=wanted, who=who, place=place)

    @staticmethod
    def _whole(text: str, place: str) -> int:
        return Field("SET", "id", text, place).whole


def _cells(parameters: Parameters, cards: Cards, widths: tuple[int, ...]) -> list[str]:
    place, form = cards.place, cards.block.form
    return split(parameters, form, cards.raw("ids"), place, widths) or [""]


def has_title(block: Block) -> bool:
    return block.name.endswith("_TITLE") or "_TITLE_" in block.name


def titled(parameters: Parameters, block: Block) -> Cards:
    """The cards of a block, its title read."""
    cards = Cards(parameters, block)
    if has_title(block) and cards.left:
        cards.text()
    return cards


def shift(block: Block, kind: str) -> int:
    """What *INCLUDE_TRANSFORM adds to ids of a kind."""
    return sum(t.offsets.get(kind, 0) for t in block.transforms)


def length_factor(block: Block) -> float:
    factor = 1.0
    for transform in block.transforms:
        factor *= transform.factors[2]
    return factor


def corners_of(cells: Table) -> np.ndarray:
    """Node ids (n, 4) of shells or segments, -1 last for triangles: those whose fourth node is 0 or the third. Raises
    InputError E-DCK-004 for ids below 1."""
    corners = np.column_stack([cells[f"n{k}"] for k in range(1, 5)])
    odd = (corners < [1, 1, 1, 0]).any(axis=1)
    if odd.any():
        row = int(np.argmax(odd))
        text = ", ".join(map(str, corners[row].tolist()))
        named = Field(cells.block.name, "N1 to N4", text, cells.place(row))
        raise named.bad("nodes have numbers from 1 on; only the fourth may be 0")
    corners[(corners[:, 3] == 0) | (corners[:, 3] == corners[:, 2]), 3] = -1
    return np.where(corners >= 0, corners + shift(cells.block, "node"), -1)


def rest(block: Block, skip: int) -> Block:
    """The block without its first lines, comments not counted."""
    if not skip:
        return block
    left = list(block.lines())[skip:]
    if not left:
        return replace(block, body=b"")
    lines = block.body.split(b"\n")
    first = left[0][0] - block.line - 1
    return replace(block, body=b"\n".join(lines[first:]), line=left[0][0] - 1)
