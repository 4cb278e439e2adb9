"""gas.vtkhdf of a gas in the cells of a lattice: for each chamber an image, the box about all its cells in all frames
(docs/architecture.md, Frames)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import h5py
import numpy as np

from billow.results.vtkhdf import UNITS, VERSION, FramesWriter

HIDDEN = 32
"""VTK's mark of a cell that is not shown."""


class Extent:
    """Cells of an edge `size` [m] between the corners low and high [m], (3,)."""

    def __init__(self):
        self.low, self.high, self.size = np.full(3, np.inf), np.full(3, -np.inf), 0.0

    def add(self, centres: np.ndarray, size: np.ndarray) -> None:
        if len(centres):
            self.low = np.minimum(self.low, (centres - 0.5 * size).min(axis=0))
            self.high = np.maximum(self.high, (centres + 0.5 * size).max(axis=0))
            self.size = float(size[0, 0])

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along x, y, z; none if there are none."""
        return tuple(np.rint((self.high - self.low) / self.size).astype(int).tolist()) if self.size else ()


def extents(frames: Iterable[Mapping[str, np.ndarray]], chambers: int) -> list[Extent]:
    """Of the cells of each chamber in all frames, which are as in `LocalGas.cells` of a gas on a lattice."""
    found = [Extent() for _ in range(chambers)]
    for cells in frames:
        for c, extent in enumerate(found):
            mine = cells["chamber"] == c
            extent.add(cells["centre"][mine], cells["size"][mine])
    return found


class LatticeWriter(FramesWriter):
    """Writes frames of the cells of each chamber, as `FramesWriter`.

    names and extents: of the chambers, as by `extents`.
    """

    def __init__(self, path: str | Path, names: Iterable[str], extents: list[Extent]):
        super().__init__(path, track_order=True)  # readers ask for groups in the order in which they were made
        root = self._file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
        root.attrs.create("Type", np.bytes_("PartitionedDataSetCollection"))
        tree = root.create_group("Assembly", track_order=True)
        self._images: dict[int, tuple[h5py.Group, Extent]] = {}
        for c, (name, extent) in enumerate(zip(names, extents, strict=True)):
            if not extent.shape:
                continue
            image = root.create_group(name)
            image.attrs.create("Type", np.bytes_("ImageData"))
            image.attrs["Version"] = np.array(VERSION, dtype=np.int64)
            image.attrs["Index"] = np.int64(len(self._images))
            image.attrs["WholeExtent"] = np.array([end for n in extent.shape for end in (0, n)], dtype=np.int64)
            image.attrs["Origin"], image.attrs["Spacing"] = extent.low, np.full(3, extent.size)
            image.attrs["Direction"] = np.eye(3).ravel()
            tree[name] = h5py.SoftLink(image.name)
            self._images[c] = image, extent

    def append(self, time: float, cells: Mapping[str, np.ndarray]) -> None:
        """Add a frame at `time` [s]; cells: as in `LocalGas.cells`. What is no cell of a chamber is hidden in its
        image, and zero."""
        self._times.append(float(time))
        for c, (image, extent) in self._images.items():
            mine = cells["chamber"] == c
            at = np.floor((cells["centre"][mine] - extent.low) / extent.size).astype(np.int64)
            place = tuple(at.T[::-1])  # an image has x last
            hidden = np.full(extent.shape[::-1], HIDDEN, np.uint8)
            hidden[place] = 0
            self._extend(image, "vtkGhostType", hidden)
            for name, values in cells.items():
                if name not in ("centre", "size", "chamber"):
                    whole = np.zeros((*extent.shape[::-1], *values.shape[1:]), np.float32)
                    whole[place] = values[mine]
                    self._extend(image, name, whole)
        self._disk.check()

    def _extend(self, image: h5py.Group, name: str, frame: np.ndarray) -> None:
        place = f"CellData/{name}"
        if place not in image:
            image.create_dataset(
                place, shape=(0, *frame.shape), maxshape=(None, *frame.shape), dtype=frame.dtype,
                chunks=(1, *frame.shape), compression="gzip", compression_opts=1, shuffle=True,
            )  # fmt: skip
            image[place].attrs["units"] = UNITS.get(name, "-")
        dataset = image[place]
        dataset.resize(len(dataset) + 1, axis=0)
        dataset[-1] = frame

    def close(self) -> None:
        """Write the times, and close the file."""
        for image, _ in self._images.values():
            steps = image.create_group("Steps")
            steps.attrs["NSteps"] = np.int64(len(self._times))
            steps["Values"] = np.array(self._times)
            for name in image["CellData"]:
                steps[f"CellDataOffsets/{name}"] = np.arange(len(self._times))
        self._file.close()
        self._disk.publish()
