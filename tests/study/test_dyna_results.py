"""Results of LS-DYNA become a dataset: d3plot and binout written here by the library that reads them."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.design.table import respond
from billow.results.dataset import Dataset
from billow.results.histories import read_histories
from billow.study.import_runs import import_runs
from billow.study.responses import StudyResponse

N = 5


def write_runs(folder, parts=(7, 9), shift=1) -> np.ndarray:
    """Three runs of a sheet of quads and one triangle that rises; positions [mm] of the last."""
    dynars = pytest.importorskip("dynars")
    x, y = (a.ravel() for a in np.meshgrid(np.arange(N) * 100.0, np.arange(N) * 100.0))
    start = np.column_stack([x, y, np.zeros(N * N)])
    quads = np.array([[j * N + i, j * N + i + 1, j * N + i + N + 1, j * N + i + N] for j in range(4) for i in range(4)])
    quads[3, 3] = quads[3, 2]  # a triangle, as solvers write it
    rows = "run,flow [kg/s]\n"
    for run in range(4):
        place = folder / f"{run:04d}"
        place.mkdir(parents=True)
        writer = dynars.D3plotWriter(start.astype(np.float32))
        writer.add_shells(quads + shift, np.repeat([1, 2], 8))
        writer.set_ids(part_ids=np.array(parts, np.int32))
        for frame in range(5):
            moved = start + [0.0, 0.0, 10.0 * frame * (1 + run)] * np.sin(np.pi * x / 400.0)[:, None]
            writer.add_state(5.0 * frame, moved.astype(np.float32))
        writer.write(str(place / "d3plot"))
        rows += f"{run:04d},{1 + run}\n"
    (folder / "runs.csv").write_text(rows)
    return moved


def test_a_study_of_ls_dyna_becomes_a_dataset(tmp_path):
    moved = write_runs(tmp_path / "runs")
    train, test = import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    assert (train, test) == (3, 1)
    run = Dataset.open(tmp_path / "study").result("0003")
    assert np.allclose(run.times, [0.0, 5e-3, 10e-3, 15e-3, 20e-3])
    assert np.allclose(run.reference + run.displacement[4], 1e-3 * moved, atol=1e-7)
    assert len(run.triangles) == 31


def test_the_bag_is_the_parts_that_are_said(tmp_path):
    write_runs(tmp_path / "runs")
    import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms", parts=(9,))
    assert len(Dataset.open(tmp_path / "study").result("0000").triangles) == 16
    with pytest.raises(InputError, match=r"no shell belongs to part 8; parts with shells are 7, 9"):
        import_runs(tmp_path / "runs", tmp_path / "other", units="kg-mm-ms", parts=(8,))


@pytest.mark.parametrize("shift", [0, 3])
def test_shells_that_count_wrongly_are_refused_where_it_shows(tmp_path, shift):
    """Connectivity of a d3plot counts from 1."""
    write_runs(tmp_path / "runs", shift=shift)
    with pytest.raises(InputError, match="E-STU-027"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")


def test_damage_and_units_that_nobody_said_are_refused(tmp_path):
    write_runs(tmp_path / "runs")
    with pytest.raises(InputError, match="E-STU-034"):
        import_runs(tmp_path / "runs", tmp_path / "study")
    with pytest.raises(InputError, match="E-UNIT-001"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-m-s")
    path = tmp_path / "runs" / "0001" / "d3plot"
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(InputError, match=r"E-STU-02[78]"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    assert not (tmp_path / "study").exists()


def test_histories_of_the_airbag_come_from_binout(tmp_path):
    dynars = pytest.importorskip("dynars")
    write_runs(tmp_path / "runs")
    for run in range(4):
        editor = dynars.BinoutEditor()
        for frame, (time, pressure) in enumerate([(0.0, 1e-4), (10.0, 1.3e-4), (20.0, 1.2e-4)], 1):
            for name, value in (("time", time), ("pressure", pressure), ("volume", 5e7)):
                editor.set(["abstat", f"d{frame:06d}", name], np.array([value]))
        editor.set(["abstat", "metadata", "ids"], np.array([1]))
        editor.write(str(tmp_path / "runs" / f"{run:04d}" / "binout0000"))
    import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    found = read_histories(tmp_path / "study" / "runs" / "0000" / "histories.csv")
    assert np.allclose(found["time [s]"], [0.0, 0.01, 0.02])
    assert np.allclose(found["pressure [Pa]"], [1.0e5, 1.3e5, 1.2e5])
    assert np.allclose(found["volume [m^3]"], 0.05)


def write_histories(folder, runs=4, times=(0.0, 10.0, 20.0)):
    """A node, a rigid part that is braked to 0 and a contact with two sides, beside the airbag; kg, mm, ms."""
    build = pytest.importorskip("dynars").build_series
    t = np.array(times)
    for run in range(runs):
        speed = (1 + run) * (t - 20.0)[:, None]
        editor = build("abstat", [1], {"pressure": np.full((len(t), 1), 1e-4 * (1 + run))}, times=t)
        editor = build("nodout", [11, 12], {"z_displacement": np.column_stack([t, 2 * t])}, times=t, editor=editor)
        editor = build("rbdout", [7], {f"global_v{x}": speed * (x == "z") for x in "xyz"}, times=t, editor=editor)
        build("rcforc", [3, 3], {"z_force": np.column_stack([t, -t])}, times=t, editor=editor)
        editor.write(str(folder / f"{run:04d}" / "binout0000"))


def test_histories_of_nodes_bodies_and_contacts_come_from_binout(tmp_path):
    write_runs(tmp_path / "runs")
    write_histories(tmp_path / "runs")
    import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    found = read_histories(tmp_path / "study" / "runs" / "0001" / "histories.csv")
    assert found["pressure [Pa]"] == pytest.approx([2e5] * 3)
    assert found["node_12_displacement_z [m]"] == pytest.approx([0.0, 0.02, 0.04])
    assert found["rigid_7_velocity_z [m/s]"] == pytest.approx([-40.0, -20.0, 0.0])
    assert found["contact_3_force_z [N]"] == pytest.approx([0.0, 1e4, 2e4])


def test_a_design_study_measures_what_was_imported(tmp_path):
    write_runs(tmp_path / "runs")
    write_histories(tmp_path / "runs")
    import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    slowest = StudyResponse(name="slowest", measure="least", of="rigid_7", quantity="velocity.z")
    rows = respond(tmp_path / "study", [slowest]).csv().splitlines()
    values = {row.split(",")[0]: float(row.split(",")[-1]) for row in rows[1:]}
    assert values == pytest.approx({f"{run:04d}": -20.0 * (1 + run) for run in range(4)})


def test_histories_at_other_times_are_refused(tmp_path):
    write_runs(tmp_path / "runs")
    write_histories(tmp_path / "runs")
    build = pytest.importorskip("dynars").build_series
    editor = build("abstat", [1], {"pressure": np.ones((3, 1))}, times=[0.0, 1.0, 2.0])
    build("rbdout", [7], {"global_vz": np.ones((2, 1))}, times=[0.0, 2.0], editor=editor)
    editor.write(str(tmp_path / "runs" / "0002" / "binout0000"))
    with pytest.raises(InputError, match=r"E-STU-027(.|\n)*rbdout has other times"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
    (tmp_path / "runs" / "0000" / "binout0000").rename(tmp_path / "runs" / "0000" / "abstat")
    with pytest.raises(InputError, match=r"E-STU-027(.|\n)*abstat holds no state"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")


def test_without_the_library_the_remedy_is_to_install_it(tmp_path, monkeypatch):
    (tmp_path / "0000").mkdir()
    (tmp_path / "0000" / "d3plot").write_bytes(b"x")
    (tmp_path / "runs.csv").write_text("run,flow [kg/s]\n0000,1\n0001,2\n0002,3\n")
    monkeypatch.setitem(sys.modules, "dynars", None)
    with pytest.raises(InputError, match=r"E-STU-033(.|\n)*billow\[dyna\]"):
        import_runs(tmp_path, tmp_path / "study", units="kg-mm-ms")
