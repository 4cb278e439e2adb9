import json
import os

import numpy as np
import pytest
from fake_solver import CASE, STUDY, Fails, simulate

from billow.base.errors import InputError, IntegrityError, ResourceError
from billow.results.run_file import read_run_file
from billow.study import drive as drive_module
from billow.study import store as store_module
from billow.study.study import Study


def lift_of(study, run):
    return study.runs[run][0]


def test_a_study_becomes_a_dataset(study):
    events = []
    summary = study.run(workers=1, progress=events.append, runner=simulate)
    assert summary.completed == tuple(study.runs)
    assert [event.status for event in events] == ["started", *["completed"] * 6, "finished"]
    assert [(event.done, event.total) for event in events[1:-1]] == [(n, 6) for n in range(1, 7)]
    dataset = study.dataset()
    assert (len(dataset.train), len(dataset.test), dataset.missing) == (4, 2, {})
    assert [(p.name, p.unit, p.high) for p in dataset.parameters] == [("lift", "m", 2.0), ("slope", "N/m", 1e6)]
    rise = dataset.snapshots("displacement", dataset.train)[:, -1, 0, 2]
    np.testing.assert_allclose(rise, 0.02 * dataset.design(dataset.train)[:, 0], rtol=1e-6)
    assert os.listdir(study.folder / "work") == []


def test_a_study_ends_with_the_verdicts_of_its_runs(study):
    doubted = {"verdict": "REVIEW", "criteria": [{"name": "energy residual", "verdict": "REVIEW"}]}
    failed = {"verdict": "FAIL", "criteria": [{"name": "energy residual", "verdict": "FAIL"}]}
    passed = {"verdict": "PASS", "criteria": [{"name": "energy residual", "verdict": "PASS"}]}
    qualities = dict(zip(study.runs, (doubted, passed, failed, doubted, passed, None), strict=True))

    def judged(case, folder, *, threads):
        run = next(run for run in study.runs if study.case(run).digest() == case.digest())
        simulate(case, folder, threads=threads, quality=qualities[run])

    events = []
    summary = study.run(workers=1, runner=judged, progress=events.append)
    assert events[-1].message == summary.counts == "6 runs completed: 2 PASS, 2 REVIEW, 1 FAIL; 0 failed"
    runs = list(study.runs)
    assert summary.reasons == [
        f"FAIL by energy residual: run {runs[2]}",
        f"REVIEW by energy residual: runs {runs[0]}, {runs[3]}",
    ]
    again = study.run(workers=1, runner=None)
    assert (again.counts, again.reasons) == (summary.counts, summary.reasons)


def test_creating_again_continues_and_another_study_is_refused(study, definition, tmp_path):
    study.run(workers=1, runner=simulate)
    again = Study.create(definition, study.folder)
    assert again.run(workers=1, runner=None).completed == tuple(study.runs)  # nothing to do: no solver is asked
    for old, new in (("seed = 3", "seed = 4"), ("high = 2.0", "high = 3.0")):
        definition.write_text(STUDY.replace(old, new))
        with pytest.raises(InputError, match="E-STU-008"):
            Study.create(definition, study.folder)
    definition.write_text(STUDY)
    (tmp_path / "square.toml").write_text(CASE.replace("size = 1.0", "size = 1.5"))
    with pytest.raises(InputError, match=r"E-STU-008(.|\n)*case.toml differs"):
        Study.create(definition, study.folder)
    with pytest.raises(InputError, match="E-STU-008"):
        Study.create(definition, tmp_path)
    with pytest.raises(InputError, match="E-STU-009"):
        Study.open(tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("plate.slope", "plate.slop", "(slope)"),
        ("high = 1e6", "high = 1e8", "(slope)"),
        ("square.lift", "disc.lift", "(lift)"),
    ],
)
def test_a_design_the_case_does_not_accept_leaves_no_folder(definition, tmp_path, old, new, place):
    definition.write_text(STUDY.replace(old, new))
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(InputError) as caught:
        Study.create(definition, tmp_path / "study")
    assert caught.value.code == "E-STU-007"
    assert place in caught.value.where
    assert sorted(os.listdir(tmp_path)) == before


