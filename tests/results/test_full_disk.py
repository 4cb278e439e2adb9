"""A disk that is full, at any byte of a file: an error, nothing half-written, and HDF5 closes in order."""

from __future__ import annotations

import errno
import io
import os

import h5py
import numpy as np
import pytest

from billow.results import hdf5_file
from billow.results.cloud import CloudWriter
from billow.results.vtkhdf import FabricFile, FabricWriter

HELD = h5py.h5f.OBJ_FILE | h5py.h5f.OBJ_GROUP | h5py.h5f.OBJ_DATASET
POINTS, TRIANGLES = np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]])


class Disk(io.FileIO):
    """A file on a disk with so many free bytes; like a real one it takes what fits, and refuses the rest."""

    free = 0

    def write(self, data):
        taken = len(data) if self.tell() + len(data) <= self.free else max(self.free - self.tell(), 0)
        if not taken:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(data[:taken])


def write_fabric(path):
    with FabricWriter(path, POINTS, TRIANGLES, [0, 0], ["square"]) as frames:
        for time in range(130):  # more than are written at once
            frames.append(time, POINTS + time, {"displacement": np.full((4, 3), time)}, {"pressure": [time, 0]})


def write_cloud(path):
    with CloudWriter(path) as frames:
        for time in range(1, 9):
            frames.points(time, np.ones((99 * time, 3)), {"temperature": np.arange(99 * time)})


@pytest.mark.parametrize("write", [write_fabric, write_cloud])
def test_a_disk_that_is_full_at_any_byte(tmp_path, monkeypatch, write):
    write(tmp_path / "whole")
    size = (tmp_path / "whole").stat().st_size
    monkeypatch.setattr(hdf5_file, "open", lambda path, mode, buffering: Disk(path, "x+"), raising=False)
    for free in (*range(0, size, size // 20), size - 1):
        monkeypatch.setattr(Disk, "free", free)
        with pytest.raises(OSError, match="No space left") as caught:
            write(tmp_path / "full")
        assert caught.value.filename == str(tmp_path / "full")
        assert os.listdir(tmp_path) == ["whole"]
        # What HDF5 holds open it flushes when the process ends, and crashes.
        assert h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, HELD) == 0
    monkeypatch.setattr(Disk, "free", size)
    write(tmp_path / "fits")
    assert (tmp_path / "fits").read_bytes() == (tmp_path / "whole").read_bytes()


def test_frames_are_there_when_the_file_is(tmp_path):
    with FabricWriter(tmp_path / "fabric.vtkhdf", POINTS, TRIANGLES, [0, 0], ["square"]) as frames:
        frames.append(0.0, POINTS)
        assert not (tmp_path / "fabric.vtkhdf").exists()
    np.testing.assert_array_equal(FabricFile(tmp_path / "fabric.vtkhdf").points(0), POINTS)
    with pytest.raises(FileExistsError):
        FabricWriter(tmp_path / "fabric.vtkhdf", POINTS, TRIANGLES, [0, 0], ["square"])
