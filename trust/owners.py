"""Two commands at random moments into one folder: one has it, the other is refused and told who has it."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
import time
from pathlib import Path

import billow
from trust.study_kills import CASE, STUDY

COMMANDS = (
    (("run", "long.toml", "--quiet", "--out", "out"),) * 2,
    (("study", "study.toml", "--workers", "1", "--out", "out"),) * 2,
    (("run", "long.toml", "--quiet", "--out", "out"), ("resume", "out", "--quiet")),
    (("run", "long.toml", "--quiet", "--out", "out"), ("run", "long.toml", "--quiet", "--out", "link/out")),
)


def meet(place: Path, tries: int, moments: random.Random) -> tuple[int, int]:
    """How often the second command was refused by E-RES-023 with the first one's number, of how many tries."""
    (place / "case.toml").write_text(CASE)
    (place / "long.toml").write_text(CASE.replace("end_time = 2e-3", "end_time = 0.9"))
    (place / "study.toml").write_text(STUDY.format(train=400, test=100))
    (place / "link").symlink_to(place)
    return sum(_refused(place / "out", COMMANDS[k % len(COMMANDS)], moments) for k in range(tries)), tries


def _refused(out: Path, pair: tuple[tuple[str, ...], tuple[str, ...]], moments: random.Random) -> bool:
    """Whether one of two commands was refused in the name of the other, which goes on."""
    place = out.parent / f"{moments.getrandbits(40):x}"
    place.mkdir()
    for name in ("case.toml", "long.toml", "study.toml"):
        (place / name).write_text((out.parent / name).read_text())
    (place / "link").symlink_to(place)
    both = [_start(place, pair[0])]
    if pair[1][0] == "resume":  # needs something to resume
        while not (place / "out.partial" / "solver.log").exists() and both[0].poll() is None:
            time.sleep(0.01)
    time.sleep(3.0 * moments.random() ** 2)
    both.append(_start(place, pair[1]))
    try:
        end = time.monotonic() + 60.0
        while all(one.poll() is None for one in both) and time.monotonic() < end:
            time.sleep(0.02)
        ended = [one for one in both if one.poll() is not None]
        if len(ended) != 1:
            return False
        first = next(one for one in both if one is not ended[0])
        said = ended[0].stderr.read().decode()
        named = re.search(r"belongs to process (\d+)", said)
        return ended[0].returncode == 2 and "E-RES-023" in said and named is not None and int(named[1]) == first.pid
    finally:
        for one in both:
            one.kill()
            one.wait()
            one.stderr.close()


def _start(place: Path, words: tuple[str, ...]) -> subprocess.Popen:
    path = os.pathsep.join([str(Path(billow.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-m", "billow.cli.main", *words], cwd=place, env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip
