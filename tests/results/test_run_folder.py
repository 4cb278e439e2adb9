import json

import h5py
import numpy as np
import pytest
from small_run import TIMES, displacement, write_small_run

from billow.base.errors import BillowError, InputError, IntegrityError
from billow.results import run_file
from billow.results.histories import read_histories, write_histories
from billow.results.result import Result
from billow.results.run_file import FILES, read_run_file, write_run_file


@pytest.fixture
def run(tmp_path):
    return write_small_run(tmp_path / "run")


def test_a_result_gives_back_what_the_run_wrote(run):
    result = Result.open(run)
    assert (result.status, result.wall_seconds, result.case_toml) == ("completed", 2.5, {"amount": 1.0})
    np.testing.assert_array_equal(result.times, TIMES)
    np.testing.assert_array_equal(result.displacement, displacement(1.0))
    np.testing.assert_array_equal(result.contact_force[1, 0], np.float32([0.01, 0, 1]))
    np.testing.assert_array_equal(result.gauge_pressure[1], np.float32([0.01, 0.02]))
    np.testing.assert_array_equal(result.histories["pressure [Pa]"], 3 * TIMES)


def test_a_run_of_format_1_opens_with_its_pressure_under_the_name_of_today(run, monkeypatch):
    with h5py.File(run / "fabric.vtkhdf", "r+") as file:
        file.move("VTKHDF/CellData/gauge_pressure", "VTKHDF/CellData/pressure")
    monkeypatch.setattr(run_file, "FORMAT", 1)
    record = read_run_file(run, verify=False)
    write_run_file(run, {key: record[key] for key in ("status", "case_digest", "wall_seconds", "ledger")})
    np.testing.assert_array_equal(Result.open(run).gauge_pressure[1], np.float32([0.01, 0.02]))


def test_the_same_run_written_twice_is_the_same_bytes(tmp_path, run):
    assert read_run_file(write_small_run(tmp_path / "twin"))["files"] == read_run_file(run)["files"]


@pytest.mark.parametrize("name", FILES)
def test_any_change_to_a_file_is_found(run, name):
    path = run / name
    original = path.read_bytes()
    flipped = bytearray(original)
    flipped[len(flipped) // 2] ^= 1
    for damage in (bytes(flipped), original[:-1], original + b"\n"):
        path.write_bytes(damage)
        with pytest.raises(IntegrityError, match="E-RES-004"):
            read_run_file(run)
    path.unlink()
    with pytest.raises(IntegrityError, match="E-RES-005"):
        read_run_file(run)
    assert read_run_file(run, verify=False)["status"] == "completed"


def test_no_flipped_bit_of_run_json_goes_unseen(run):
    path, expected = run / "run.json", read_run_file(run)
    original = path.read_bytes()
    for bit in range(0, 8 * len(original), 7):
        flipped = bytearray(original)
        flipped[bit // 8] ^= 1 << bit % 8
        path.write_bytes(bytes(flipped))
        try:
            record = read_run_file(run)
        except BillowError:
            continue
        assert record == expected, f"bit {bit}"  # white space and the like


def test_a_folder_that_is_no_run(tmp_path):
    with pytest.raises(InputError, match="E-RES-001"):
        Result.open(tmp_path / "nothing")
    with pytest.raises(IntegrityError, match="E-RES-002"):
        Result.open(tmp_path)


def test_run_json_is_json_whatever_the_ledger_holds(tmp_path, run):
    ledger = {"energy": np.float64("nan"), "steps": np.int64(3)}
    write_run_file(run, {"status": "stopped", "case_digest": "00", "wall_seconds": 1.0, "ledger": ledger})
    text = (run / "run.json").read_text()
    assert "NaN" not in text
    assert json.loads(text)["ledger"] == read_run_file(run)["ledger"] == {"energy": None, "steps": 3}
    with pytest.raises(FileNotFoundError):
        write_run_file(tmp_path, {"status": "completed"})
    assert not (tmp_path / "run.json").exists()


def test_histories_come_back_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(1)
    columns = {"time [s]": np.arange(50) * 1e-5, "flow, vent [kg/s]": rng.normal(size=50) * 10.0 ** np.arange(-25, 25)}
    write_histories(tmp_path / "h.csv", columns)
    assert (tmp_path / "h.csv").read_text().splitlines()[0] == 'time [s],"flow, vent [kg/s]"'
    read = read_histories(tmp_path / "h.csv")
    assert list(read) == list(columns)
    for name, curve in columns.items():
        np.testing.assert_array_equal(read[name], curve)


def test_histories_without_units_or_of_other_lengths_are_refused(tmp_path):
    for columns in (
        {"time [s]": [0.0], "pressure": [0.0]},
        {"pressure [Pa]": [0.0], "time [s]": [0.0]},
        {"time [s]": [0.0, 1.0], "pressure [Pa]": [0.0]},
    ):
        with pytest.raises(ValueError, match="histor"):
            write_histories(tmp_path / "h.csv", columns)
    for text in (
        "",
        "time [s],a [-]\n0.0\n",
        "time [s],a [-]\n0.0,x\n",
        "a [-]\n1.0\n",
        "time [s],a [-],a [-]\n0,1,2\n",
    ):
        (tmp_path / "h.csv").write_text(text)
        with pytest.raises(IntegrityError, match="E-RES-008"):
            read_histories(tmp_path / "h.csv")
