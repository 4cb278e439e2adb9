"""Cells of lattices, read back as images with h5py and, where it is installed, with VTK."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from billow.results.lattice import HIDDEN, LatticeWriter, extents

SIZE = 0.25
CELLS = ([(0, 0, 0), (1, 0, 0)], [(1, 0, 0), (1, 2, 0)], [(3, 0, 1)])
"""Of the first chamber in each frame; the second one has a cell in the second frame only."""


def frame(k):
    corners = np.array([*CELLS[k], *([(10, 10, 10)] if k == 1 else [])])
    n = len(corners)
    return {
        "centre": np.float32((corners + 0.5) * SIZE - 1.0),
        "size": np.full((n, 3), SIZE, np.float32),
        "chamber": np.float32(corners[:, 0] == 10),
        "pressure": np.float32(1e5 + corners @ [1.0, 10.0, 100.0] + 1000.0 * k),
        "velocity": np.float32(corners),
    }


@pytest.fixture
def path(tmp_path) -> Path:
    path, frames = tmp_path / "gas.vtkhdf", [frame(k) for k in range(3)]
    with LatticeWriter(path, ("front", "rear", "none"), extents(frames, 3)) as images:
        for k, cells in enumerate(frames):
            images.append(0.1 * k, cells)
    return path


def test_each_chamber_is_the_box_about_its_cells(path):
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        assert list(root["Assembly"]) == ["front", "rear"]  # nothing of a chamber without cells
        front, rear = root["front"], root["rear"]
        assert front.attrs["WholeExtent"].tolist() == [0, 4, 0, 3, 0, 2]
        assert rear.attrs["WholeExtent"].tolist() == [0, 1] * 3
        np.testing.assert_allclose(rear.attrs["Origin"], 10 * SIZE - 1.0)
        np.testing.assert_allclose(front["Steps/Values"], [0.0, 0.1, 0.2])
        assert front["CellData/pressure"].shape == (3, 2, 3, 4)  # time, z, y, x
        assert front["CellData/velocity"].shape == (3, 2, 3, 4, 3)
        assert front["CellData/pressure"].attrs["units"] == "Pa"
        hidden = front["CellData/vtkGhostType"][()]
        assert [(where == 0).sum() for where in hidden] == [2, 2, 1]
        assert set(hidden.ravel()) == {0, HIDDEN}
        assert front["CellData/pressure"][1, 0, 2, 1] == 1e5 + 21.0 + 1000.0
        assert front["CellData/pressure"][2][hidden[2] == 0] == 1e5 + 103.0 + 2000.0
        assert front["CellData/pressure"][2][hidden[2] > 0].max() == 0.0
        assert [(where == 0).sum() for where in rear["CellData/vtkGhostType"]] == [0, 1, 0]


def test_vtk_reads_images_with_the_right_cells_at_every_time(path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK is not installed")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    for k in (0, 2, 1):
        reader.SetStep(k)
        reader.Update()
        assert reader.GetNumberOfSteps() == 3
        both = reader.GetOutputDataObject(0)
        assert both.GetNumberOfPartitionedDataSets() == 2
        image = both.GetPartitionedDataSet(0).GetPartition(0)
        assert image.GetClassName() == "vtkImageData"
        cells = frame(k)
        seen = [c for c in range(image.GetNumberOfCells()) if image.IsCellVisible(c)]
        assert len(seen) == len(CELLS[k])
        wanted = {tuple(c): p for c, p in zip(cells["centre"].tolist(), cells["pressure"].tolist(), strict=True)}
        for c in seen:
            bounds = np.reshape(image.GetCell(c).GetBounds(), (3, 2))
            assert bounds[:, 1] - bounds[:, 0] == pytest.approx([SIZE] * 3)
            assert image.GetCellData().GetArray("pressure").GetValue(c) == wanted[tuple(bounds.mean(axis=1))]


def test_an_interrupted_file_is_none(tmp_path):
    with pytest.raises(RuntimeError), LatticeWriter(tmp_path / "gas.vtkhdf", ("a",), extents([frame(0)], 1)):
        raise RuntimeError
    assert not list(tmp_path.iterdir())
