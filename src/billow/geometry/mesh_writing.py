"""Writing a mesh of triangles and quads with its parts as VTKHDF, which ParaView and `mesh_file.read_mesh` read; points
keep all their bits."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from billow.geometry.mesh_file import CellMesh
from billow.geometry.vtk_legacy import QUAD, TRIANGLE


def write_mesh(path: str | Path, mesh: CellMesh) -> None:
    """Write a mesh; OSError as soon as the disk refuses something."""
    corners = np.where(mesh.cells[:, 3] < 0, 3, 4)
    with h5py.File(path, "w", track_order=True) as file:
        grid = file.create_group("VTKHDF", track_order=True)
        grid.attrs["Version"] = np.array((2, 2), dtype=np.int64)
        grid.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        grid["NumberOfPoints"] = np.array([len(mesh.points)], dtype=np.int64)
        grid["NumberOfCells"] = np.array([len(corners)], dtype=np.int64)
        grid["NumberOfConnectivityIds"] = np.array([corners.sum()], dtype=np.int64)
        grid["Points"] = np.asarray(mesh.points, dtype=np.float64)
        grid["Offsets"] = np.concatenate([[0], np.cumsum(corners)]).astype(np.int64)
        grid["Connectivity"] = mesh.cells[mesh.cells >= 0].astype(np.int64)
        grid["Types"] = np.where(corners == 3, TRIANGLE, QUAD).astype(np.uint8)
        grid["CellData/part"] = mesh.part.astype(np.int64)
