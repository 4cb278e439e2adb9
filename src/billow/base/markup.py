"""What notebooks show: tables as HTML. Texts are escaped, for they come from files of others."""

from __future__ import annotations

import html
from collections.abc import Iterable


def table_of(title: str, rows: Iterable[tuple[str, str]], picture: str = "") -> str:
    """A titled table of two columns, and below it a picture: markup of ours."""
    cells = "".join(
        f'<tr><td style="text-align:left">{html.escape(name)}</td>'
        f'<td style="text-align:left">{html.escape(value)}</td></tr>'
        for name, value in rows
    )
    return f"<b>{html.escape(title)}</b><table>{cells}</table>{picture}"
