"""gas.vtkhdf as it is read: the boxes of a gas that is known place by place, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.geometry.hdf_arrays import take
from billow.results.vtkhdf import UNITS, FabricFile

GAS = "gas.vtkhdf"
CORNERS = 8


@dataclass(frozen=True)
class Boxes:
    """Boxes along the axes. low, high: corners [m], (n, 3) float32; values: field -> (n,) or (n, 3) float32."""

    low: np.ndarray
    high: np.ndarray
    values: dict[str, np.ndarray]


class GasFrames:
    """A gas.vtkhdf on disk; arrays are read when asked for.

    times: [s], (times,) float64; fields: names. IntegrityError E-RES-007 if the file is not one.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with FabricFile.opened(self.path) as file:
            grid = file["VTKHDF"]
            self.times = take(grid["Steps/Values"], 0, int(grid["Steps"].attrs["NSteps"]))
            self._counts = take(grid["NumberOfCells"], 0, len(self.times))
            if (self._counts < 0).any() or (
                take(grid["NumberOfPoints"], 0, len(self.times)) != CORNERS * self._counts
            ).any():
                raise ValueError("its cells are no boxes")
            self.fields = tuple(grid["CellData"])
        self._starts = np.concatenate([[0], np.cumsum(self._counts)])

    def boxes(self, step: int) -> Boxes:
        """Those of frame `step`."""
        start, count = int(self._starts[step]), int(self._counts[step])
        with FabricFile.opened(self.path) as file:
            grid = file["VTKHDF"]
            points = take(grid["Points"], CORNERS * start, CORNERS * count, (3,)).reshape(-1, CORNERS, 3)
            values = {name: take(grid[f"CellData/{name}"], start, count, None) for name in self.fields}
        return Boxes(points[:, 0], points[:, -1], values)

    @staticmethod
    def unit(field: str) -> str:
        """Unit of a field."""
        return UNITS.get(field, "-")