def test_a_crash_while_creating_leaves_no_folder(definition, tmp_path, monkeypatch):
    from billow.study import study as study_module

    monkeypatch.setattr(study_module, "write_split", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        Study.create(definition, tmp_path / "study")
    assert not [name for name in os.listdir(tmp_path) if name.startswith("study")]


def test_an_interrupted_study_makes_only_what_is_missing(study):
    with pytest.raises(KeyboardInterrupt):
        study.run(workers=1, runner=Fails(lift_of(study, "0002"), "interrupt"))
    assert sorted(os.listdir(study.folder / "runs")) == ["0000", "0001"]
    assert not list((study.folder / "failed").iterdir())
    before = {run: (study.folder / "runs" / run).stat().st_ino for run in ("0000", "0001")}
    events = []
    Study.open(study.folder).run(workers=1, progress=events.append, runner=simulate)
    assert [event.run for event in events if event.status == "completed"] == ["0002", "0003", "0004", "0005"]
    assert before == {run: (study.folder / "runs" / run).stat().st_ino for run in before}
    assert os.listdir(study.folder / "work") == []


def test_a_run_that_was_interrupted_from_within_stops_the_study_and_is_made_again(study):
    with pytest.raises(KeyboardInterrupt):
        study.run(workers=1, runner=Fails(lift_of(study, "0001"), "interrupted"))
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)


@pytest.mark.parametrize(
    ("how", "code", "why"),
    [("error", "E-STU-016", "a bug"), ("stop", "E-NUM-007", "inverted"), ("stopped", "E-STU-014", "too fast")],
)
def test_a_failed_run_is_kept_with_its_reason_and_the_others_finish(study, how, code, why):
    summary = study.run(workers=1, runner=Fails(lift_of(study, "0001"), how))
    assert summary.completed == ("0000", "0002", "0003", "0004", "0005")
    record = json.loads((study.folder / "failed/0001.json").read_text())
    assert (record["run"], record["code"], record["why"], record["attempts"]) == ("0001", code, why, 1)
    assert set(record) == {"run", "code", "what", "where", "why", "remedy", "attempts"}
    assert (study.folder / "failed/0001/fabric.vtkhdf").exists() == (how != "error")
    assert why in study.dataset().missing["0001"]

    assert study.run(workers=1, runner=simulate).failed == summary.failed  # told again, not tried again
    assert study.run(workers=1, runner=simulate, retry_failed=True).completed == tuple(study.runs)
    assert not list((study.folder / "failed").iterdir())


def test_a_full_disk_stops_the_study_and_blames_no_run(study):
    with pytest.raises(ResourceError, match="E-STU-012 error: the disk is full after 2 of 6 runs"):
        study.run(workers=1, runner=Fails(lift_of(study, "0002"), "full"))
    assert not list((study.folder / "failed").iterdir())
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)


@pytest.mark.parametrize("place", [(store_module.RunStore, "begin"), (drive_module, "write_dataset_file")])
def test_a_disk_full_before_or_after_a_run_is_told_alike(study, monkeypatch, place):
    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(*place, full)
        with pytest.raises(ResourceError, match="E-STU-012"):
            study.run(workers=1, runner=simulate)
    assert not list((study.folder / "failed").iterdir())
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)


def test_a_damaged_run_is_set_aside_and_made_again(study):
    study.run(workers=1, runner=simulate)
    histories = study.folder / "runs/0003/histories.csv"
    histories.write_bytes(histories.read_bytes()[:-1])
    (study.folder / "runs/0004/run.json").unlink()
    events = []
    summary = study.run(workers=1, progress=events.append, runner=simulate)
    assert summary.completed == tuple(study.runs)
    made = [(event.status, event.run) for event in events if event.run]
    assert made == [("set aside", "0003"), ("set aside", "0004"), ("completed", "0003"), ("completed", "0004")]
    assert sorted(os.listdir(study.folder / "set_aside")) == ["0003-1", "0004-1"]


