"""A run or study from a mesh has all it needs in its folder: it can be moved, and goes on without its origin."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
import tomli_w

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.results.result import Result
from billow.run.interrupts import STOP_FILE, RunInterrupted
from billow.run.simulate import resume, simulate
from billow.study.study import Study

sys.path.insert(0, str(Path(__file__).parents[2]))
from trust.bits import stretched_mesh

STUDY = """
title = "Pillows"
case = "case.toml"
seed = 1
train = 2
test = 1
reference_length = 0.2
[[parameters]]
name = "thickness"
label = "Thickness"
unit = "m"
low = 3e-4
high = 4e-4
keys = ["fabric.thickness"]
"""


@pytest.fixture
def case_file(tmp_path):
    """A case beside its two mesh files, of which it knows the names only."""
    place = tmp_path / "mine"
    place.mkdir()
    told = stretched_mesh(place)
    told["bag"] |= {"start": "start.vtk", "reference": "reference.vtk"}
    told["run"] = {"end_time": 4e-4, "frames": 2, "histories_per_frame": 1}
    (place / "case.toml").write_text(tomli_w.dumps(told))
    return place / "case.toml"


def test_a_run_that_was_moved_is_resumed_without_its_mesh(case_file, tmp_path):
    case = Case.load(case_file)
    straight = simulate(case, tmp_path / "straight", threads=1)
    partial = tmp_path / "run.partial"
    with pytest.raises(RunInterrupted):
        simulate(case, tmp_path / "run", progress=lambda progress: (partial / STOP_FILE).touch(), threads=1)
    shutil.rmtree(case_file.parent)
    (tmp_path / "elsewhere").mkdir()
    partial.rename(tmp_path / "elsewhere" / "run.partial")
    resumed = resume(tmp_path / "elsewhere" / "run", threads=1)
    assert resumed.record["ledger"] == straight.record["ledger"]
    assert resumed.record["case_digest"] == straight.record["case_digest"] == case.digest()
    assert str(tmp_path) not in (resumed.folder / "case.toml").read_text()
    assert {"bag_start.vtk", "bag_reference.vtk"} <= set(Result.open(resumed.folder).record["files"])


def test_a_study_that_was_moved_goes_on_without_its_mesh(case_file, tmp_path):
    (case_file.parent / "study.toml").write_text(STUDY)
    Study.create(case_file.parent / "study.toml", tmp_path / "study")
    again = Study.create(case_file.parent / "study.toml", tmp_path / "study")  # the same study still
    assert again.train
    shutil.rmtree(case_file.parent)
    (tmp_path / "study").rename(tmp_path / "moved")
    summary = Study.open(tmp_path / "moved").run(workers=1)
    assert len(summary.completed) == 3


def test_the_digest_of_a_case_counts_what_its_files_hold(case_file, tmp_path):
    case = Case.load(case_file)
    moved = shutil.copytree(case_file.parent, tmp_path / "moved")
    assert Case.load(moved / "case.toml").digest() == case.digest()
    told = case.to_dict()
    told["bag"]["digest"] = ""  # as a case made in a program
    assert Case.from_dict(told).digest() == case.digest()
    (moved / "start.vtk").write_text((moved / "start.vtk").read_text().replace("start\n", "another\n", 1))
    assert Case.load(moved / "case.toml").digest() != case.digest()


def test_a_study_whose_mesh_is_missing_is_refused_before_its_first_run(case_file, tmp_path):
    (case_file.parent / "study.toml").write_text(STUDY)
    (case_file.parent / "start.vtk").unlink()
    with pytest.raises(InputError, match="cannot read the mesh file"):
        Study.create(case_file.parent / "study.toml", tmp_path / "study")
    assert not (tmp_path / "study").exists()
