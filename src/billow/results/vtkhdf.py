"""fabric.vtkhdf: the moving mesh of a run, one file that ParaView, VTK and h5py open (docs/architecture.md, Frames).

The file is written from finished data (`journal` keeps those of a run that is still going on), many frames at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from billow.base.errors import IntegrityError
from billow.base.input_file import require_file
from billow.geometry.hdf_arrays import take
from billow.results.hdf5_file import PatientFile

UNREADABLE_MESH = IntegrityError.declare(
    "E-RES-007",
    "the moving mesh cannot be read",
    where="{path}",
    cause="a missing field, or a file that is damaged or is not a fabric.vtkhdf",
    remedy="check the path and the name of the field; if the file is damaged, run the case again: "
    "billow run CASE.toml --out RUN",
)

LARGEST_FRAMES = 1_000_000_000_000
"""Bytes of the frames of a run, which are read one by one."""
UNITS = {
    "Points": "m", "part": "-", "strap": "-", "obstacle": "-", "crossings": "-",
    "displacement": "m", "velocity": "m/s", "contact_force": "N", "plate_force": "N",
    "stretch": "-", "strain_warp": "-", "strain_weft": "-", "stress": "Pa",
    "gauge_pressure": "Pa", "gas_temperature": "K", "gas_density": "kg/m^3", "gas_velocity": "m/s",
    "tension": "N", "pressure": "Pa", "temperature": "K", "density": "kg/m^3", "particles": "-",
    "half_width": "m", "internal_energy": "J", "torn_at": "s", "species": "-", "chamber": "-",
    "volume_fraction": "-",
}  # fmt: skip
"""Unit of each field of the frames, kept beside it as the attribute `units`; what they mean: docs/histories.md."""

VERSION = (2, 2)  # the first that allows groups beside /VTKHDF
_VTK_TRIANGLE = 5
FRAMES_AT_ONCE = 64
"""Frames kept in memory before they are written together."""


class FramesWriter:
    """A file of frames that is being written; a context manager, without whose end there is no file.

    FileExistsError if `path` exists; OSError as soon as the disk refuses something.
    """

    def __init__(self, path: str | Path, **creation):
        self._disk = PatientFile(path)
        self._file = h5py.File(self._disk, "w", **creation)
        self._times: list[float] = []

    def __enter__(self):
        return self

    def __exit__(self, kind: type | None, *_) -> None:
        try:
            if kind is None:
                self.close()
        finally:
            self._file.close()
            self._disk.abandon()


class GridWriter(FramesWriter):
    """A temporal unstructured grid that is being written, as `FramesWriter`."""

    block = 0
    """Place of the file among the blocks of a scene."""

    def __init__(self, path: str | Path):
        super().__init__(path)
        self._grid = self._file.create_group("VTKHDF")
        self._grid.attrs["Version"] = np.array(VERSION, dtype=np.int64)
        self._grid.attrs["Index"] = np.int64(self.block)
        self._grid.attrs.create("Type", np.bytes_("UnstructuredGrid"))  # readers insist on a fixed-length string

    def _extend(self, name: str, rows: np.ndarray, rows_of_chunk: int) -> int:
        """Add rows to an array of the file, packed; returns where they begin."""
        if name not in self._grid:
            self._grid.create_dataset(
                name, shape=(0, *rows.shape[1:]), maxshape=(None, *rows.shape[1:]), dtype=rows.dtype,
                chunks=(rows_of_chunk, *rows.shape[1:]), compression="gzip", compression_opts=1, shuffle=True,
            )  # fmt: skip
            if unit := UNITS.get(name.rpartition("/")[2]):
                self._grid[name].attrs["units"] = unit
        dataset = self._grid[name]
        begin = len(dataset)
        dataset.resize(begin + len(rows), axis=0)
        dataset[begin:] = rows
        self._disk.check()
        return begin

    def _end(self, begins: Mapping[str, Sequence[int] | np.ndarray]) -> None:
        """Write times and where each frame begins, and close the file.

        begins: name of points, cells or a field, such as "Point" or "CellData/part" -> (times,) int.
        """
        steps = self._grid.require_group("Steps")
        steps.attrs["NSteps"] = np.int64(len(self._times))
        steps["Values"] = np.array(self._times, dtype=np.float64)
        steps["NumberOfParts"] = np.ones(len(self._times), dtype=np.int64)
        for name, begin in begins.items():
            kind, slash, field = name.partition("/")
            # one column for each kind of topology; an unstructured grid has one
            shape = (-1, 1) if kind in ("Cell", "ConnectivityId") else (-1,)
            steps[f"{kind}Offsets{slash}{field}"] = np.asarray(begin, dtype=np.int64).reshape(shape)
        self._file.close()
        self._disk.publish()


def write_names(grid: h5py.Group, name: str, names: Sequence[str], frames: int) -> None:
    """Write names, which readers show beside every frame: VTK's field data, in ASCII as it wants them."""
    plain = [text.encode("ascii", "backslashreplace").decode() for text in names]
    grid.create_dataset(f"FieldData/{name}", data=plain, dtype=h5py.string_dtype("ascii"))
    grid[f"Steps/FieldDataOffsets/{name}"] = np.zeros(frames, dtype=np.int64)
    grid[f"Steps/FieldDataSizes/{name}"] = np.tile(np.array([1, len(plain)], dtype=np.int64), (frames, 1))