def test_a_run_of_another_design_is_refused(study):
    study.run(workers=1, runner=simulate)
    runs = study.folder / "runs"
    for old, new in (("0000", "x"), ("0001", "0000"), ("x", "0001")):
        (runs / old).rename(runs / new)
    with pytest.raises(IntegrityError, match=r"E-STU-010 error: run 0000"):
        study.run(workers=1, runner=simulate)


def test_a_run_with_another_mesh_stops_the_study(study):
    class Resized(Fails):
        def __call__(self, case, folder, *, threads):
            if case.content["square"]["lift"] == self.lift:
                digest = case.digest()
                case = case.vary({"square.size": 2.0})
                case.digest = lambda: digest
            simulate(case, folder, threads=threads)

    for _ in range(2):  # also when the study is continued
        with pytest.raises(IntegrityError, match="E-STU-011 error: run 0001"):
            study.run(workers=1, runner=Resized(lift_of(study, "0001"), None))
    assert sorted(os.listdir(study.folder / "runs")) == ["0000", "0001"]


def test_dataset_toml_lost_in_a_crash_is_written_again(study):
    study.run(workers=1, runner=simulate)
    (study.folder / "dataset.toml").rename(study.folder / "before")
    study.run(workers=1, runner=simulate)
    assert (study.folder / "dataset.toml").read_bytes() == (study.folder / "before").read_bytes()


def test_two_attempts_at_one_run_leave_the_first(study):
    study.run(workers=1, runner=simulate)
    inode = (study.folder / "runs/0000").stat().st_ino
    attempt = study.store.begin("0000")
    simulate(study.case("0000"), attempt / "0000", threads=1)
    study.store.publish("0000", attempt / "0000")
    assert (study.folder / "runs/0000").stat().st_ino == inode
    assert read_run_file(study.folder / "runs/0000")


def test_a_crash_in_publishing_leaves_a_study_that_continues(study, monkeypatch):
    def crash(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(store_module, "publish_folder", crash)
    with pytest.raises(KeyboardInterrupt):
        study.run(workers=1, runner=simulate)
    assert os.listdir(study.folder / "runs") == []
    assert len(os.listdir(study.folder / "work")) == 1
    monkeypatch.undo()
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)
    assert sorted(os.listdir(study.folder / "runs")) == list(study.runs)


def test_what_killed_processes_left_is_removed_and_nothing_else(study):
    study.store.work.mkdir()
    study.store.begin("workers")
    (study.folder / "work" / "notes").mkdir()
    (study.folder / "runs").mkdir()
    (study.folder / "runs" / "mine.partial").mkdir()
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)
    assert os.listdir(study.folder / "work") == ["notes"]
    assert (study.folder / "runs" / "mine.partial").is_dir()


def test_folders_behind_links_are_left_alone(study, tmp_path):
    (tmp_path / "elsewhere" / "0000.partial").mkdir(parents=True)
    for name in ("runs", "failed", "work", "set_aside"):
        (study.folder / name).symlink_to(tmp_path / "elsewhere")
        with pytest.raises(InputError, match="E-RES-024"):
            study.run(workers=1, runner=simulate)
        (study.folder / name).unlink()
    assert (tmp_path / "elsewhere" / "0000.partial").is_dir()


def test_a_study_that_was_not_written_to_the_end_is_written_again(definition, tmp_path):
    folder = tmp_path / "again"
    Study.create(definition, folder)
    (folder / "study.toml").unlink()  # the last of its files
    assert Study.create(definition, folder).run(workers=1, runner=simulate).completed
    (folder / "study.toml").unlink()
    (folder / "billow.lock").unlink()
    with pytest.raises(InputError, match="E-STU-008"):
        Study.create(definition, folder)


def test_one_study_is_driven_by_one_process(study):
    with study.store.driving(), pytest.raises(InputError, match=f"E-RES-023(.|\n)*process {os.getpid()}"):
        study.run(workers=1, runner=simulate)
    for wrong in ({"workers": 0}, {"workers": 2, "scheduler": "tcp://localhost:1"}):
        with pytest.raises(InputError, match="E-STU-021"):
            study.run(**wrong)
