"""How all figures look (matplotlib settings), and their bytes."""

from __future__ import annotations

import io

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


def png(figure: Figure, dpi: int = 140) -> bytes:
    """The figure as PNG; same numbers, same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": "Billow"})
    return buffer.getvalue()
