"""Runs in notebooks: curves by `result.plot`, and the picture that a result shows of itself."""

from __future__ import annotations

import base64
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from billow.base.markup import table_of
from billow.pictures.curve_figure import curve_figure
from billow.pictures.curves import curve_of, require_quantities, usual_quantities
from billow.pictures.deployment import Deployment
from billow.pictures.highlights import highlights
from billow.pictures.sheet import printed
from billow.pictures.shot import Shot, drawn
from billow.pictures.shown_units import check_units
from billow.results.result import Result

FRAMES = 4


def plot(result: Result, names: Sequence[str], cfc: int | None, units: Sequence[str]) -> Figure:
    """As `billow plot`, which notebooks show. Errors as `Result.plot`."""
    check_units(units)
    chosen = list(names) or usual_quantities([result.histories])
    require_quantities(chosen, [result.histories], result.folder)
    with printed():
        panels = [{result.folder.name: curve_of(result.histories, name, cfc)} for name in chosen]
        return curve_figure(panels, result.record.get("title", ""), units)


def as_html(result: Result) -> str:
    """How a run ended, its peaks, and a strip of its frames."""
    times = np.linspace(result.times[0], result.times[-1], FRAMES).tolist()
    strip = base64.b64encode(drawn(Shot.at([Deployment(result.fabric, result)], times), "png")).decode()
    quality = result.record.get("quality", {}).get("verdict", "unknown")
    rows = [("folder", str(result.folder)), ("status", result.status), ("quality", quality), *highlights(result)]
    picture = f'<img style="max-width:100%" alt="The bag at {FRAMES} times" src="data:image/png;base64,{strip}">'
    return table_of(result.record.get("title") or "Run", rows, picture)
