"""What a run leaves of a gas that is known place by place: boxes, particles, sensors; and the same after a restart."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.run.simulate import simulate

SEEN = {
    "gas": {"model": "corpuscular", "particles": 5000},
    "bag": {"element_size": 0.05, "initial_gap": 0.03},
    "run": {
        "guard_crossings": True,
        "end_time": 0.002,
        "frames": 2,
        "histories_per_frame": 4,
        "particle_times": [0.0, 0.0005, 0.0011],
        "sensors": [
            {"name": "mouth", "position": [0.0, 0.0, 0.01]},
            {"name": "aside", "position": [0.0, 0.0, "-30 cm"]},
        ],
    },
}

ELSEWHERE = {("fabric.vtkhdf", "torn_at"), ("gas.vtkhdf", "vtkGhostType"), ("gas.vtkhdf", "volume_fraction")}
"""Documented fields that only tear seams and the mesh gas write."""


@pytest.fixture(scope="module")
def seen(deploy, tmp_path_factory):
    return deploy(Case.from_dict(SEEN), tmp_path_factory.mktemp("seen") / "run")


def test_boxes_are_there_at_every_frame(seen):
    with h5py.File(seen.folder / "gas.vtkhdf") as file:
        grid = file["VTKHDF"]
        np.testing.assert_allclose(grid["Steps/Values"], seen.times)
        assert (grid["NumberOfCells"][()] > 0).all()
        assert set(grid["CellData"]) == {"pressure", "temperature", "density", "velocity", "particles"}
        first = grid["NumberOfCells"][0]
        temperature, number = (grid[f"CellData/{name}"][:first] for name in ("temperature", "particles"))
        told = number > 1  # a single particle flies in step with itself
        mean = np.average(temperature[told], weights=number[told])
        assert mean == pytest.approx(295.0, rel=0.1)  # of some thousand particles of air, and the store of each varies
    assert {"gas_temperature", "gas_density", "gas_velocity"} <= set(seen.fabric.cell_fields)
    assert seen.fabric.cell_data("gas_temperature")[-1].mean() == pytest.approx(
        seen.histories["temperature [K]"][-1], rel=0.15
    )


def test_particles_are_there_at_the_rows_after_the_wanted_times(seen):
    with h5py.File(seen.folder / "particles.vtkhdf") as file:
        grid = file["VTKHDF"]
        np.testing.assert_allclose(grid["Steps/Values"], [0.0, 0.0005, 0.00125])
        counts = grid["NumberOfCells"][()]
        assert ((counts > 0) & (counts < 5000)).all()
        assert set(grid["CellData"]) == {"velocity", "internal_energy", "species", "chamber"}


def test_sensors_are_columns(seen):
    curves = seen.histories
    assert (curves["aside_gas_pressure [Pa]"] == 101325.0).all()
    assert curves["mouth_gas_temperature [K]"][-1] > 305.0
    assert curves["mouth_gas_density [kg/m^3]"][0] == pytest.approx(1.19, rel=0.3)
    assert np.isfinite([curves[f"mouth_gas_velocity_{axis} [m/s]"] for axis in "xyz"]).all()


def test_escaped_particles_are_in_the_books_and_in_the_log(seen):
    count = seen.ledger["leaked_particles"]
    assert f"particles found outside and put back: {count:.0f}\n" in (seen.folder / "solver.log").read_text()
    assert seen.ledger["leaked_particles_share"] == count / 5000


def test_a_restart_leaves_the_same_pictures(seen, tmp_path):
    again = simulate(Case.from_dict(SEEN), tmp_path / "run", threads=1)
    for name in ("fabric.vtkhdf", "gas.vtkhdf", "particles.vtkhdf", "histories.csv"):
        assert again.record["files"][name] == seen.record["files"][name], name


def test_boxes_can_be_left_out_and_uniform_pressure_has_none(tmp_path):
    case = Case.from_dict(SEEN).vary({"run.gas_frames": False, "run.particle_times": [], "run.end_time": 1e-4})
    names = {path.name for path in simulate(case, tmp_path / "one").folder.iterdir()}
    assert not {"gas.vtkhdf", "particles.vtkhdf"} & names
    uniform = Case.from_dict(SEEN).vary({"gas.model": "uniform-pressure"})
    result = simulate(uniform, tmp_path / "two")
    assert not {"gas.vtkhdf", "particles.vtkhdf"} & {path.name for path in result.folder.iterdir()}
    assert "sensors and particles are not written" in (result.folder / "solver.log").read_text()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"run.particle_times": [0.003]}, "after end_time"),
        ({"run.sensors": [SEEN["run"]["sensors"][0]] * 2}, "two sensors are called mouth"),
        ({"run.sensors": [{"name": "far", "position": [0, 0, 300]}]}, "outside the plausible range"),
    ],
)
def test_what_cannot_be_recorded_is_refused(changes, words):
    with pytest.raises(InputError, match="E-CASE-005") as caught:
        Case.from_dict(SEEN).vary(changes)
    assert words in str(caught.value)


def test_every_field_has_its_unit_beside_it_as_documented(seen):
    """ParaView shows names; the unit of each is in the file, and in docs/histories.md with what it means."""
    page = (Path(__file__).parents[1] / "docs" / "histories.md").read_text(encoding="utf-8")
    documented, file = {}, ""
    for row in re.findall(r"^\| (`\w+\.vtkhdf`)? ?\| `(\w+)` \| (\S+) \|", page, flags=re.MULTILINE):
        file = row[0].strip("`") or file
        documented[file, row[1]] = row[2]
    written = {}
    for path in set(seen.folder.glob("*.vtkhdf")) - {seen.folder / "scene.vtkhdf"}:  # which has links alone
        with h5py.File(path) as opened:
            grid = opened["VTKHDF"]
            fields = {**grid.get("PointData", {}), **grid["CellData"], "Points": grid["Points"]}
            written |= {(path.name, name): field.attrs["units"] for name, field in fields.items()}
    for clouds in ("gas.vtkhdf", "particles.vtkhdf"):
        written.pop((clouds, "Points"))
    assert written == {field: unit for field, unit in documented.items() if field not in ELSEWHERE}
