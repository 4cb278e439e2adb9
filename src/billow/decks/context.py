"""What all translators of cards share: the model of the deck, its units, the report and the draft of the case."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.decks.block import Block
from billow.decks.cards import Cards, Field
from billow.decks.draft import Said, plain, said
from billow.decks.fields import CARDS, known
from billow.decks.report import Report
from billow.decks.tables import Model, has_title
from billow.decks.units import Units
from billow.geometry.mesh_file import CellMesh

SHORT_CURVE = InputError.declare(
    "E-DCK-013",
    "the curve {number} cannot be used as {use}",
    where="{place}",
    cause="a curve of another kind, or points in the wrong order",
    remedy="correct the curve: two points at least, abscissae that rise",
)
SHIFT = 1e-6
"""By which a repeated abscissa is moved [s]: a step."""


@dataclass
class Context:
    """tables: the draft of the case. curves: CSV files to write, name -> text; meshes: of
    obstacles, likewise. airbag: what its cards said of the bag,
    once they are read."""

    model: Model
    units: Units
    report: Report
    tables: dict[str, Any] = field(default_factory=dict)
    curves: dict[str, str] = field(default_factory=dict)
    meshes: dict[str, CellMesh] = field(default_factory=dict)
    airbag: Any = None

    def cards(self, block: Block) -> Cards:
        """The cards of a block, its title and id read."""
        cards = Cards(self.model.deck.parameters, block)
        if (has_title(block) or "_ID" in block.name) and cards.left:
            cards.text()
        return cards

    def card(self, cards: Cards, card: str, part: str = "", optional: bool = False) -> dict[str, Field]:
        """A card as `fields.CARDS` describes it; all its fields will be in the report."""
        names = CARDS[known(cards.block.name)][card]
        found = cards.optional(card, names, part) if optional else cards.card(card, names, part)
        self.report.take(found.values())
        return found

    @property
    def end(self) -> float:
        """Of the run [s]."""
        return plain(self.tables.get("run", {})).get("end_time", 0.05)

    def si(self, one: Field, dimension: str) -> float:
        return self.units.si(one.number, dimension)

    def put(self, key: str, one: Field, dimension: str, default: float = 0.0) -> float:
        """A number into the draft and the report; key: dotted."""
        value = self.si(one, dimension) if not one.is_blank else default
        self.set(key, value, one)
        self.report.mapped(one, value, key)
        return value

    def set(self, key: str, value: Any, one: Field | str) -> None:
        *tables, last = key.split(".")
        place = self.tables
        for name in tables:
            place = place.setdefault(name, {})
        place[last] = value if isinstance(value, Said) else said(value, one)

    def curve(self, one: Field, x: str, y: str, use: str, axis: str = "time") -> dict[str, list[float]]:
        """A curve of the deck in SI, as a case has it. x, y: dimensions. Raises InputError E-DCK-006, E-DCK-013."""
        points, place, number = self.points(one, x, y)
        if len(points) < 2:
            raise SHORT_CURVE(number=number, use=use, place=place, why=f"it has {len(points)} points")
        at = points[:, 0].copy()
        step = SHIFT if axis == "time" else 1e-6 * max(float(np.ptp(at)), 1e-300)
        for k in range(1, len(at)):
            if at[k] < points[k - 1, 0]:
                raise SHORT_CURVE(number=number, use=use, place=place, why=f"{points[k, 0]:g} follows {at[k - 1]:g}")
            if at[k] <= at[k - 1]:
                at[k] = at[k - 1] + step
                self.report.remarks.append(f"{place}: curve {number} repeats {at[k - 1]:g}; moved by {step:.3g}")
        return {axis: at.tolist(), "value": points[:, 1].tolist()}

    def points(self, one: Field, x: str, y: str) -> tuple[np.ndarray, str, int]:
        """Points of a curve in SI, (n, 2), its place and number."""
        found = self.model.curve(one)
        rows = [[self.units.si(a, x), self.units.si(b, y)] for a, b in found.points.tolist()]
        return np.array(rows).reshape(-1, 2), found.place, found.number

    def vector(self, number: int) -> np.ndarray:
        """Direction of a *DEFINE_VECTOR, zero if there is none."""
        for block in self.model.all("DEFINE_VECTOR"):
            cards = self.cards(block)
            while cards.left:
                f = cards.card("vector", "VID XT YT ZT XH YH ZH CID")
                if f["VID"].whole == number:
                    return np.array([f[n + "H"].number - f[n + "T"].number for n in "XYZ"])
        return np.zeros(3)
