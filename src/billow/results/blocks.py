"""straps.vtkhdf and obstacles.vtkhdf: what is drawn beside the fabric, and scene.vtkhdf, which joins all of them as
named blocks for ParaView (docs/architecture.md, Frames).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np

from billow.geometry.hdf_arrays import take
from billow.results.hdf5_file import PatientFile
from billow.results.histories import History
from billow.results.obstacles import has_end, placed, surface
from billow.results.vtkhdf import UNITS, VERSION, FabricFile, GridWriter, write_names

FABRIC, STRAPS, OBSTACLES, SCENE = "fabric.vtkhdf", "straps.vtkhdf", "obstacles.vtkhdf", "scene.vtkhdf"
BLOCKS = {"fabric": FABRIC, "straps": STRAPS, "obstacles": OBSTACLES}
"""Name of each block of the scene, in their order, and its file."""

_LINE, _TRIANGLE = 3, 5
FINENESS = 3
"""Of the surfaces of obstacles: 1,280 triangles each."""
PLATE_SIZE = 1.2
"""Side of the square that stands for a plate, over that of the bag at its widest."""


class BlockWriter(GridWriter):
    """Writes frames of cells that stay the same, while their points move.

    cells: (n, 2) lines or (n, 3) triangles, indices of points. owner: (n,) int, which of `owners` each belongs to;
    kind: what an owner is called, such as "strap".
    """

    def __init__(self, path: str | Path, cells: np.ndarray, owner: np.ndarray, owners: Sequence[str], kind: str):
        super().__init__(path)
        self._points, self._cells, self._begins, self._last = int(cells.max()) + 1, len(cells), [], None
        corners = cells.shape[1]
        self._fields: list[str] = []
        for name, value in (
            ("NumberOfPoints", [self._points]),
            ("NumberOfCells", [len(cells)]),
            ("NumberOfConnectivityIds", [cells.size]),
            ("Connectivity", cells.reshape(-1)),
            ("Offsets", np.arange(0, cells.size + 1, corners)),
        ):
            self._grid[name] = np.asarray(value, dtype=np.int64)
        self._grid["Types"] = np.full(len(cells), {2: _LINE, 3: _TRIANGLE}[corners], dtype=np.uint8)
        self._kind, self._owners = kind, tuple(owners)
        self._grid[f"CellData/{kind}"] = np.asarray(owner, np.int32)
        self._grid[f"CellData/{kind}"].attrs["units"] = UNITS[kind]

    def append(self, time: float, points: np.ndarray, cell_data: Mapping[str, np.ndarray] | None = None) -> None:
        """Add a frame: time [s], points [m] (points, 3), fields (n,) on the cells. Points that stay where they were
        take no room."""
        points = np.asarray(points, np.float32)
        self._times.append(float(time))
        if self._last is not None and np.array_equal(points, self._last):
            self._begins.append(self._begins[-1])
        else:
            self._begins.append(self._extend("Points", points, self._points))
            self._last = points
        self._fields = [f"CellData/{name}" for name in cell_data or {}]
        for name, values in (cell_data or {}).items():
            self._extend(f"CellData/{name}", np.asarray(values, np.float32), self._cells)

    def close(self) -> None:
        """Write where each frame begins, and close the file."""
        frame = np.arange(len(self._times))
        once = dict.fromkeys(("Part", "Cell", "ConnectivityId", f"CellData/{self._kind}"), 0 * frame)
        fields = dict.fromkeys(self._fields, self._cells * frame)
        write_names(self._grid, f"{self._kind}_names", self._owners, len(self._times))
        self._end({"Point": self._begins, **once, **fields})


class StrapsWriter(BlockWriter):
    """Writes straps.vtkhdf."""

    block = 1


class ObstaclesWriter(BlockWriter):
    """Writes obstacles.vtkhdf."""

    block = 2


class StrapsFile:
    """A straps.vtkhdf on disk. lines: (bars, 2), the ends of each bar among its points; strap: (bars,), which one it
    belongs to. IntegrityError E-RES-007 if it cannot be read."""

    def __init__(self, path: Path):
        self.path = path
        with FabricFile.opened(path) as file:
            grid = file["VTKHDF"]
            self.lines = take(grid["Connectivity"], 0, len(grid["Connectivity"])).reshape(-1, 2)
            self._begins = take(grid["Steps/PointOffsets"], 0, len(grid["Steps/PointOffsets"]))
            self._count = int(grid["NumberOfPoints"][0])
            if len(self.lines) and not 0 <= self.lines.min() <= self.lines.max() < self._count:
                raise ValueError("a strap names a point that does not exist")

    def points(self, step: int) -> np.ndarray:
        """[m], (points, 3): ends of the bars in frame `step`."""
        with FabricFile.opened(self.path) as file:
            return take(file["VTKHDF/Points"], int(self._begins[step]), self._count, (3,))


def write_obstacles(folder: Path, obstacles: Sequence[dict], histories: History) -> None:
    """Write obstacles.vtkhdf with the frames of the fabric.vtkhdf beside it; nothing without obstacles.

    obstacles: at the start, as run.json describes them; a plate becomes a square under the bag.
    """
    fabric = FabricFile(folder / FABRIC)
    known = [o for o in obstacles if o["locked"] or "quaternion" in histories.of(o["name"])]
    if not known or not len(fabric.times):
        return
    middle, wide = extent(fabric)
    meshes = [mesh_of(obstacle, middle, wide) for obstacle in known]
    first = np.cumsum([0, *(len(points) for points, _ in meshes)])
    cells = np.concatenate([triangles + k for (_, triangles), k in zip(meshes, first, strict=False)])
    owner = np.repeat(np.arange(len(meshes)), [len(triangles) for _, triangles in meshes])
    names = [obstacle["name"] for obstacle in known]
    with ObstaclesWriter(folder / OBSTACLES, cells, owner, names, "obstacle") as block:
        for time in fabric.times.tolist():
            there = zip(placed(known, histories, time), meshes, strict=True)
            points = [start if o["locked"] else mesh_of(o, middle, wide)[0] for o, (start, _) in there]
            block.append(time, np.concatenate(points))


def write_scene(folder: Path) -> None:
    """Write scene.vtkhdf, which links to the files there are beside it; nothing if the fabric is alone."""
    there = {name: file for name, file in BLOCKS.items() if (folder / file).is_file()}
    if len(there) < 2:
        return
    disk = PatientFile(folder / SCENE)
    try:
        # Readers ask for groups in the order in which they were made.
        with h5py.File(disk, "w", track_order=True) as file:
            grid = file.create_group("VTKHDF", track_order=True)
            grid.attrs["Version"] = np.array(VERSION, dtype=np.int64)
            grid.attrs.create("Type", np.bytes_("PartitionedDataSetCollection"))
            for name, path in there.items():
                grid[name] = h5py.ExternalLink(path, "/VTKHDF")
            tree = grid.create_group("Assembly", track_order=True)
            for name in there:
                tree[name] = h5py.SoftLink(f"/VTKHDF/{name}")
        disk.publish()
    finally:
        disk.abandon()


def extent(fabric: FabricFile) -> tuple[np.ndarray, float]:
    """Middle of the bag over all frames [m], (3,), and its largest side [m]."""
    extremes = np.array([(points.min(axis=0), points.max(axis=0)) for points in fabric.each_points()])
    low, high = extremes[:, 0].min(axis=0), extremes[:, 1].max(axis=0)
    return 0.5 * (low + high).astype(float), float((high - low).max())


def mesh_of(obstacle: dict, middle: np.ndarray, wide: float) -> tuple[np.ndarray, np.ndarray]:
    """Points [m] (nodes, 3) in space and triangles (n, 3) of an obstacle; of a plate, a square under a bag whose middle
    and size are given, as by `extent`."""
    if has_end(obstacle):
        return surface(obstacle, FINENESS)
    rotation, centre = np.asarray(obstacle["rotation"], float), np.asarray(obstacle["center"], float)
    under = (middle - centre) @ rotation
    half = 0.5 * PLATE_SIZE * wide
    corners = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
    corners[:, :2] += under[:2]
    return corners @ rotation.T + centre, np.array([[0, 1, 2], [0, 2, 3]])
