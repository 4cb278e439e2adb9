import h5py
import numpy as np
import pytest
from small_run import POINTS, TIMES, TRIANGLES, displacement, write_small_run

from billow.base.errors import IntegrityError
from billow.results import vtkhdf
from billow.results.vtkhdf import FabricFile, FabricWriter


@pytest.fixture
def path(tmp_path):
    return write_small_run(tmp_path / "run") / "fabric.vtkhdf"


def test_what_is_written_is_read(path):
    fabric = FabricFile(path)
    np.testing.assert_array_equal(fabric.times, TIMES)
    np.testing.assert_array_equal(fabric.triangles, TRIANGLES)
    np.testing.assert_array_equal(fabric.part, [0, 1])
    assert fabric.part_names == ["front", "rear"]
    np.testing.assert_array_equal(fabric.reference, POINTS)
    np.testing.assert_array_equal(fabric.points(-1), POINTS + displacement(1.0)[-1])
    np.testing.assert_array_equal(fabric.point_data("displacement"), displacement(1.0))
    np.testing.assert_array_equal(fabric.cell_data("gauge_pressure"), np.float32([[0, 0], [0.01, 0.02], [0.02, 0.04]]))
    assert fabric.point_data("displacement").dtype == fabric.points(0).dtype == np.float32


def test_the_mesh_is_stored_once_and_every_frame_says_where_it_begins(path):
    with h5py.File(path) as file:
        grid, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        assert grid.attrs["Type"] == b"UnstructuredGrid"
        assert tuple(grid.attrs["Version"]) == (2, 2)
        assert steps.attrs["NSteps"] == 3
        assert grid["Connectivity"].shape == (6,)
        assert grid["Offsets"][:].tolist() == [0, 3, 6]
        assert grid["Types"][:].tolist() == [5, 5]
        assert grid["Points"].shape == (12, 3)
        assert steps["PointOffsets"][:].tolist() == [0, 4, 8]
        assert steps["PointDataOffsets/displacement"][:].tolist() == [0, 4, 8]
        assert steps["CellDataOffsets/gauge_pressure"][:].tolist() == [0, 2, 4]
        assert steps["CellDataOffsets/part"][:].tolist() == [0, 0, 0]
        assert steps["CellOffsets"][:].tolist() == steps["ConnectivityIdOffsets"][:].tolist() == [[0], [0], [0]]
        assert steps["PartOffsets"][:].tolist() == [0, 0, 0]


def test_vtk_reads_it(path):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    steps = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    np.testing.assert_array_equal(steps, TIMES)
    for frame in (2, 0, 1):  # out of order: offsets, not the reader's memory, must find the frame
        reader.UpdateTimeStep(TIMES[frame])
        grid = reader.GetOutput()
        moved = displacement(1.0)[frame]
        assert grid.GetNumberOfCells() == 2
        assert [grid.GetCell(1).GetPointId(corner) for corner in range(3)] == [0, 2, 3]
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), np.float32(POINTS + moved))
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPointData().GetArray("displacement")), moved)
        pressure = vtk_to_numpy(grid.GetCellData().GetArray("gauge_pressure"))
        np.testing.assert_array_equal(pressure, np.float32([TIMES[frame], 2 * TIMES[frame]]))
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray("part")), [0, 1])


def test_frames_beyond_one_block_are_all_there(tmp_path, monkeypatch):
    monkeypatch.setattr(vtkhdf, "FRAMES_AT_ONCE", 2)
    with FabricWriter(tmp_path / "fabric.vtkhdf", POINTS, TRIANGLES, [0, 0], ["bag"]) as fabric:
        for k in range(5):
            fabric.append(float(k), POINTS + k, {"displacement": 0 * POINTS + k})
    fabric = FabricFile(tmp_path / "fabric.vtkhdf")
    np.testing.assert_array_equal(fabric.times, np.arange(5.0))
    np.testing.assert_array_equal(fabric.point_data("displacement")[:, 0, 0], np.arange(5.0))


def test_a_refused_frame_changes_nothing(tmp_path):
    path = tmp_path / "fabric.vtkhdf"
    with FabricWriter(path, POINTS, TRIANGLES, [0, 0], ["bag"]) as fabric:
        fabric.append(0.0, POINTS, {"displacement": 0 * POINTS})
        with pytest.raises(ValueError, match="does not come after"):
            fabric.append(0.0, POINTS, {"displacement": 0 * POINTS})
        with pytest.raises(ValueError, match="PointData/displacement"):
            fabric.append(1.0, POINTS, {"displacement": POINTS[:2]})
        with pytest.raises(ValueError, match="differ from those of the first frame"):
            fabric.append(1.0, POINTS)
        fabric.append(2.0, POINTS + 2, {"displacement": 0 * POINTS + 2})
    np.testing.assert_array_equal(FabricFile(path).times, [0.0, 2.0])
    np.testing.assert_array_equal(FabricFile(path).point_data("displacement")[1], 0 * POINTS + 2)


def test_files_that_are_none_of_ours_get_a_clear_error(tmp_path, path):
    text = tmp_path / "text.vtkhdf"
    text.write_text("hello")
    with h5py.File(tmp_path / "other.vtkhdf", "w") as file:
        file["a"] = 1
    for wrong in (text, tmp_path / "other.vtkhdf", tmp_path / "none.vtkhdf"):
        with pytest.raises(IntegrityError, match="E-RES-007"):
            FabricFile(wrong)
    with pytest.raises(IntegrityError, match="E-RES-007"):
        FabricFile(path).point_data("temperature")
