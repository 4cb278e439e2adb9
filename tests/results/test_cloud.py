"""Frames of points and boxes that come and go, read back with h5py and, where it is installed, with VTK."""

import h5py
import numpy as np
import pytest

from billow.results.cloud import CloudWriter

COUNTS = (3, 0, 5)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "gas.vtkhdf"
    with CloudWriter(path) as cloud:
        for k, n in enumerate(COUNTS):
            centres = 10.0 * k + np.arange(3.0 * n).reshape(n, 3)
            fields = {"pressure": np.arange(n) + k, "velocity": np.ones((n, 3)) * k}
            cloud.boxes(0.1 * k, centres, np.full((n, 3), 0.5), fields)
    return path


def test_every_frame_begins_where_the_one_before_ends(path):
    with h5py.File(path) as file:
        grid, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        np.testing.assert_array_equal(grid["NumberOfCells"], COUNTS)
        np.testing.assert_array_equal(steps["CellOffsets"][:, 0], [0, 3, 3])
        np.testing.assert_array_equal(steps["PointOffsets"], [0, 24, 24])
        np.testing.assert_array_equal(steps["CellDataOffsets/pressure"], [0, 3, 3])
        assert len(grid["Offsets"]) == sum(COUNTS) + len(COUNTS)
        np.testing.assert_array_equal(grid["CellData/pressure"][3:], [2, 3, 4, 5, 6])


def test_vtk_sees_boxes_of_the_right_size_at_every_time(path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    for k in (0, 2):
        reader.SetStep(k)
        reader.Update()
        grid = reader.GetOutputDataObject(0)
        assert grid.GetNumberOfCells() == COUNTS[k]
        assert grid.GetCell(1).GetBounds() == pytest.approx(
            [v for c in 10.0 * k + np.array([3.0, 4.0, 5.0]) for v in (c - 0.25, c + 0.25)]
        )
        assert grid.GetCellData().GetArray("pressure").GetValue(1) == 1 + k


def test_points_are_vertices(tmp_path):
    with CloudWriter(tmp_path / "particles.vtkhdf") as cloud:
        cloud.points(0.0, np.eye(3), {"species": np.arange(3)})
    with h5py.File(tmp_path / "particles.vtkhdf") as file:
        assert set(file["VTKHDF/Types"]) == {1}
        np.testing.assert_array_equal(file["VTKHDF/Points"], np.eye(3, dtype=np.float32))
