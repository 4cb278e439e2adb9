"""Guard against fabric that passes through fabric: counted at start and end, and at every frame if asked."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from billow.base.quality import Criterion, criterion
from billow.geometry.crossings import CrossingCount
from billow.solver.model import Model, State

FIELD = "crossings"
"""Field of an output frame: edges that pass through each triangle."""


class CrossingGuard:
    """Of one run; every_frame: whether frames are looked at."""

    def __init__(self, model: Model, every_frame: bool):
        self._model, self._every_frame = model, every_frame
        self._count = CrossingCount(model.surface)

    def frame(self, state: State) -> dict[str, np.ndarray]:
        """Its field of an output frame, if frames are looked at."""
        return {FIELD: self._count.per_triangle(state.positions)} if self._every_frame else {}

    def books(self, state: State, frames: Iterable[Mapping[str, np.ndarray]]) -> dict[str, float]:
        """Entries for run.json: crossings at the start, at the end, and at the worst moment looked at. frames: of the
        journal."""
        start, end = (self._count.total(positions) for positions in (self._model.start, state.positions))
        between = [float(frame[f"cell.{FIELD}"].sum()) for frame in frames if f"cell.{FIELD}" in frame]
        return {
            "crossings_at_start": start,
            "crossings_at_end": end,
            "crossings_at_worst": float(np.max([start, end, *between])),
        }

    @property
    def _judged(self) -> bool:
        """Where layers of fabric are to be kept apart, or where it was asked for."""
        return self._model.layers is not None or self._every_frame

    def remarks(self, books: Mapping[str, float]) -> Iterator[str]:
        """What the log says of crossings that are not judged."""
        if not self._judged and (worst := books["crossings_at_worst"]):
            yield (
                f"fabric passes through fabric in {worst:.0f} places, which the verdict leaves out: nothing was to "
                f'keep layers apart (fabric.self_contact = "layers" does)'
            )

    def verdicts(self, books: Mapping[str, float]) -> Iterator[Criterion]:
        if not self._judged:
            return
        apart = 'fabric.self_contact = "layers", a start shape without crossings, or a smaller run.dt_scale'
        worst, fails = books["crossings_at_worst"], math.inf if self._model.layers is None else 1
        yield criterion("crossings of fabric through fabric", worst, 0, fails, "-", apart)
