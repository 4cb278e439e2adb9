"""How all figures look, whatever matplotlib is told by its surroundings, and their bytes."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator

import matplotlib
from matplotlib.figure import Figure

INK, GREY, FAINT = "#22303c", "#7b8794", "#e3e8ec"

STYLE = {
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.8,
    "svg.hashsalt": "billow",  # same numbers, same file
}


@contextlib.contextmanager
def styled() -> Iterator[None]:
    """Where a figure is drawn and saved: our style over matplotlib's own defaults, not over those of the user."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


def png(figure: Figure, dpi: int = 140) -> bytes:
    """The figure as PNG; same numbers, same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": "Billow"})
    return buffer.getvalue()
