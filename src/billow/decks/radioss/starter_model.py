"""What a starter deck defines by number: nodes, shells, parts, thicknesses, functions, surfaces, groups of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from billow.decks.block import Block
from billow.decks.cards import Cards, Field, Table, table
from billow.decks.radioss.columns import CARDS, columns
from billow.decks.radioss.starter_file import StarterDeck, kind_of, words
from billow.decks.tables import NOT_THERE, TWICE, DeckCurve, Model, Part, corners_of, rest

NODE = (("nid", 10, "i"), ("x", 20, "f"), ("y", 20, "f"), ("z", 20, "f"))
_ANGLE = ((".", 10, "f"), ("phi", 20, "f"), ("thick", 20, "f"))
SHELL = (*((name, 10, "i") for name in ("eid", "n1", "n2", "n3", "n4")), *_ANGLE)
SH3N = (*((name, 10, "i") for name in ("eid", "n1", "n2", "n3")), (".", 10, "f"), *_ANGLE)
SEGMENT = tuple((name, 10, "i") for name in ("sid", "n1", "n2", "n3", "n4"))
FABRICS = {"LAW19": "LAW19", "FABRI": "LAW19", "LAW58": "LAW58", "FABR_A": "LAW58"}
THIN = {"TYPE1", "SHELL", "TYPE9", "SH_ORTH", "TYPE16", "SH_FABR"}
"""Properties of shells that are read."""
GROUPS = {"GRSHEL": "SHEL", "GRSH3N": "SH3N"}
"""Groups of elements, and what a list of elements is called in one."""
RANGES = ("GENE", "GEN_INCR")
"""Kinds of group that hold ranges of ids."""
DEEPEST = 16
"""Groups within groups."""
FINE = 16
"""Parts into which an interval of a smooth function is cut: 0.3 % of its rise at most."""


@dataclass
class StarterModel(Model):
    """As the model of a deck of LS-DYNA, so that the same code makes a bag of it."""

    deck: StarterDeck

    def find(self, *wanted: str) -> list[Block]:
        found = self.deck.find(*wanted)
        self.used |= {block.name for block in found}
        return found

    def one(self, number: int, who: Field, *wanted: str) -> Block:
        """The option of that number. Raises InputError E-DCK-006."""
        for block in self.find(*wanted):
            if number_of(block) == number:
                return block
        raise NOT_THERE(kind=f"/{'/'.join(wanted)}", number=number, who=who.shown, place=who.place)

    def cards(self, block: Block) -> Cards:
        """The cards of an option, its title read."""
        cards = Cards(self.deck.parameters, block)
        if cards.left:
            cards.text()
        return cards

    def _node_tables(self) -> list[Table]:
        return [table(self.deck.parameters, block, NODE, keep=("x", "y", "z")) for block in self.find("NODE")]

    def _held(self, nodes: Table) -> np.ndarray:
        ways = np.zeros((len(nodes), 3), bool)
        for held, ids in self.constraints:
            ways[np.isin(nodes["nid"], ids)] |= held[:3]
        return ways

    def _shell_tables(self) -> list[tuple[np.ndarray, ...]]:
        return [
            self._shells(block, spec) for kind, spec in (("SHELL", SHELL), ("SH3N", SH3N)) for block in self.find(kind)
        ]

    def _shells(self, block: Block, spec) -> tuple[np.ndarray, ...]:
        cells = table(self.deck.parameters, block, spec)
        if spec is SH3N:
            cells = with_fourth(cells)
        file = np.full(len(cells), block.file, dtype=object)
        part = np.full(len(cells), number_of(block), np.int64)
        return cells["eid"], part, corners_of(cells), cells["phi"], cells["thick"], file, cells.line

    @cached_property
    def parts(self) -> dict[int, Part]:
        found: dict[int, Part] = {}
        for block in self.find("PART"):
            cards = Cards(self.deck.parameters, block)
            title = cards.text() if cards.left else ""
            f = cards.card("part", "prop_ID mat_ID subset_ID")
            number = number_of(block)
            if number in found:
                raise TWICE(kind="part", number=number, place=block.place, first=found[number].place)
            found[number] = Part(number, title, f["prop_ID"].whole, f["mat_ID"].whole, block.place)
        return found

    @cached_property
    def thicknesses(self) -> dict[int, tuple[float, int, Field]]:
        found = {}
        for number, f in self.properties.items():
            factor = self.deck.units_of(self.property_blocks[number]).length / self.deck.units.length
            found[number] = f["Thick"].number * factor, 0, f["Thick"]
        return found

    @cached_property
    def property_blocks(self) -> dict[int, Block]:
        return {number_of(b): b for b in self.find("PROP") if len(words(b)) > 2 and kind_of(b) in THIN}

    @cached_property
    def properties(self) -> dict[int, dict[str, Field]]:
        """Fields of properties of shells by number."""
        found = {}
        for number, block in self.property_blocks.items():
            cards, kind = self.cards(block), kind_of(block)
            names = ["flags", "hourglass", "thickness"]
            if kind in ("TYPE9", "SH_ORTH"):
                names.append("direction")
            elif kind in ("TYPE16", "SH_FABR"):
                names += ["fabric direction", "layer"]
            fields: dict[str, Field] = {}
            for name in names:
                read = cards.card if name == "thickness" else cards.optional
                texts, widths = columns(CARDS["PROP"][name])
                fields |= read(name, texts, "", widths)
            found[number] = fields
        return found

    @cached_property
    def curves(self) -> dict[int, DeckCurve]:
        moved = {}
        for block in self.find("MOVE_FUNCT"):
            f = self.cards(block).optional("move", "Ascale Fscale Ashift Fshift", "", (20,) * 4)
            moved[number_of(block)] = [
                f["Ascale"].number or 1.0, f["Fscale"].number or 1.0, f["Ashift"].number, f["Fshift"].number
            ]  # fmt: skip
        found: dict[int, DeckCurve] = {}
        for block in [*self.find("FUNCT"), *self.find("FUNCT_SMOOTH")]:
            cards = Cards(self.deck.parameters, block)
            title = cards.text() if cards.left else ""
            smooth = words(block)[0] == "FUNCT_SMOOTH"
            scales = cards.card("scales", "Ascalex Fscaley Ashiftx Fshifty", widths=(20,) * 4) if smooth else {}
            place, points = cards.place, []
            while cards.left:
                points.append([one.number for one in cards.card("point", "X Y", widths=(20, 20)).values()])
            number = number_of(block)
            if number in found:
                raise TWICE(kind="function", number=number, place=block.place, first=found[number].place)
            array = np.array(points).reshape(-1, 2)
            if smooth:
                a, f, da, df = (one.number for one in scales.values())
                array = smoothed(array * [a or 1.0, f or 1.0] + [da, df])
            if number in moved:
                a, f, da, df = moved[number]
                array = array * [a, f] + [da, df]
            found[number] = DeckCurve(number, array, title, place)
        return found

    def law_of(self, part: int) -> tuple[str, Block] | None:
        """Law and block of a part's material."""
        number = self.parts[part].material if part in self.parts else 0
        block = next((b for b in self.find("MAT") if number and number_of(b) == number), None)
        return None if block is None else (FABRICS.get(kind_of(block), kind_of(block)), block)

    def material_of(self, part: int) -> tuple[str, Block] | None:
        """In LS-DYNA's words: what is fabric, and parts whose nodes all stand still as rigid."""
        found = self.law_of(part)
        if found is None:
            return None
        law, block = found
        if law in FABRICS.values():
            return "MAT_FABRIC", block
        corners = self.shells.corners[self.shells.part == part]
        if len(corners) and np.isin(corners[corners >= 0], self.still).all():
            return "MAT_RIGID", block
        return law, block

    @cached_property
    def constraints(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Translations and rotations (6,) that each /BCS holds, and the ids of its nodes."""
        found = []
        for block in self.find("BCS"):
            if len(words(block)) != 2:
                continue
            texts, widths = columns(CARDS["BCS"]["bcs"])
            f = self.cards(block).card("bcs", texts, widths=widths)
            if not f["skew_ID"].whole:
                found.append((directions(f["Trarot"]), self.group(f["grnd_ID"].whole, f["grnd_ID"])))
        return found

    @cached_property
    def still(self) -> np.ndarray:
        """Ids of nodes whose translations are all fixed, by one /BCS, sorted."""
        return np.unique(
            np.concatenate([np.empty(0, np.int64), *(ids for ways, ids in self.constraints if ways[:3].all())])
        )

    def group(self, number: int, who: Field, depth: int = 0) -> np.ndarray:
        """Ids of the nodes of a /GRNOD. Raises InputError E-DCK-006."""
        block = self.one(number, who, "GRNOD")
        kind, ids = kind_of(block), self._numbers(block)
        if kind in ("NODE", "NODENS"):
            return ids
        if kind in RANGES:
            return self._ranges(block, self.nodes.number)
        if kind == "GRNOD" and depth < DEEPEST:
            return np.unique(np.concatenate([self.group(abs(int(i)), who, depth + 1) for i in ids]))
        if kind == "SURF":
            parts, segments = self._members(ids, who)
            corners = np.concatenate([self.shells.corners[np.isin(self.shells.part, parts)], segments])
        elif kind in GROUPS:
            rows = np.zeros(len(self.shells.part), bool)
            for i in np.abs(ids).tolist():
                rows |= self._elements(int(i), kind, who)
            corners = self.shells.corners[rows]
        else:
            parts = self._parts_by(kind, ids)
            if parts is None:
                raise NOT_THERE(kind="readable group of nodes", number=number, who=who.shown, place=who.place)
            corners = self.shells.corners[np.isin(self.shells.part, parts)]
        return np.unique(corners[corners >= 0])

    def _parts_by(self, kind: str, ids: np.ndarray) -> np.ndarray | None:
        """Parts by their own number, subset, material or property; None for another kind. ids: negative ones too."""
        ids = np.abs(ids)
        if kind == "PART":
            return ids
        if kind == "SUBSET":
            held = set().union(*(self._below(int(i)) for i in ids.tolist()))
            return np.array([n for n, subset in self.subset_of.items() if subset in held], np.int64)
        if kind in ("MAT", "PROP"):
            key = "material" if kind == "MAT" else "section"
            return np.array([n for n, p in self.parts.items() if getattr(p, key) in ids], np.int64)
        return None

    @cached_property
    def subset_of(self) -> dict[int, int]:
        """Number of the /SUBSET of each part, 0 if it has none."""
        found = {}
        for block in self.find("PART"):
            cards = self.cards(block)
            found[number_of(block)] = cards.optional("part", "prop_ID mat_ID subset_ID")["subset_ID"].whole
        return found

    def _below(self, subset: int, depth: int = 0) -> set[int]:
        """A subset and all below it."""
        found = {subset}
        for block in self.find("SUBSET"):
            if number_of(block) == subset and depth < DEEPEST:
                for child in self._numbers(block).tolist():
                    found |= self._below(int(child), depth + 1)
        return found

    def _elements(self, number: int, group: str, who: Field, depth: int = 0) -> np.ndarray:
        """Shells of a /GRSHEL, or triangles of a /GRSH3N, (shells,) bool. Raises InputError E-DCK-006."""
        block = self.one(number, who, group)
        kind, shells = kind_of(block), self.shells
        if kind in RANGES:
            return np.isin(shells.number, self._ranges(block, shells.number))
        ids = self._numbers(block)
        if kind == GROUPS[group]:
            return np.isin(shells.number, ids)
        if kind == group and depth < DEEPEST:
            rows = np.zeros(len(shells.part), bool)
            for i in np.abs(ids).tolist():
                rows |= self._elements(int(i), group, who, depth + 1)
            return rows
        parts = self._parts_by(kind, ids)
        if parts is None:
            raise NOT_THERE(kind=f"readable /{group}", number=number, who=who.shown, place=who.place)
        return np.isin(shells.part, parts) & ((shells.corners[:, 3] < 0) == (group == "GRSH3N"))

    def surface(self, number: int, who: Field) -> tuple[np.ndarray, np.ndarray]:
        """Parts, and corners (n, 4) of segments, of a /SURF; segments that are all shells of some parts are those
        parts. Raises InputError E-DCK-006."""
        parts, segments = self._members(np.array([number]), who)
        if not len(segments):
            return parts, segments
        known = {key: row for row, key in enumerate(map(tuple, np.sort(self.shells.corners, axis=1).tolist()))}
        rows = np.array([known.get(tuple(c), -1) for c in np.sort(segments, axis=1).tolist()])
        shells = np.unique(np.concatenate([rows[rows >= 0], np.flatnonzero(np.isin(self.shells.part, parts))]))
        whole = np.unique(self.shells.part[shells])
        if (rows >= 0).all() and np.isin(self.shells.part, whole).sum() == len(shells):
            return whole, segments[:0]
        return parts, segments

    def _members(self, surfaces: np.ndarray, who: Field, depth: int = 0) -> tuple[np.ndarray, np.ndarray]:
        parts, segments = [np.empty(0, np.int64)], [np.empty((0, 4), np.int64)]
        for number in np.abs(surfaces).tolist():
            block = self.one(int(number), who, "SURF")
            kind = kind_of(block)
            if kind == "SEG":
                segments.append(corners_of(table(self.deck.parameters, rest(block, 1), SEGMENT)))
                continue
            ids = self._numbers(block)
            found = self._parts_by(kind, ids)
            if found is not None:
                parts.append(found)
            elif kind in GROUPS:
                segments += [self.shells.corners[self._elements(int(i), kind, who)] for i in np.abs(ids).tolist()]
            elif kind == "SURF" and depth < DEEPEST:
                more = self._members(ids, who, depth + 1)
                parts.append(more[0])
                segments.append(more[1])
            else:
                why = f"readable surface (it is a {block.shown})"
                raise NOT_THERE(kind=why, number=int(number), who=who.shown, place=who.place)
        return np.unique(np.concatenate(parts)), np.concatenate(segments)

    def _ranges(self, block: Block, known: np.ndarray) -> np.ndarray:
        """Those of the known ids that lie in ranges: first, last and step of each line."""
        cards, found = self.cards(block), np.zeros(len(known), bool)
        while cards.left:
            first, last, step = (one.whole for one in cards.card("range", "first last step").values())
            found |= (known >= first) & (known <= last) & ((known - first) % max(step, 1) == 0)
        return known[found]

    def _numbers(self, block: Block) -> np.ndarray:
        cards, ids = self.cards(block), []
        while cards.left:
            row = cards.card("ids", " ".join(f"item_ID{k}" for k in range(1, 11)))
            ids += [one.whole for one in row.values() if not one.is_blank]
        return np.array([i for i in ids if i], np.int64)


def smoothed(points: np.ndarray) -> np.ndarray:
    """Points (n, 2) of /FUNCT_SMOOTH, whose slope and curvature are 0 at each, with points between."""
    share = np.linspace(0.0, 1.0, FINE, endpoint=False)
    risen = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    way = np.stack([share, risen], axis=1)
    inner = [a + way * (b - a) for a, b in pairwise(points)]
    return np.concatenate([*inner, points[-1:]]) if len(points) else points


def directions(trarot: Field) -> np.ndarray:
    """Translations and rotations that codes such as 111 000 hold, (6,) bool."""
    return np.array([letter == "1" for letter in trarot.text.replace(" ", "")[:6].ljust(6, "0")])


def number_of(block: Block) -> int:
    """Of an option: the first word of digits; 0 if it has none."""
    return next((int(word) for word in words(block)[1:] if word.isdecimal()), 0)


def with_fourth(cells: Table) -> Table:
    """A table of triangles with a fourth node of 0."""
    cells.columns["n4"] = np.zeros(len(cells), np.int64)
    return cells
