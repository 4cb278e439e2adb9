"""Pictures of a folded bag: the stack across its fold lines, step by step."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from billow.base.plot_style import png, styled
from billow.geometry.folding.fold_plan import FoldPlan

COLOURS = ("#0072b2", "#d55e00")  # of the two skins of a sheet: front and rear panel, or top and bottom of a stack
POINTS = 6000


def draw_step(plan: FoldPlan, number: int) -> bytes:
    """Section through the stack after the last fold of a plan, height exaggerated, as PNG; of a tuck the two panels,
    which part beside it."""
    if plan.stages:
        curve, across = plan.stages[-1].curve, plan.stages[-1].across
        low, high, half, place = curve.pieces[0].begin, curve.pieces[-1].end, curve.half, curve.place
    else:
        tuck, across = plan.tuck, plan.tuck.across
        (low, high), half, place = tuck.rims, tuck.half, tuck.section
    s, axis = np.linspace(low, high, POINTS), "xy"[across]
    with styled():
        figure = Figure(figsize=(9.2, 3.4), layout="constrained")
        axes = figure.subplots()
        for side, colour in zip((1.0, -1.0), COLOURS, strict=True):
            x, z = place(s, np.full_like(s, side * half))
            axes.plot(1e3 * x, 1e3 * z, color=colour, lw=0.8)
        axes.set(xlabel=f"{axis} from the mouth's axis [mm]", ylabel="height over the middle of what is folded [mm]")
        axes.set_title(f"After fold {number}: section across {axis}, its two skins")
        return png(figure)
