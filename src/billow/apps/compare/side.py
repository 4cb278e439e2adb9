"""One side of a comparison."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.pictures.source import Source
from billow.results.histories import History
from billow.results.vtkhdf import FabricFile


@dataclass(frozen=True)
class PredictedFabric:
    """Frames of a surrogate, as `FabricFile` offers those of a run. times: [s]; positions: [m], (times, nodes, 3)."""

    path: Path
    times: np.ndarray
    positions: np.ndarray
    triangles: np.ndarray
    part: np.ndarray
    part_names: list[str]

    @property
    def reference(self) -> np.ndarray:
        """The first frame [m], (nodes, 3)."""
        return self.positions[0]

    def points(self, step: int) -> np.ndarray:
        """[m], (nodes, 3): where the nodes are in frame `step`."""
        return self.positions[step]


@dataclass(frozen=True)
class Side:
    """One side of a comparison. curves: None if it has none. fabric: None without a bag. remark: what to know of it."""

    source: Source
    curves: History | None
    fabric: FabricFile | PredictedFabric | None
    remark: str = ""

    @property
    def label(self) -> str:
        return self.source.label
