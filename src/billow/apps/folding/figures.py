"""Pictures of a folded bag: the stack across its fold lines, step by step."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from billow.base.plot_style import png, styled
from billow.geometry.folding.fold_plan import Stage

COLOURS = ("#0072b2", "#d55e00")  # of the two skins of a sheet: front and rear panel, or top and bottom of a stack
POINTS = 6000


def draw_step(stage: Stage, number: int) -> bytes:
    """Section through the stack after a fold, height exaggerated, as PNG."""
    curve, axis = stage.curve, "xy"[stage.across]
    s = np.linspace(curve.pieces[0].begin, curve.pieces[-1].end, POINTS)
    with styled():
        figure = Figure(figsize=(9.2, 3.4), layout="constrained")
        axes = figure.subplots()
        for side, colour in zip((1.0, -1.0), COLOURS, strict=True):
            x, z = curve.place(s, np.full_like(s, side * curve.half))
            axes.plot(1e3 * x, 1e3 * z, color=colour, lw=0.8)
        axes.set(xlabel=f"{axis} from the mouth's axis [mm]", ylabel="height over the middle of what is folded [mm]")
        axes.set_title(f"After fold {number}: section across {axis}, its two skins")
        return png(figure)
