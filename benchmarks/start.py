"""What a command costs before and after its loop: `python benchmarks/start.py`, and part of `make bench`.

Whole processes, in turn, medians of processor time (user and system). The runs have one step of a small mesh, so that
nothing but start and output is left of them.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROUNDS = 9
HELP = "from billow.cli.main import main; main()"
RUN = """
import contextlib, sys, time
import billow.cli.main as command

def stamp(progress):
    if progress.time >= progress.end:
        print(time.process_time(), flush=True)

command.watched = lambda quiet: contextlib.nullcontext(stamp)
command.main()
"""
"""The command, which prints how long it has worked at the end of its one step."""

CASES = {"driver bag": "", "square pillow": 'shape = "square"\n'}
CASE = """
[bag]
element_size = 0.03
{bag}
[[obstacles]]
shape = "plate"
[run]
end_time = 1e-6
frames = 1
histories_per_frame = 1
"""


def seconds(program: str, *arguments: object, cache: Path) -> tuple[float, float]:
    """Processor time [s] of a process, and of what it did until the end of its first step, NaN without one. cache: of
    kernels; what Python makes of its sources is kept beside it, as in every installation."""
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    surroundings |= {"BILLOW_CACHE": str(cache), "PYTHONPYCACHEPREFIX": str(cache.parent / "bytecode")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)],
        env=surroundings, check=True, capture_output=True, text=True,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    stamps = [line for line in done.stdout.splitlines() if line.replace(".", "", 1).isdigit()]
    return spent, float(stamps[0]) if stamps else np.nan


def start() -> dict[str, str]:
    """Processor seconds of `billow --help`, of a warm run to its first step and as a whole, and of compiling."""
    with tempfile.TemporaryDirectory() as place:
        folder, taken = Path(place), 0

        def run(name: str, cache: str = "cache") -> tuple[float, float]:
            nonlocal taken
            taken += 1
            out = folder / f"run{taken}"
            return seconds(RUN, "run", folder / f"{name}.toml", "--out", out, "--threads", 1, cache=folder / cache)

        for name, bag in CASES.items():
            (folder / f"{name}.toml").write_text(CASE.format(bag=bag))
            run(name)
        cold, _ = run("driver bag", cache="empty")
        helps, runs = [], {name: [] for name in CASES}
        for _ in range(ROUNDS):
            helps.append(seconds(HELP, "--help", cache=folder / "cache")[0])
            for name, found in runs.items():
                found.append(run(name))
    lines = {"billow --help (aim: 0.3 s)": f"{np.median(helps):.2f} s of processor time"}
    for name, found in runs.items():
        whole, first = np.median(found, axis=0)
        lines[f"warm run of a {name} to its first step (aim: 0.8 s)"] = f"{first:.2f} s of processor time"
        lines[f"warm command with one step of a {name} (aim: 1.2 s)"] = f"{whole:.2f} s of processor time"
    warm = np.median(runs["driver bag"], axis=0)[0]
    lines["cold compile of a driver bag (aim: 20 s)"] = f"{cold - warm:.1f} s of processor time"
    return lines


if __name__ == "__main__":
    for what, value in start().items():
        print(f"| {what} | {value} |")
