"""`make trust`: the reliability goals as a table, misses included."""

from __future__ import annotations

import random
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from trust import conservation, cost, determinism, disks, environments, faults, fuzz, owners, study_kills


@dataclass(frozen=True)
class Goal:
    """One line: identifier of the plan, what is promised, what was measured, whether it holds."""

    id: str
    promise: str
    measured: str
    holds: bool


def fuzzing() -> Iterator[Goal]:
    report = fuzz.fuzz(20_000, seed=1)
    bad = len(report.tracebacks)
    promise = "hostile cases, files, paths, commands: no traceback, no E-CLI-070, no warning, no word of Python"
    yield Goal("IN-1", promise, f"{bad} of {report.inputs}", bad == 0)
    yield Goal("IN-1", "none takes over 5 s", f"slowest {report.slowest_seconds:.2f} s", report.slowest_seconds < 5.0)
    yield Goal("IN-1", "none takes over 1 GB", f"peak {report.peak_bytes / 1e9:.2f} GB", report.peak_bytes < 1e9)


def surrounded() -> Iterator[Goal]:
    found = dict(environments.misled())
    missed = [name for name, problem in found.items() if problem]
    promise = "hostile environments: same answers, nothing said, nothing left behind"
    yield Goal("ENV-1", promise, f"{len(missed)} of {len(found)} differ", not missed)
    for name in missed:
        yield Goal("ENV-1", name, found[name].splitlines()[-1][:80], False)


def turned() -> Iterator[Goal]:
    promise = "a case turned and moved in space: same histories to rounding"
    yield from _passed("ROT-1", promise, "tests/dynamics/test_turned_in_space.py")


def thread_determinism() -> Iterator[Goal]:
    for gas, hashes in determinism.thread_matrix().items():
        yield Goal(
            "DET-1", f"{gas}: one SHA-256 over 1, 2, 4 threads, repeats, serial kernels", f"{len(hashes)} different",
            len(hashes) == 1,
        )  # fmt: skip


def restart_determinism() -> Iterator[Goal]:
    for gas in determinism.GASES:
        same = determinism.restarts(gas)
        steps = ", ".join(map(str, same))
        yield Goal(
            "DET-2",
            f"{gas}: restart after step {steps} of its run",
            f"{sum(same.values())} of {len(same)} equal",
            all(same.values()),
        )
    threads = determinism.in_own_process("restarts", "0")
    yield Goal("DET-2", "the same with parallel kernels and another thread count after", threads, threads == "True")


def conserved() -> Iterator[Goal]:
    mass, energy = conservation.gas_errors()
    pair, scene = conservation.momentum_error()
    smooth = conservation.smooth_energy_error()
    yield Goal("CON-1", "gas mass closes to 1e-12", f"{mass:.1e}", mass <= 1e-12)
    yield Goal("CON-1", "gas energy closes to 1e-12", f"{energy:.1e}", energy <= 1e-12)
    yield Goal("CON-2", "contact forces sum to zero, 1e-12", f"{pair:.1e}", pair <= 1e-12)
    yield Goal("CON-2", "gas + bag + impactor momentum, 1e-11", f"{scene:.1e}", scene <= 1e-11)
    yield Goal("CON-3", "energy of a smooth case, 0.1 %", f"{100 * smooth:.4f} %", smooth <= 1e-3)


def diagnosed() -> Iterator[Goal]:
    results = faults.run_faults()
    named, silent = sum(r.named for r in results), [r.name for r in results if r.silent]
    missed = [r.name for r in results if not r.named]
    yield Goal(
        "DIA",
        f"right cause named for {len(results)} seeded faults (28 of 30)",
        f"{named} of {len(results)}",
        named >= 28 / 30 * len(results),
    )
    yield Goal("DIA", "no fault runs on silently", ", ".join(silent) or "none", not silent)
    if missed:
        yield Goal("DIA", "cause not named", ", ".join(missed), True)


def escapes() -> Iterator[Goal]:
    for goal, promise, count, total in fuzz.security():
        yield Goal(goal, promise, f"{count} of {total}", count == 0)


def killed() -> Iterator[Goal]:
    with tempfile.TemporaryDirectory(prefix="billow-kills-") as place:
        report = study_kills.disturb(Path(place), train=48, test=12, kills=20, moments=random.Random(1))
    yield Goal("STU-1", f"{report.kills} kills of a study: no run is lost", f"{len(report.lost)} lost", not report.lost)
    yield Goal("STU-1", "no run is made twice", f"{len(report.remade)} made twice", not report.remade)
    yield Goal("STU-1", "same dataset as without kills", "same" if report.same else "another", report.same)


def full_disks() -> Iterator[Goal]:
    sweeps = disks.sweep()
    if sweeps is None:
        yield Goal("STU-3", "full disks", "not measured", False)
        print(f"{'':11} no disk can be mounted here: neither root nor user namespaces")
    for one in sweeps or ():
        promise = f"{one.command}: exit 4 and nothing damaged at {one.attempts} sizes of free space"
        yield Goal("STU-3", promise, f"{len(one.wrong)} wrong", not one.wrong)
        for line in one.wrong[:5]:
            print(f"{'':11} {line}")


def two_owners() -> Iterator[Goal]:
    with tempfile.TemporaryDirectory(prefix="billow-owners-") as place:
        refused, tries = owners.meet(Path(place), 20, random.Random(1))
    yield Goal(
        "LOCK",
        "two commands, one folder: the second refused, the first named",
        f"{refused} of {tries}",
        refused == tries,
    )


def spent() -> Iterator[Goal]:
    books, checkpoints = cost.share()
    total = books + checkpoints
    parts = f"{100 * total:.1f} % ({100 * books:.1f} + {100 * checkpoints:.2f})"
    yield Goal("COST", "ledger and guards + checkpoints: at most 5 % of a run", parts, total <= 0.05)


def reachable() -> Iterator[Goal]:
    promise = "every error code is produced by an input, with a remedy that exists"
    yield from _passed("IN-2", promise, "tests/errors/test_every_code_is_reachable.py")


def _passed(goal: str, promise: str, tests: str) -> Iterator[Goal]:
    command = [sys.executable, "-m", "pytest", tests]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False)
    passed = re.search(r"\d+(?= passed)", done.stdout)
    measured = f"{passed[0] if passed else 0} tests, pytest exit {done.returncode}"
    yield Goal(goal, promise, measured, done.returncode == 0 and passed is not None)


MEASURES: tuple[Callable[[], Iterator[Goal]], ...] = (
    conserved, thread_determinism, restart_determinism, diagnosed, turned, reachable, fuzzing, surrounded, escapes,
    killed, two_owners, full_disks, spent,
)  # fmt: skip


def main() -> int:
    failed = 0
    print(f"{'goal':6} {'':4} {'measured':28} promise")
    for measure in MEASURES:
        begun = time.perf_counter()
        for goal in measure():
            failed += not goal.holds
            print(f"{goal.id:6} {'ok' if goal.holds else 'MISS':4} {goal.measured:28} {goal.promise}", flush=True)
        print(f"{'':11} ({measure.__name__}: {time.perf_counter() - begun:.0f} s)", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