class FabricWriter(GridWriter):
    """Writes frames of a moving triangle mesh.

    points: [m], (nodes, 3), the start shape; triangles: (triangles, 3) int, counted from 0; part: (triangles,) int,
    index into part_names.
    """

    def __init__(
        self, path: str | Path, points: np.ndarray, triangles: np.ndarray, part: np.ndarray, part_names: Sequence[str]
    ):
        points, triangles, part = np.asarray(points), np.asarray(triangles), np.asarray(part)
        self._nodes, self._triangles = len(points), len(triangles)
        if points.shape != (self._nodes, 3) or triangles.shape != (self._triangles, 3):
            raise ValueError(f"points {points.shape} and triangles {triangles.shape} must be (n, 3)")
        if part.shape != (self._triangles,) or (
            self._triangles and not 0 <= part.min() <= part.max() < len(part_names)
        ):
            raise ValueError(f"part {part.shape} must give each triangle an index into {list(part_names)}")
        if self._triangles and not 0 <= triangles.min() <= triangles.max() < self._nodes:
            raise ValueError("a triangle names a node that does not exist")
        self._sizes: dict[str, tuple[int, ...]] = {}
        super().__init__(path)
        for name, value in (
            ("NumberOfPoints", [self._nodes]),
            ("NumberOfCells", [self._triangles]),
            ("NumberOfConnectivityIds", [3 * self._triangles]),
            ("Connectivity", triangles.reshape(-1)),
            ("Offsets", np.arange(0, 3 * self._triangles + 1, 3)),
        ):
            self._grid[name] = np.asarray(value, dtype=np.int64)
        self._grid["Types"] = np.full(self._triangles, _VTK_TRIANGLE, dtype=np.uint8)
        self._grid["CellData/part"] = part.astype(np.int32)
        self._grid["CellData/part"].attrs["units"] = UNITS["part"]
        self._block: dict[str, list[np.ndarray]] = {}
        self._part_names = tuple(part_names)
        self._file["billow/start_points"] = points.astype(np.float32)
        self._file["billow"].create_dataset("part_names", data=list(part_names), dtype=h5py.string_dtype())

    def append(
        self,
        time: float,
        points: np.ndarray,
        point_data: Mapping[str, np.ndarray] | None = None,
        cell_data: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        """Add one frame; it is in the file at the latest when the writer is closed.

        time: [s], later than the frame before; points: [m], (nodes, 3); point_data: name -> (nodes,) or (nodes, 3);
        cell_data: name -> (triangles,). Fields are stored as float32 and are the same in every frame (ValueError).
        """
        frame = self._frame(points, point_data or {}, cell_data or {})
        if self._times and not time > self._times[-1]:
            raise ValueError(f"frame at {time} s does not come after {self._times[-1]} s")
        self._times.append(float(time))
        for name, field in frame.items():
            self._block.setdefault(name, []).append(field)
        if len(self._block["Points"]) == FRAMES_AT_ONCE:
            self._write_block()

    def close(self) -> None:
        """Write what is left and where each frame begins, and close the file."""
        self._write_block()
        write_names(self._grid, "part_names", self._part_names, len(self._times))
        frame = np.arange(len(self._times))
        fields = {name: self._rows(name) * frame for name in self._sizes if name != "Points"}
        point = self._nodes * frame
        once = dict.fromkeys(("Part", "Cell", "ConnectivityId", "CellData/part"), 0 * frame)
        self._end({"Point": point, **once, **fields})

    def _write_block(self) -> None:
        # Packed: 50 frames of 10,000 nodes shrink from 6 to 3.5 MB a field, contact forces to 0.5 MB, for 80 ms;
        # reading is no slower. One chunk a frame.
        for name, fields in self._block.items():
            self._extend(name, np.concatenate(fields), max(len(fields[0]), 1))
        self._block = {}

    def _rows(self, name: str) -> int:
        """Rows of a frame of an array, by its place in the file."""
        return self._triangles if name.startswith("CellData") else self._nodes

    def _frame(self, points, point_data, cell_data) -> dict[str, np.ndarray]:
        """The frame's blocks by place in the file, checked before any of them is written."""
        frame = {"Points": points}
        frame |= {f"PointData/{name}": value for name, value in point_data.items()}
        frame |= {f"CellData/{name}": value for name, value in cell_data.items()}
        frame = {name: np.asarray(value, dtype=np.float32) for name, value in frame.items()}
        sizes = {name: value.shape for name, value in frame.items()}
        for name, size in sizes.items():
            count = self._rows(name)
            allowed = [(count, 3)] if name == "Points" else [(count,), (count, 3)]
            if size not in allowed or name == "CellData/part":
                raise ValueError(f"{name} has shape {size}; expected {' or '.join(map(str, allowed))}")
        if self._times and sizes != self._sizes:
            raise ValueError(f"fields {sizes} differ from those of the first frame, {self._sizes}")
        self._sizes = sizes
        return frame


class FabricFile:
    """A fabric.vtkhdf on disk; arrays are read when asked for, the file is closed in between.

    times: [s], (times,) float64; reference: [m], (nodes, 3) float32, the start shape; triangles: (triangles, 3) int64;
    part: (triangles,) int32, index into part_names; fields: names of point and cell fields.
    IntegrityError E-RES-007 if the file is not one.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with self.opened(self.path) as file:
            grid = file["VTKHDF"]
            if grid.attrs["Type"] != b"UnstructuredGrid" or grid.attrs["Version"][0] != VERSION[0]:
                raise KeyError(f"VTKHDF {grid.attrs['Type']} {grid.attrs['Version']}")
            self._frames = int(grid["Steps"].attrs["NSteps"])
            self.times = take(grid["Steps/Values"], 0, self._frames)
            self.triangles = take(grid["Connectivity"], 0, len(grid["Connectivity"])).reshape(-1, 3)
            self.part = take(grid["CellData/part"], 0, len(self.triangles))
            self.part_names = [name.decode() for name in file["billow/part_names"][()]]
            self.reference = take(file["billow/start_points"], 0, len(file["billow/start_points"]), (3,))
            if len(self.triangles) and not 0 <= self.triangles.min() <= self.triangles.max() < len(self.reference):
                raise ValueError("a triangle names a node that does not exist")
            if not (np.isfinite(self.times).all() and (np.diff(self.times) > 0.0).all()):
                raise ValueError("its times do not rise")
            begins = take(grid["Steps/PointOffsets"], 0, self._frames)
            if (begins != len(self.reference) * np.arange(self._frames)).any():
                raise ValueError("its frames have other numbers of nodes than its start shape")
            self.point_fields = tuple(grid.get("PointData", ()))
            self.cell_fields = tuple(name for name in grid["CellData"] if name != "part")

    def points(self, step: int) -> np.ndarray:
        """[m], (nodes, 3) float32: where the nodes are in frame `step`; -1 is the last."""
        nodes = len(self.reference)
        start = range(self._frames)[step] * nodes
        with self.opened(self.path) as file:
            return take(file["VTKHDF/Points"], start, nodes, (3,))

    def each_points(self) -> Iterator[np.ndarray]:
        """Where the nodes are in each frame, as `points`, one after the other."""
        nodes = len(self.reference)
        with self.opened(self.path) as file:
            for k in range(self._frames):
                yield take(file["VTKHDF/Points"], k * nodes, nodes, (3,))

    def point_data(self, name: str) -> np.ndarray:
        """(times, nodes) or (times, nodes, 3) float32."""
        return self._field(f"PointData/{name}", len(self.reference))

    def cell_data(self, name: str) -> np.ndarray:
        """(times, triangles) or (times, triangles, 3) float32."""
        return self._field(f"CellData/{name}", len(self.triangles))

    def unit(self, name: str) -> str:
        """Unit of a field; of one that does not say it, as this version writes it."""
        with self.opened(self.path) as file:
            grid = file["VTKHDF"]
            place = next(f"{kind}Data/{name}" for kind in ("Point", "Cell") if f"{kind}Data/{name}" in grid)
            return str(grid[place].attrs.get("units", UNITS.get(name, "-")))

    def _field(self, name: str, count: int) -> np.ndarray:
        with self.opened(self.path) as file:
            dataset = file[f"VTKHDF/{name}"]
            values = take(dataset, 0, self._frames * count, None)
            return values.reshape(self._frames, count, *dataset.shape[1:])

    @staticmethod
    @contextmanager
    def opened(path: Path) -> Iterator[h5py.File]:
        """A file of frames, to read. IntegrityError E-RES-007 for whatever goes wrong in the block."""
        try:
            require_file(path, LARGEST_FRAMES)
            with h5py.File(path, "r") as file:
                yield file
        except (KeyError, OSError, ValueError, IndexError, TypeError, AttributeError, RuntimeError) as error:
            raise UNREADABLE_MESH(path=path, why=error.args[0] if error.args else error) from error
