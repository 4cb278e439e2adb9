"""*CONTACT as friction of obstacles, and whether layers of fabric are kept apart."""

from __future__ import annotations

import math

from billow.decks.context import Context
from billow.decks.draft import said


def put_contact(context: Context, bag_parts: set[int]) -> None:
    """Friction, and whether layers of fabric are kept apart."""
    report = context.report
    for block in context.model.all("CONTACT"):
        cards = context.cards(block)
        if not cards.left or cards.left < 2:
            continue
        if "MPP" in block.name.split("_"):
            context.card(cards, "mpp")
            if cards.starts_with(b"&"):
                cards.unsign()
                context.card(cards, "more mpp")
        sides = context.card(cards, "sides")
        friction = context.card(cards, "friction")
        scales = context.card(cards, "scales", optional=True)
        for card in ("A", "B", "C"):
            if cards.left:
                context.card(cards, card)
        fs = friction["FS"]
        itself = "SINGLE_SURFACE" in block.name
        for name in ("SSID", "MSID", "SSTYP", "MSTYP"):
            report.ignored(sides[name], "a case keeps all fabric apart from itself and from all obstacles")
        value = min(max(fs.number, 0.0), 2.0)
        if itself:
            context.set("fabric.self_contact", True, f"{block.place} {block.name}")
            if value:
                report.approximated(fs, "friction between layers counts with fabric.self_contact = layers only", value)
                context.set("fabric.friction", value, fs)
            else:
                report.mapped(fs, value, "fabric.friction")
        else:
            report.mapped(fs, value, "obstacles.friction")
            for one in context.tables.get("obstacles", []):
                if one["name"] != "wall":
                    one["friction"] = said(value, fs)
        if friction["FD"].number and not math.isclose(friction["FD"].number, fs.number):
            report.approximated(friction["FD"], "one coefficient of friction: FS")
        for one in scales.values():
            if not one.is_blank:
                report.ignored(one, "contact of a case has a stiffness of its own: obstacles.slope")
