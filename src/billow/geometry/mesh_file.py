"""Reading triangles and quads with their parts from VTKHDF files, which Billow and ParaView write, and from VTK,
STL, OBJ and PLY files, which nearly every other program can write. Every size is checked before anything is read or
made, and nothing in a file is executed. Formats: docs.vtk.org, "VTKHDF format specification" and "VTK file formats".
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from billow.base.errors import InputError
from billow.base.input_file import LARGEST_DATA, read_bytes, require_file
from billow.base.table_file import whole_numbers
from billow.geometry.hdf_arrays import take
from billow.geometry.mesh_formats import read_obj, read_ply, read_stl
from billow.geometry.vtk_legacy import GHOSTS, QUAD, TRIANGLE, Grid, read_legacy
from billow.geometry.vtk_xml import read_xml

MOST_CELLS = 2_000_000
MOST_PARTS = 100_000

PLAIN = {".stl": read_stl, ".obj": read_obj, ".ply": read_ply}
"""Readers of files that have one time and may name their parts."""
SUFFIXES = (".vtkhdf", ".hdf", ".vtk", ".vtu", ".vtp", *PLAIN)
_KINDS = {
    1: "a vertex", 2: "a set of vertices", 3: "a line", 4: "a polyline", 6: "a strip of triangles", 7: "a polygon",
    8: "a pixel", 10: "a tetrahedron", 11: "a voxel", 12: "a hexahedron", 13: "a wedge", 14: "a pyramid",
    21: "a quadratic edge", 22: "a quadratic triangle", 23: "a quadratic quad", 28: "a biquadratic quad",
}  # fmt: skip
"""What VTK calls kinds of cells by number, as far as messages name them."""

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

    @property
    def size(self) -> float:
        """Largest extent of its cells along an axis, in the unit of the points."""
        return float(np.ptp(self.points[self.cells[self.cells >= 0]], axis=0).max())

    @property
    def area(self) -> float:
        """Of all cells, in the unit of the points squared; quads as two triangles."""
        a, b, c, d = (self.points[self.cells[:, k]] for k in range(4))
        halves = np.linalg.norm(np.cross(b - a, c - a), axis=1), np.linalg.norm(np.cross(c - a, d - a), axis=1)
        return 0.5 * float(halves[0].sum() + halves[1][self.cells[:, 3] >= 0].sum())


def read_mesh(path: str | Path, part_field: str = "part", frame: int = 0) -> CellMesh:
    """Mesh of a file, by the ending of its name, one of SUFFIXES; frame: of a file with several times, negative ones
    counted from the last. Quads that name a node twice in a row are triangles.

    Raises InputError E-GEO-030 (cannot be read), E-GEO-031 (holds no mesh of triangles and quads with parts).
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        why, remedy = f"its name ends in {path.suffix!r}", f"give a file that ends in {', '.join(SUFFIXES)}"
        raise UNREADABLE(name=path.name, path=str(path), why=why, remedy=remedy)
    try:
        if path.suffix.lower() not in (".vtkhdf", ".hdf"):
            if frame not in (0, -1):
                raise ValueError(f"it has one time; there is no frame {frame}")
            grid, names = _read_plain(path.suffix.lower(), read_bytes(path, LARGEST_DATA))
        else:
            require_file(path, LARGEST_DATA)
            with h5py.File(path, "r") as file:
                grid, names = _read_vtkhdf(file, part_field, frame)
    except (KeyError, RuntimeError) as error:
        absent = re.search(r"'([^']{1,60})' doesn't exist", str(error))
        why = f"it has no entry {absent[1]!r}" if absent else "a part of it is damaged"
        raise UNREADABLE(name=path.name, path=str(path), why=why) from None
    except (OSError, ValueError) as error:
        raise UNREADABLE(name=path.name, path=str(path), why=error) from None
    try:
        cells = corners_of(grid)
    except ValueError as error:
        raise NO_USABLE_MESH(name=path.name, path=path, why=error) from None
    try:
        part = _parts(grid, part_field)
    except ValueError as error:
        remedy = "name the field with the numbers of the parts in bag.part_field"
        raise NO_USABLE_MESH(name=path.name, path=path, why=error, remedy=remedy) from None
    return CellMesh(grid.points, cells, part, names)


def _read_plain(suffix: str, content: bytes) -> tuple[Grid, dict[str, int]]:
    if suffix in PLAIN:
        return PLAIN[suffix](content)
    return (read_legacy if suffix == ".vtk" else read_xml)(content), {}


