"""gas.vtkhdf as it is read: the boxes of a gas that is known place by place, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from billow.geometry.hdf_arrays import take
from billow.results.vtkhdf import UNITS, FabricFile

GAS = "gas.vtkhdf"
CORNERS = 8
MOST_BOXES = 6000
"""Boxes of a frame; of a lattice with more cells, two by two by two of them are one."""
SHARE, HIDDEN = "volume_fraction", "vtkGhostType"


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
            self._images = tuple(grid.get("Assembly", ()))  # of the chambers of a gas on a lattice
            first = grid[self._images[0]] if self._images else grid
            self.times = take(first["Steps/Values"], 0, int(first["Steps"].attrs["NSteps"]))
            self.fields = tuple(name for name in first["CellData"] if name != HIDDEN)
            if self._images:
                return
            self._counts = take(grid["NumberOfCells"], 0, len(self.times))
            if (self._counts < 0).any() or (
                take(grid["NumberOfPoints"], 0, len(self.times)) != CORNERS * self._counts
            ).any():
                raise ValueError("its cells are no boxes")
        self._starts = np.concatenate([[0], np.cumsum(self._counts)])

    def boxes(self, step: int) -> Boxes:
        """Those of frame `step`. Of a lattice the cells of all chambers, united until they are at most MOST_BOXES:
        their values are means by volume of gas."""
        with FabricFile.opened(self.path) as file:
            grid = file["VTKHDF"]
            if self._images:
                return _united([self._cells(grid[name], step) for name in self._images])
            start, count = int(self._starts[step]), int(self._counts[step])
            points = take(grid["Points"], CORNERS * start, CORNERS * count, (3,)).reshape(-1, CORNERS, 3)
            values = {name: take(grid[f"CellData/{name}"], start, count, None) for name in self.fields}
        return Boxes(points[:, 0], points[:, -1], values)

    def _cells(self, image: h5py.Group, step: int) -> _Cells:
        extent = np.asarray(image.attrs["WholeExtent"], np.int64).reshape(3, 2)
        shape = tuple((extent[:, 1] - extent[:, 0])[::-1].tolist())  # x last
        shown = take(image[f"CellData/{HIDDEN}"], step, 1, shape)[0] == 0
        values = {}
        for name in self.fields:
            field = image[f"CellData/{name}"]
            values[name] = take(field, step, 1, shape + field.shape[4:])[0][shown]
        origin, size = np.asarray(image.attrs["Origin"], float), np.asarray(image.attrs["Spacing"], float)
        return _Cells(np.argwhere(shown)[:, ::-1], origin, size, values)

    @staticmethod
    def unit(field: str) -> str:
        """Unit of a field."""
        return UNITS.get(field, "-")


@dataclass(frozen=True)
class _Cells:
    """Cells of an image that are shown. place: numbers along x, y, z, (n, 3); origin: of the image [m]; size: of a cell
    [m], (3,); values: as those of Boxes."""

    place: np.ndarray
    origin: np.ndarray
    size: np.ndarray
    values: dict[str, np.ndarray]

    def coarser(self) -> _Cells:
        """Two by two by two cells as one. Those that are hidden hold nothing."""
        place, of = np.unique(self.place // 2, axis=0, return_inverse=True)
        share, of = self.values[SHARE].astype(float), of.ravel()
        whole = np.bincount(of, share, len(place))
        values = {}
        for name, each in self.values.items():
            columns = each.reshape(len(of), -1).T
            means = [np.bincount(of, share * column, len(place)) / whole for column in columns]
            values[name] = np.stack(means, axis=-1).reshape(len(place), *each.shape[1:]).astype(np.float32)
        values[SHARE] = (whole / 8.0).astype(np.float32)
        return _Cells(place, self.origin, 2.0 * self.size, values)


def _united(chambers: list[_Cells]) -> Boxes:
    while sum(len(cells.place) for cells in chambers) > MOST_BOXES:
        chambers = [cells.coarser() for cells in chambers]
    low = np.concatenate([cells.origin + cells.place * cells.size for cells in chambers])
    high = np.concatenate([cells.origin + (cells.place + 1) * cells.size for cells in chambers])
    values = {name: np.concatenate([cells.values[name] for cells in chambers]) for name in chambers[0].values}
    return Boxes(low.astype(np.float32), high.astype(np.float32), values)
