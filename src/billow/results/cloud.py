"""gas.vtkhdf, particles.vtkhdf: cells or points whose number changes from frame to frame; ParaView, VTK and h5py open
them.

The layout is VTKHDF, a temporal UnstructuredGrid whose parts differ (https://docs.vtk.org, "VTKHDF format
specification", version 2.2): every frame is one part with its own points, cells and fields, and `Steps` says where in
the long arrays it begins. Cells are boxes along the axes (voxels), or single points (vertices).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from billow.results.vtkhdf import VERSION

_VERTEX, _VOXEL = 1, 11
_CORNERS = np.array(
    [[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
)  # VTK's order of a voxel


class CloudWriter:
    """Writes frames of points or boxes; use as a context manager. FileExistsError if `path` exists."""

    def __init__(self, path: str | Path):
        self._file = h5py.File(path, "x")
        self._grid = self._file.create_group("VTKHDF")
        self._grid.attrs["Version"] = np.array(VERSION, dtype=np.int64)
        self._grid.attrs.create("Type", np.bytes_("UnstructuredGrid"))  # readers insist on a fixed-length string
        self._times: list[float] = []
        self._starts: dict[str, list[int]] = {}

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
        count = len(self._times)
        steps = self._grid.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(count)
        steps["Values"] = np.array(self._times, dtype=np.float64)
        steps["NumberOfParts"] = np.ones(count, dtype=np.int64)
        steps["PartOffsets"] = np.arange(count, dtype=np.int64)

        def starts(name: str) -> np.ndarray:
            return np.array(self._starts.get(name, []), dtype=np.int64)

        steps["PointOffsets"] = starts("Points")
        steps["CellOffsets"] = starts("Types")[:, None]  # one column for each kind of topology
        steps["ConnectivityIdOffsets"] = starts("Connectivity")[:, None]
        for name in self._starts:
            if name.startswith("CellData/"):
                steps[name.replace("CellData/", "CellDataOffsets/")] = starts(name)
        self._file.close()

    def __enter__(self) -> CloudWriter:
        return self

    def __exit__(self, *error) -> None:
        self.close()

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
            self._append(name, np.asarray(value, dtype=dtype))

    def _append(self, name: str, rows: np.ndarray) -> None:
        if name not in self._grid:
            self._grid.create_dataset(
                name, shape=(0, *rows.shape[1:]), maxshape=(None, *rows.shape[1:]), dtype=rows.dtype,
                chunks=(4096, *rows.shape[1:]), compression="gzip", compression_opts=1, shuffle=True,
            )  # fmt: skip
        dataset = self._grid[name]
        self._starts.setdefault(name, []).append(len(dataset))
        dataset.resize(len(dataset) + len(rows), axis=0)
        dataset[len(dataset) - len(rows) :] = rows
