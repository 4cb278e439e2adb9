"""What became of each field of a deck: a row each, as import.md for people and import.json for programs."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

from billow.decks.block import shown
from billow.decks.cards import Field
from billow.decks.fields import DEFAULTS, TARGETS

MAPPED, APPROXIMATED, IGNORED, REFUSED = "mapped", "approximated", "ignored", "refused"
_MEANING = {
    MAPPED: "the case says the same",
    APPROXIMATED: "the case says nearly the same; the note says how far",
    IGNORED: "without effect in Billow; the note says why",
    REFUSED: "the deck means something that a case cannot say; the note says what to do",
}


@dataclass(frozen=True)
class Row:
    """field: KEYWORD.NAME. place: file:line. deck: text of the field. si: what it is in the case. key: of the case."""

    field: str
    place: str
    deck: str
    si: str
    key: str
    status: str
    note: str


@dataclass
class Report:
    """rows in the order of the deck. keywords: those that Billow does not read, with how often. remarks: what was done
    to the geometry and how the units were found."""

    rows: dict[tuple[str, str], Row] = field(default_factory=dict)
    fields: list[Field] = field(default_factory=list)
    keywords: dict[str, int] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def take(self, fields: Iterable[Field]) -> None:
        """Fields of which each must end up in a row."""
        self.fields += fields

    def mapped(self, one: Field, si: object = "", key: str | None = None, note: str = "") -> None:
        self._add(one, MAPPED, si, key, note)

    def approximated(self, one: Field, how_far: str, si: object = "", key: str | None = None) -> None:
        self._add(one, APPROXIMATED, si, key, how_far)

    def ignored(self, one: Field, why: str) -> None:
        self._add(one, IGNORED, "", "", why)

    def refused(self, one: Field, what_to_do: str) -> None:
        self._add(one, REFUSED, "", "", what_to_do)

    def _add(self, one: Field, status: str, si: object, key: str | None, note: str) -> None:
        shown = f"{si:.9g}" if isinstance(si, float) else str(si)
        key = TARGETS.get(one.name, "") if key is None else key
        self.rows[one.shown, one.place] = Row(one.shown, one.place, one.text, shown, key, status, note)

    def settled(self, one: Field) -> bool:
        return (one.shown, one.place) in self.rows

    def finish(self) -> None:
        """A row for every field that nobody asked for."""
        for one in self.fields:
            if self.settled(one):
                continue
            try:
                plain = one.number in (0.0, DEFAULTS.get(one.name, 0.0))
            except Exception:  # a name where a number is usual
                plain = False
            self.ignored(one, "blank, zero or its default" if plain else "Billow has nothing that depends on it")
        order = {(one.shown, one.place): k for k, one in enumerate(self.fields)}
        self.rows = dict(sorted(self.rows.items(), key=lambda item: order.get(item[0], -1)))

    def of(self, status: str) -> list[Row]:
        return [row for row in self.rows.values() if row.status == status]

    def write(self, folder: Path, deck: str) -> None:
        """import.json and import.md in a folder."""
        data = {
            "deck": deck,
            "remarks": self.remarks,
            "keywords_not_read": self.keywords,
            "fields": [asdict(row) for row in self.rows.values()],
        }
        (folder / "import.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        lines = [f"# What became of {deck}", "", *(f"- {remark}" for remark in self.remarks), ""]
        for status in (REFUSED, APPROXIMATED, MAPPED, IGNORED):
            rows = self.of(status)
            if rows:
                lines += [f"## {status.capitalize()}: {_MEANING[status]}", ""]
                lines += ["| field | at | deck | case | key | note |", "|---|---|---|---|---|---|"]
                lines += [
                    "| " + " | ".join(map(_cell, (r.field, r.place, r.deck, r.si, r.key, r.note))) + " |" for r in rows
                ]
                lines.append("")
        if self.keywords:
            lines += ["## Keywords that Billow does not read", ""]
            for name, count in self.keywords.items():
                lines.append(f"- {shown(name)}" + (f", {count} times" if count > 1 else ""))
        (folder / "import.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
