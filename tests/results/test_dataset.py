import json

import numpy as np
import pytest
from small_run import POINTS, TIMES, TRIANGLES, displacement, write_small_run

from billow.base.errors import InputError, IntegrityError
from billow.base.quality import SHORT, VERDICTS
from billow.results.dataset import Dataset
from billow.results.dataset_files import (
    DatasetRecord,
    Parameter,
    mesh_sha256,
    write_dataset_file,
    write_design,
    write_split,
)
from billow.results.run_file import read_run_file, write_run_file
from billow.rom.learn.dataset import Dataset as Learnable

PARAMETERS = (Parameter("amount", "Rise", "m", 0.0, 10.0), Parameter("idle", "Nothing", "-", 0.0, 1.0))
DESIGN = {"0000": (1.0, 0.5), "0001": (2.0, 0.25), "0002": (3.0, 0.75), "0003": (4.0, 0.125)}


@pytest.fixture
def folder(tmp_path):
    for run, (amount, _) in DESIGN.items():
        write_small_run(tmp_path / "runs" / run, amount)
    write_design(tmp_path, PARAMETERS, DESIGN)
    write_split(tmp_path, ["0000", "0001", "0002"], ["0003"])
    mesh = mesh_sha256(POINTS, TRIANGLES)
    write_dataset_file(tmp_path, DatasetRecord("Small", 0.28, 7, mesh, tuple(TIMES), PARAMETERS))
    return tmp_path


def test_a_dataset_gives_designs_and_snapshots_in_the_order_asked(folder):
    dataset = Dataset.open(folder)
    assert (dataset.train, dataset.test, dataset.missing) == (("0000", "0001", "0002"), ("0003",), {})
    assert (dataset.title, dataset.reference_length, dataset.seed) == ("Small", 0.28, 7)
    assert dataset.parameters == PARAMETERS
    np.testing.assert_array_equal(dataset.times, TIMES[1:])  # the start is left out
    np.testing.assert_array_equal(dataset.reference, POINTS)
    np.testing.assert_array_equal(dataset.triangles, TRIANGLES)
    np.testing.assert_array_equal(dataset.design(["0002", "0000"]), [[3.0, 0.75], [1.0, 0.5]])
    snapshots = dataset.snapshots("displacement", ["0002", "0000"])
    assert (snapshots.dtype, snapshots.shape) == (np.float32, (2, 2, 4, 3))
    np.testing.assert_array_equal(snapshots, [displacement(3.0)[1:], displacement(1.0)[1:]])
    np.testing.assert_array_equal(dataset.snapshots("contact_force", ["0003"])[0, -1, 0], np.float32([0.02, 0, 4]))
    np.testing.assert_array_equal(dataset.computing_seconds(dataset.train), [2.5, 2.5, 2.5])
    assert dataset.design([]).shape == (0, 2)


def test_what_a_run_took_of_the_processors_counts_and_not_what_the_clock_said(folder):
    run = folder / "runs/0001"
    record = read_run_file(run)
    write_run_file(run, record | {"processor_seconds": 1.25})
    assert Dataset.open(folder).computing_seconds(["0001"]) == [1.25]
    write_run_file(run, record | {"processor_seconds": "much"})
    assert "0001" not in Dataset.open(folder).train


def test_runs_that_are_not_there_are_listed_with_the_reason(folder):
    (folder / "runs/0000").rename(folder / "elsewhere")
    (folder / "runs/0001/histories.csv").write_text("time [s]\n0.0\n")
    (folder / "runs/0003").rename(folder / "elsewhere3")
    (folder / "failed").mkdir()
    (folder / "failed/0003.json").write_text(json.dumps({"code": "E-NUM-007", "what": "NaN", "why": "element 3"}))
    dataset = Dataset.open(folder)
    assert (dataset.train, dataset.test) == (("0002",), ())
    assert dataset.missing["0000"] == "not run yet"
    assert "E-RES-004" in dataset.missing["0001"]
    assert dataset.missing["0003"] == "E-NUM-007: NaN; element 3"
    with pytest.raises(InputError, match="element 3"):
        dataset.snapshots("displacement", ["0003"])


@pytest.mark.parametrize("change", [{"points": 1.001 * POINTS}, {"times": TIMES * 1.001}])
def test_a_run_on_another_mesh_or_at_other_times_is_refused(folder, change):
    (folder / "runs/0001").rename(folder / "elsewhere")
    write_small_run(folder / "runs/0001", 2.0, **change)
    dataset = Dataset.open(folder)
    dataset.snapshots("displacement", ["0000"])
    with pytest.raises(IntegrityError, match="E-RES-012"):
        dataset.snapshots("displacement", ["0000", "0001"])


def test_unknown_names_and_damaged_files_get_a_clear_error(folder, tmp_path):
    dataset = Dataset.open(folder)
    with pytest.raises(InputError, match="E-RES-013"):
        dataset.snapshots("velocity", ["0000"])
    with pytest.raises(InputError, match="E-RES-014"):
        dataset.design(["9999"])
    for name, text in (
        ("split.toml", 'train = ["0000"]\ntest = ["0000"]\n'),
        ("design.csv", "run,amount [m],idle [-]\n0000,1.0\n"),
        ("dataset.toml", "format = 2\n"),
    ):
        original = (folder / name).read_text()
        (folder / name).write_text(text)
        with pytest.raises(IntegrityError, match="E-RES-011"):
            Dataset.open(folder)
        (folder / name).write_text(original)
    (folder / "dataset.toml").unlink()
    with pytest.raises(InputError, match="E-RES-010"):
        Dataset.open(folder)


def test_it_is_what_learning_needs(folder):
    assert isinstance(Dataset.open(folder), Learnable)


def judged(folder, run, **verdicts):
    """Give a run a verdict for each criterion."""
    criteria = [{"name": name.replace("_", " "), "verdict": verdict} for name, verdict in verdicts.items()]
    verdict = max(verdicts.values(), key=VERDICTS.index)
    run_folder = folder / "runs" / run
    write_run_file(run_folder, read_run_file(run_folder) | {"quality": {"verdict": verdict, "criteria": criteria}})


def test_a_run_in_doubt_is_left_out_and_one_that_only_ends_early_is_not(folder):
    judged(folder, "0000", **{SHORT: "REVIEW", "shooting_nodes": "PASS"})
    judged(folder, "0001", **{SHORT: "REVIEW", "shooting_nodes": "REVIEW"})
    judged(folder, "0002", shooting_nodes="PASS")
    judged(folder, "0003", shooting_nodes="FAIL")
    dataset = Dataset.open(folder)
    assert dataset.trusted == ("0000", "0002")
    assert dataset.left_out == {"0001": "REVIEW: shooting nodes"}  # 0003 is no training run
    assert dataset.doubts("0001") == (SHORT, "shooting nodes")
    assert dataset.doubts("0002") == ()


def test_a_missing_training_run_is_left_out_and_its_design_known(folder):
    (folder / "runs/0001").rename(folder / "elsewhere")
    dataset = Dataset.open(folder)
    assert dataset.left_out == {"0001": "not run yet"}
    np.testing.assert_array_equal(dataset.design(["0001"]), [[2.0, 0.25]])


def test_a_run_that_the_design_does_not_have_is_missing_and_has_no_place_to_lean_to(folder):
    write_split(folder, ["0000", "0001", "0002", "0009"], ["0003"])
    dataset = Dataset.open(folder)
    assert "design.csv does not" in dataset.missing["0009"]
    assert dataset.left_out == {}
