"""Reading triangles and quads with their parts from VTKHDF files, which Billow and ParaView write, and from VTK legacy
files, which nearly every other program can write. Every size is checked before anything is read or made, and nothing in
a file is executed. Formats: docs.vtk.org, "VTKHDF format specification" and "VTK file formats, simple legacy formats".
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from billow.base.errors import InputError
from billow.geometry.vtk_legacy import QUAD, TRIANGLE, read_legacy

LARGEST_FILE = 2_000_000_000  # bytes; a frame of a million triangles takes 50 MB
MOST_CELLS = 2_000_000

SUFFIXES = (".vtkhdf", ".hdf", ".vtk")

UNREADABLE = InputError.declare(
    "E-GEO-030",
    "cannot read the mesh file {name!r}",
    where="{path!r}",
    cause="a wrong path, another format, or a damaged file",
    remedy="check the path, and that the file opens in ParaView; save it as .vtkhdf, or as .vtk in ASCII",
)
NO_USABLE_MESH = InputError.declare(
    "E-GEO-031",
    "{name} holds no usable mesh",
    where="{path}",
    cause="other kinds of cells in the file, nodes that do not exist, or a part field of another name",
    remedy="save the fabric alone, as triangles and quads in one unstructured grid",
)


@dataclass(frozen=True)
class CellMesh:
    """points: (nodes, 3), in the file's unit. cells: (cells, 4) int64 node indices, -1 last for triangles. part:
    (cells,) int64, the number of each cell's part. part_names: name -> number, as far as the file names parts."""

    points: np.ndarray
    cells: np.ndarray
    part: np.ndarray
    part_names: dict[str, int]


def read_mesh(path: str | Path, part_field: str = "part", frame: int = 0) -> CellMesh:
    """Mesh of a .vtkhdf or .vtk file; frame: of a file with several times, negative ones counted from the last.

    Raises InputError E-GEO-030 (cannot be read), E-GEO-031 (holds no mesh of triangles and quads with parts).
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        why, remedy = f"its name ends in {path.suffix!r}", f"give a file that ends in {', '.join(SUFFIXES)}"
        raise UNREADABLE(name=path.name, path=str(path), why=why, remedy=remedy)
    try:
        if not path.is_file() or path.stat().st_size > LARGEST_FILE:
            raise OSError(f"it is not a file, or longer than {LARGEST_FILE} bytes")
        legacy = path.suffix.lower() == ".vtk"
        found = (*read_legacy(path.read_bytes(), part_field), {}) if legacy else _read_vtkhdf(path, part_field, frame)
        points, offsets, connectivity, types, part, names = found
    except (OSError, KeyError, ValueError, IndexError, RuntimeError, TypeError, OverflowError) as error:
        why = str(error.args[-1]) if error.args else "it is damaged"
        raise UNREADABLE(name=path.name, path=str(path), why=why) from None
    _require_sound(path, points, offsets, connectivity, types, part, part_field)
    cells = np.full((len(types), 4), -1, dtype=np.int64)
    for kind, corners in ((TRIANGLE, 3), (QUAD, 4)):
        mine = np.flatnonzero(types == kind)
        cells[mine, :corners] = connectivity[offsets[mine][:, None] + np.arange(corners)]
    return CellMesh(points, cells, part.astype(np.int64), names)


def _read_vtkhdf(path: Path, part_field: str, frame: int):
    with h5py.File(path, "r") as file:
        grid = file["VTKHDF"]
        if grid.attrs["Type"] not in (b"UnstructuredGrid", "UnstructuredGrid"):
            raise ValueError("it is not an unstructured grid")
        counts = [int(grid[name][0]) for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds")]
        nodes, cells, ids = counts
        if not (0 <= nodes <= 4 * MOST_CELLS and 0 <= cells <= MOST_CELLS and 0 <= ids <= 4 * MOST_CELLS):
            raise ValueError(f"it has more than {MOST_CELLS} cells")
        first = 0
        if "Steps" in grid:
            first = int(grid["Steps/PointOffsets"][range(int(grid["Steps"].attrs["NSteps"]))[frame]])
        elif len(grid["NumberOfPoints"]) > 1:
            raise ValueError("it is in several pieces; save it as one")
        names = file["billow/part_names"].asstr()[:MOST_CELLS] if "billow/part_names" in file else []
        part = grid["CellData"][part_field][:cells] if part_field in grid.get("CellData", ()) else np.zeros(cells)
        return (
            grid["Points"][first : first + nodes].astype(float).reshape(nodes, 3),
            grid["Offsets"][: cells + 1].astype(np.int64),
            grid["Connectivity"][:ids].astype(np.int64),
            grid["Types"][:cells].astype(np.int64),
            part,
            {str(name): number for number, name in enumerate(names)},
        )


def _require_sound(path: Path, points, offsets, connectivity, types, part, part_field) -> None:
    def refuse(why: str, remedy: str | None = None) -> None:
        raise NO_USABLE_MESH(name=path.name, path=path, why=why, remedy=remedy)

    if not len(types):
        refuse("it has no cells")
    if len(types) > MOST_CELLS:
        refuse(f"it has {len(types)} cells; at most {MOST_CELLS} are allowed")
    if not np.isin(types, (TRIANGLE, QUAD)).all():
        cell = int(np.argmin(np.isin(types, (TRIANGLE, QUAD))))
        refuse(f"cell {cell} is neither a triangle nor a quad")
    corners = np.where(types == TRIANGLE, 3, 4)
    if len(offsets) != len(types) + 1 or offsets[0] != 0 or not np.array_equal(np.diff(offsets), corners):
        refuse("its cells do not have the nodes they should have")
    if len(connectivity) < offsets[-1] or connectivity.min() < 0 or connectivity.max() >= len(points):
        refuse("a cell names a node that does not exist")
    if not np.isfinite(points).all() or np.abs(points).max() > 1e6:
        refuse("the coordinates of a node are not finite, or beyond 1000 km", remedy="correct them")
    if part.shape != types.shape or not np.isfinite(part).all() or (np.abs(part) > 2**31).any() or (part % 1).any():
        why = f"a value of its cell field {part_field!r} is not a whole number"
        refuse(why, remedy="name the field with the numbers of the parts in bag.part_field")
