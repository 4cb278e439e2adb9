"""A study starts no more workers than its container has cores, and lets few runs use many."""

from __future__ import annotations

import re

import pytest
from fake_solver import simulate

from billow.base import cores
from billow.study import drive
from billow.study.progress import study_progress


@pytest.mark.parametrize(
    ("own", "files", "expected"),
    [
        ("0::/\n", {"cpu.max": "250000 100000\n"}, 2),
        ("0::/\n", {"cpu.max": "50000 100000\n"}, 1),
        ("0::/\n", {"cpu.max": "max 100000\n"}, 16),
        ("0::/a/b\n", {"cpu.max": "max 1", "a/cpu.max": "300000 100000", "a/b/cpu.max": "max 100000"}, 3),
        (
            "3:cpu,cpuacct:/docker/1\n2:pids:/\n",
            {"cpu/cpu.cfs_quota_us": "400000", "cpu/cpu.cfs_period_us": "1e5"},
            4,
        ),
        ("3:cpu:/\n", {"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, 16),
        ("2:memory:/\n", {}, 16),
        ("0::/gone\n", {}, 16),
    ],
)
def test_a_container_has_as_many_cores_as_it_has_processor_time(own, files, expected, tmp_path, monkeypatch):
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: set(range(16)), raising=False)
    monkeypatch.setattr(cores, "GROUPS", tmp_path / "groups")
    monkeypatch.setattr(cores, "OWN_GROUPS", tmp_path / "own")
    (tmp_path / "own").write_text(own)
    for name, text in files.items():
        (tmp_path / "groups" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "groups" / name).write_text(text)
    assert cores.available_cores() == expected


def test_elsewhere_the_system_is_asked(tmp_path, monkeypatch):
    monkeypatch.setattr(cores, "OWN_GROUPS", tmp_path / "none")
    monkeypatch.delattr(cores.os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(cores.os, "cpu_count", lambda: 5)
    assert cores.available_cores() == 5


@pytest.mark.parametrize(
    ("available", "asked", "workers", "threads"),
    [(16, None, 6, 2), (6, None, 6, 1), (3, None, 3, 1), (16, 12, 6, 2), (16, 1, 1, 1)],
)
def test_six_runs_share_the_cores(available, asked, workers, threads, study, monkeypatch):
    told = []

    def outcomes(self, tasks, *arguments):
        told.append((*arguments[:2], {task.threads for task in tasks}))
        yield from ()

    monkeypatch.setattr(drive, "available_cores", lambda: available)
    monkeypatch.setattr(drive.Drive, "_outcomes", outcomes)
    study.run(workers=asked)
    assert told == [(workers, threads, {threads})]


def test_the_log_of_a_study_says_how_much_memory_a_worker_held(study, capsys):
    with study_progress() as report:
        study.run(workers=1, progress=report, runner=simulate)
    last = capsys.readouterr().out.splitlines()[-1]
    found = re.fullmatch(r"study finished: .*; a worker held at most (\d+) MB", last)
    assert int(found[1]) > 50  # in a test, of all that this process has loaded
