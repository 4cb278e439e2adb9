"""gas.vtkhdf, particles.vtkhdf: boxes along the axes (voxels) or single points (vertices), whose number changes from
frame to frame (docs/architecture.md, Frames)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from billow.results.vtkhdf import GridWriter

_VERTEX, _VOXEL = 1, 11
_CORNERS = np.array(
    [[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
)  # VTK's order of a voxel


class CloudWriter(GridWriter):
    """Writes frames of points or boxes."""

    def __init__(self, path: str | Path):
        super().__init__(path)
        self._starts: defaultdict[str, list[int]] = defaultdict(list)

    def points(self, time: float, positions: np.ndarray, fields: Mapping[str, np.ndarray]) -> None:
        """Add a frame of points: time [s], positions [m], (n, 3); fields: name -> (n,) or (n, 3)."""
        n = len(positions)
        self._frame(time, positions, np.arange(n), np.arange(n + 1), _VERTEX, fields)

    def boxes(self, time: float, centres: np.ndarray, size: np.ndarray, fields: Mapping[str, np.ndarray]) -> None:
        """Add a frame of boxes: centres [m], (n, 3); size: edge lengths [m], (n, 3); fields: name -> (n,) or (n, 3)."""
        n = len(centres)
        corners = (centres[:, None] + _CORNERS * size[:, None]).reshape(-1, 3)
        self._frame(time, corners, np.arange(8 * n), np.arange(0, 8 * n + 1, 8), _VOXEL, fields)

    def close(self) -> None:
        """Write where each frame begins, and close the file."""
        fields = {name: start for name, start in self._starts.items() if name.startswith("CellData/")}
        point, cell, connectivity = (self._starts[name] for name in ("Points", "Types", "Connectivity"))
        shape = {"Part": range(len(self._times)), "Point": point, "Cell": cell, "ConnectivityId": connectivity}
        self._end({**shape, **fields})

    def _frame(self, time, points, connectivity, offsets, kind, fields) -> None:
        cells = len(offsets) - 1
        self._times.append(float(time))
        for name, value, dtype in (
            ("NumberOfPoints", [len(points)], np.int64),
            ("NumberOfCells", [cells], np.int64),
            ("NumberOfConnectivityIds", [len(connectivity)], np.int64),
            ("Offsets", offsets, np.int64),
            ("Connectivity", connectivity, np.int64),
            ("Types", np.full(cells, kind), np.uint8),
            ("Points", points, np.float32),
            *((f"CellData/{name}", value, np.float32) for name, value in fields.items()),
        ):
            self._starts[name].append(self._extend(name, np.asarray(value, dtype=dtype), 4096))
