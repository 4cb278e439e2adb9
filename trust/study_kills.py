"""`python -m trust.study_kills`: a study of 60 short runs, killed at 20 random moments, against one left in peace.

Every kill is SIGKILL to the driving process and all its workers. Promised: no run is lost, none is made twice, and the
dataset has the same SHA-256 as that of the undisturbed study.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import billow
from billow.results.dataset import Dataset

CASE = """\
title = "Short run"
[bag]
element_size = 0.05
[run]
end_time = 2e-3
frames = 4
[[obstacles]]
shape = "plate"
"""

STUDY = """\
title = "Short runs"
case = "case.toml"
seed = 1
train = {train}
test = {test}
reference_length = 0.28
[[parameters]]
name = "permeability"
label = "Airbag permeability"
unit = "-"
low = 0.02
high = 0.035
keys = ["fabric.permeability"]
[[parameters]]
name = "temperature"
label = "Inflator temperature"
unit = "K"
low = 500.0
high = 800.0
keys = ["inflator.temperature"]
"""


@dataclass(frozen=True)
class Report:
    """kills that hit a study under way; runs made in the end; lost and remade: names; same: the datasets are equal."""

    kills: int
    runs: int
    lost: list[str]
    remade: list[str]
    same: bool

    @property
    def holds(self) -> bool:
        return not self.lost and not self.remade and self.same


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--train", type=int, default=48)
    parser.add_argument("--test", type=int, default=12)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="billow-kills-") as place:
        report = disturb(Path(place), asked.train, asked.test, asked.kills, random.Random(asked.seed))
    print(
        f"{report.kills} kills, {report.runs} runs; lost: {', '.join(report.lost) or 'none'}; made twice: "
        f"{', '.join(report.remade) or 'none'}; same dataset: {report.same}; {time.perf_counter() - begun:.0f} s"
    )
    return 0 if report.holds else 1


def disturb(place: Path, train: int, test: int, kills: int, moments: random.Random) -> Report:
    """Make one study in peace and one with kills, both in `place`, and compare."""
    (place / "case.toml").write_text(CASE)
    (place / "study.toml").write_text(STUDY.format(train=train, test=test))
    calm, stormy = place / "calm", place / "stormy"
    start(place, calm).wait()
    known: dict[str, int] = {}
    remade: set[str] = set()
    hits = 0
    for number in range(kills):
        process = start(place, stormy)
        # Some before anything was made in this attempt, most after some more runs.
        wanted = len(known) + moments.randint(0, max(1, 2 * (train + test) // kills))
        while process.poll() is None and len(published(stormy)) < min(wanted, train + test):
            time.sleep(0.005)
        time.sleep(moments.random() * 0.4)
        hits += process.poll() is None
        end(process)
        remade |= changed(known, published(stormy))
        known |= published(stormy)
        print(f"kill {number + 1}: {len(known)} runs there", flush=True)
    start(place, stormy).wait()
    remade |= changed(known, published(stormy))
    datasets = [Dataset.open(folder) for folder in (calm, stormy)]
    lost = sorted(datasets[1].missing)
    same = datasets[0].content_sha256() == datasets[1].content_sha256()
    return Report(hits, len(published(stormy)), lost, sorted(remade), same)


def start(place: Path, out: Path) -> subprocess.Popen:
    """The command of a study, in a process group of its own."""
    command = [sys.executable, "-m", "billow.cli.main", "study", "study.toml", "--out", str(out), "--workers", "2"]
    path = os.pathsep.join([str(Path(billow.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        command,
        cwd=place,
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def end(process: subprocess.Popen) -> None:
    """Kill it and all its workers."""
    if process.poll() is None:  # its number may belong to somebody else afterwards
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def published(folder: Path) -> dict[str, int]:
    """Run -> inode of its folder: another inode is another making."""
    try:
        return {entry.name: entry.inode() for entry in os.scandir(folder / "runs") if "." not in entry.name}
    except FileNotFoundError:
        return {}


def changed(known: dict[str, int], now: dict[str, int]) -> set[str]:
    return {run for run, inode in known.items() if now.get(run) != inode}


if __name__ == "__main__":
    sys.exit(main())