def corners_of(grid: Grid) -> np.ndarray:
    """Cells (cells, 4) int64 of a grid of triangles and quads, -1 last for triangles, after checking that they and the
    points are sound. ValueError, with a sentence, if they are not."""
    points, offsets, nodes, types = grid.points, grid.offsets, grid.connectivity, grid.types
    if not len(types):
        raise ValueError("it has no cells")
    if len(types) > MOST_CELLS:
        raise ValueError(f"it has {len(types)} cells; at most {MOST_CELLS} are allowed")
    odd = ~np.isin(types, (TRIANGLE, QUAD))
    if odd.any():
        cell = int(np.argmax(odd))
        kind = _KINDS.get(int(types[cell]), f"a cell of VTK's kind {types[cell]}")
        raise ValueError(f"cell {cell} is {kind}, neither a triangle nor a quad")
    count = np.where(types == TRIANGLE, 3, 4)
    if len(offsets) != len(types) + 1 or offsets[0] != 0 or not np.array_equal(np.diff(offsets), count):
        raise ValueError("its cells do not have the nodes they should have")
    if len(nodes) != offsets[-1] or nodes.min() < 0 or nodes.max() >= len(points):
        raise ValueError(f"a cell names a node that is not among 0 to {len(points) - 1}")
    if not np.isfinite(points).all() or np.abs(points).max() > 1e6:
        node = int(np.argmin((np.abs(points) <= 1e6).all(axis=1)))
        raise ValueError(f"the coordinates of node {node} are not finite, or beyond a million")
    cells = np.full((len(types), 4), -1, dtype=np.int64)
    for kind, corners in ((TRIANGLE, 3), (QUAD, 4)):
        mine = np.flatnonzero(types == kind)
        cells[mine, :corners] = nodes[offsets[mine][:, None] + np.arange(corners)]
    # Other programs write a triangle as a quad whose last node repeats a neighbour.
    cells[(cells[:, 3] == cells[:, 2]) | (cells[:, 3] == cells[:, 0]), 3] = -1
    ordered = np.sort(cells, axis=1)
    twice = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if twice.any():
        cell = int(np.argmax(twice))
        listed = ", ".join(str(node) for node in cells[cell] if node >= 0)
        raise ValueError(
            f"cell {cell} has a node twice ({listed}); only the last node of a quad may repeat a neighbour"
        )
    return cells


def _parts(grid: Grid, part_field: str) -> np.ndarray:
    """Number of each cell's part, (cells,) int64; all 0 if the file has no cell fields."""
    cells = len(grid.types)
    if part_field not in grid.cell_fields:
        if grid.cell_fields:
            listed = ", ".join(sorted(grid.cell_fields)[:20])
            raise ValueError(f"it has no cell field {part_field!r}; its cell fields are {listed}")
        return np.zeros(cells, np.int64)
    values = grid.cell_fields[part_field]
    if values.shape not in ((cells,), (cells, 1)):
        raise ValueError(f"its cell field {part_field!r} has shape {values.shape}; expected one number for each cell")
    numbers = whole_numbers(values.reshape(-1), f"in its cell field {part_field!r} the value")
    if (np.abs(numbers) > 2**31).any():
        raise ValueError(f"a value of its cell field {part_field!r} is beyond 2^31")
    return numbers


def _read_vtkhdf(file: h5py.File, part_field: str, frame: int) -> tuple[Grid, dict[str, int]]:
    """The grid of one time, and number by name of the parts."""
    vtk = file["VTKHDF"]
    kind = vtk.attrs.get("Type", b"nothing that is known")
    kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
    if kind != "UnstructuredGrid":
        raise ValueError(f"it holds {kind[:40]}; UnstructuredGrid can be read")
    piece, begins = 0, dict.fromkeys(("Point", "Cell", "ConnectivityId"), 0)
    steps = vtk.get("Steps")
    if steps is not None:
        times = int(steps.attrs["NSteps"])
        if not -times <= frame < times:
            raise ValueError(f"it has {times} times; there is no frame {frame}")
        step = frame % times
        if "NumberOfParts" in steps and _one(steps, "NumberOfParts", step) != 1:
            raise ValueError("it is in several pieces at that time; save it as one")
        piece = _one(steps, "PartOffsets", step) if "PartOffsets" in steps else 0
        begins = {name: _one(steps, f"{name}Offsets", step) for name in begins}
    elif len(vtk["NumberOfPoints"]) > 1:
        raise ValueError("it is in several pieces; save it as one")
    elif frame not in (0, -1):
        raise ValueError(f"it has one time; there is no frame {frame}")
    nodes, cells, ids = (_one(vtk, f"NumberOf{name}", piece) for name in ("Points", "Cells", "ConnectivityIds"))
    if not (nodes <= 4 * MOST_CELLS and cells <= MOST_CELLS and ids <= 4 * MOST_CELLS):
        raise ValueError(f"it has more than {MOST_CELLS} cells")
    fields = {}
    for name, data in vtk.get("CellData", {}).items():
        if name not in (part_field, GHOSTS):
            fields[name] = np.zeros(0)  # only its name is of interest
            continue
        own = f"CellDataOffsets/{name}"
        begin = _one(steps, own, step) if steps is not None and own in steps else begins["Cell"]
        fields[name] = take(data, begin, cells)
    if fields.pop(GHOSTS, np.zeros(0)).any():
        raise ValueError("it has ghost cells, copies of another piece's; save the whole fabric in one")
    grid = Grid(
        points=take(vtk["Points"], begins["Point"], nodes, (3,)).astype(float),
        # Each piece before has one offset more than cells.
        offsets=take(vtk["Offsets"], begins["Cell"] + piece, cells + 1).astype(np.int64),
        connectivity=take(vtk["Connectivity"], begins["ConnectivityId"], ids).astype(np.int64),
        types=take(vtk["Types"], begins["Cell"], cells).astype(np.int64),
        cell_fields=fields,
    )
    return grid, _names(file)


def _one(group: h5py.Group, name: str, row: int) -> int:
    """A count or an offset of a group."""
    number = int(np.ravel(take(group[name], row, 1, None))[0])
    if number < 0:
        raise ValueError(f"{name} is {number}")
    return number


def _names(file: h5py.File) -> dict[str, int]:
    if "billow/part_names" not in file:
        return {}
    names = file["billow/part_names"].asstr()[:MOST_PARTS]
    return {str(name): number for number, name in enumerate(names)}
