"""Frames of a run as a d3plot: read back by the library, and by the command that imports results."""

from __future__ import annotations

import numpy as np
import pytest
from test_dyna_results import write_runs

from billow.base.errors import InputError
from billow.results.dataset import Dataset
from billow.results.result import Result
from billow.results.vtkhdf import FabricWriter
from billow.study.d3plot_out import export_d3plot
from billow.study.dyna_run import DynaChoices, read_dyna
from billow.study.import_runs import import_runs


@pytest.fixture
def result(tmp_path):
    write_runs(tmp_path / "runs")
    import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    return Dataset.open(tmp_path / "study").result("0002")


def test_shells_count_their_nodes_from_one(result, tmp_path):
    dynars = pytest.importorskip("dynars")
    parts = export_d3plot(result, tmp_path / "d3plot", "t-mm-s")
    assert parts == {1: "fabric"}
    plot = dynars.D3plot(str(tmp_path / "d3plot"))
    cells, part = plot.shell_connectivity()
    np.testing.assert_array_equal(np.array(cells)[:, :3] - 1, result.triangles)
    np.testing.assert_array_equal(np.array(cells)[:, 3], np.array(cells)[:, 2])
    assert set(np.array(part).tolist()) == {1}
    np.testing.assert_allclose(plot.times(), result.times, rtol=1e-6)  # s in this system
    np.testing.assert_allclose(plot.initial_coordinates(), 1e3 * result.reference, rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize("units", ["kg-mm-ms", "kg-m-s"])
def test_what_is_written_is_imported_again(result, tmp_path, units):
    pytest.importorskip("dynars")
    (tmp_path / "out").mkdir()
    export_d3plot(result, tmp_path / "out" / "d3plot", units)
    read = read_dyna(tmp_path / "out", DynaChoices(units))
    np.testing.assert_array_equal(read.triangles, result.triangles)
    np.testing.assert_allclose(read.times, result.times, rtol=1e-6)
    np.testing.assert_allclose(read.positions - result.reference, result.displacement, atol=1e-7)


def test_velocities_go_along(result, tmp_path):
    dynars = pytest.importorskip("dynars")
    moving = np.full((len(result.reference), 3), [1.0, -2.0, 3.0])
    file, part = tmp_path / "fabric.vtkhdf", result.fabric.part
    with FabricWriter(file, result.reference, result.triangles, part, ["a"]) as frames:
        for time in (0.0, 1e-3):
            frames.append(time, result.reference, {"displacement": 0 * moving, "velocity": moving})
    (result.folder / "fabric.vtkhdf").write_bytes(file.read_bytes())
    export_d3plot(Result(result.folder, result.record), tmp_path / "d3plot", "kg-mm-ms")
    plot = dynars.D3plot(str(tmp_path / "d3plot"))
    found = np.array(plot.block(dynars.StateBlock.Velocity)).reshape(2, -1, 3)
    np.testing.assert_allclose(found[1], moving)  # mm/ms


def test_nothing_is_overwritten(result, tmp_path):
    (tmp_path / "d3plot").write_text("mine")
    with pytest.raises(InputError, match="E-RES-009"):
        export_d3plot(result, tmp_path / "d3plot")


def test_a_folder_is_no_place_for_a_file_and_nothing_else_is_left(result, tmp_path):
    pytest.importorskip("dynars")
    (tmp_path / "out" / "folder").mkdir(parents=True)
    with pytest.raises(InputError, match="E-RES-009"):
        export_d3plot(result, tmp_path / "out" / "folder")
    export_d3plot(result, tmp_path / "out" / "d3plot")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"folder", "d3plot"}
