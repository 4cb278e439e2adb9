"""A study whose process is killed at random moments: no run is lost or made twice, and the dataset is the same.

`python -m trust.study_kills` does this with the real solver, worker processes and twenty kills.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from fake_solver import STUDY, simulate

from billow.study.study import Study

PROGRAM = """
import sys, time
sys.path.insert(0, sys.argv[1])
import fake_solver
from billow.study import study

def slowly(case, folder, *, threads):
    time.sleep(0.02)
    fake_solver.simulate(case, folder, threads=threads)

study._load_case = fake_solver.FakeCase.load
study._outline = fake_solver.outline
study.Study.create(sys.argv[2], sys.argv[3]).run(workers=1, runner=slowly)
"""


def made(folder):
    runs = folder / "runs"
    return {p.name: p.stat().st_ino for p in runs.iterdir() if "." not in p.name} if runs.is_dir() else {}


def test_kills_lose_nothing(study, definition, tmp_path):
    definition.write_text(STUDY.replace("train = 4", "train = 20").replace("test = 2", "test = 4"))
    calm = Study.create(definition, tmp_path / "calm")
    calm.run(workers=1, runner=simulate)
    stormy, moments, known, hits = tmp_path / "stormy", random.Random(2), {}, 0
    for _ in range(4):
        # Only this test's own process, by its own handle.
        arguments = [sys.executable, "-c", PROGRAM, str(Path(__file__).parent), str(definition), str(stormy)]
        process = subprocess.Popen(arguments, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
        wanted = len(known) + moments.randint(1, 5)
        while process.poll() is None and len(made(stormy)) < min(wanted, 24):
            time.sleep(0.002)
        time.sleep(0.03 * moments.random())
        hits += process.poll() is None
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert known.items() <= made(stormy).items()
        known = made(stormy)
    assert hits >= 3
    study = Study.create(definition, stormy)
    assert study.run(workers=1, runner=simulate).completed == tuple(study.runs)
    assert known.items() <= made(stormy).items()
    assert sorted(made(stormy)) == sorted(study.runs)
    assert study.dataset().content_sha256() == calm.dataset().content_sha256()
