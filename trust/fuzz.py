"""Inputs that nobody meant, by the thousand: each must be used or refused with a message, in bounded time and memory.

`fuzz` works in a process of its own with a limit on memory, so that a crash of compiled code or a runaway allocation is
a finding and not the end. What is fed, and by what share, is listed in `KINDS`.
"""

from __future__ import annotations

import argparse
import multiprocessing
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from billow.base.errors import LONGEST_TEXT, BillowError
from billow.results.machine import peak_memory
from trust import fuzz_decks, fuzz_files, fuzz_inputs
from trust.payloads import security

__all__ = ["FuzzReport", "fuzz", "security"]

SECONDS = 5.0
"""Time of the processor that one input may take: others may be at work, too."""

PATIENCE = 60.0
"""Time on the clock [s] that it may take: what waits for a pipe takes no time of the processor."""

MEMORY = 2**30
"""Bytes that inputs may add to the address space of the process."""

INSIDES = re.compile(
    r"Traceback \(most| object at 0x[0-9a-f]|ordinal not in ra[n]ge|values to unp[a]ck|None[T]ype|range obj[e]ct|"
    r"has no attri[b]ute|invalid lite[r]al|zi[p]\(\)|\bint\(\)|\bfloat\(\)|could not con[v]ert|unhash[a]ble|"
    r"codec can't|not subscri[p]table|null b[y]te|positional argum[e]nt|index out of ra[n]ge|must be s[t]r|\[Errn[o]"
)
"""What no message shows: Python's words. An expression that does not match itself: inputs are made of this source's own
words, too, and a message may quote its input."""

SILENCE = 120.0
"""Seconds without a word from the process after which it counts as hanging."""

KINDS: dict[str, tuple[float, Callable]] = {
    "generated cases": (0.12, fuzz_inputs.generated_cases),
    "generated curves": (0.04, fuzz_inputs.generated_curves),
    "mutated case dictionaries": (0.11, fuzz_inputs.mutated_cases),
    "mutated case files": (0.11, fuzz_inputs.mutated_case_files),
    "assignments": (0.03, fuzz_inputs.assignments),
    "study files": (0.08, fuzz_inputs.study_files),
    "study folders": (0.03, fuzz_inputs.study_folders),
    "datasets": (0.03, fuzz_inputs.datasets),
    "damaged runs": (0.03, fuzz_inputs.damaged_runs),
    "forged runs": (0.02, fuzz_inputs.forged_runs),
    "damaged checkpoints": (0.02, fuzz_inputs.damaged_checkpoints),
    "damaged surrogates": (0.02, fuzz_inputs.damaged_surrogates),
    "forged surrogates": (0.04, fuzz_inputs.forged_surrogates),
    "meshes": (0.08, fuzz_files.meshes),
    "decks": (0.04, fuzz_decks.decks),
    "starter decks": (0.02, fuzz_decks.starters),
    "tables": (0.10, fuzz_files.tables),
    "tank cases": (0.04, fuzz_files.tank_cases),
    "runs of others": (0.03, fuzz_files.imports),
    "paths": (0.03, fuzz_files.paths),
    "command lines": (0.02, fuzz_files.command_lines),
    "environments": (0.02, fuzz_files.environments),
}
"""Kind of input -> its share, and what feeds that many of them."""


UNSEEN = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)
"""Warnings that nobody sees; all others are findings."""


class TooSlow(BaseException):
    """An input took longer than `SECONDS`."""


@dataclass
class FuzzReport:
    """inputs = refused + accepted + len(tracebacks). tracebacks: what ended in anything but success or a `BillowError`,
    or in a message that is empty, endless or unprintable. slowest_seconds: of one input. peak_bytes: largest memory in
    use by the process. by_kind: kind -> [accepted, refused]."""

    inputs: int = 0
    refused: int = 0
    accepted: int = 0
    tracebacks: list[str] = field(default_factory=list)
    slowest_seconds: float = 0.0
    peak_bytes: int = 0
    by_kind: dict[str, list[int]] = field(default_factory=dict)


def fuzz(count: int, seed: int, kinds: Iterable[str] = KINDS) -> FuzzReport:
    """Feed about `count` inputs, or the share of these kinds; the same ones for the same seed."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_feed, args=(count, seed, list(kinds), there))
    process.start()
    there.close()
    report = FuzzReport()
    try:
        while here.poll(SILENCE):
            report, done = here.recv()
            if done:
                return report
        report.tracebacks.append(f"no word for {SILENCE} s after input {report.inputs}")
    except EOFError:
        process.join()
        report.tracebacks.append(f"the process ended with {process.exitcode} after input {report.inputs}")
    finally:
        process.kill()
    return report


def _feed(count: int, seed: int, kinds: list[str], connection) -> None:
    signal.signal(signal.SIGALRM, _ring)
    signal.signal(signal.SIGPROF, _ring)
    with tempfile.TemporaryDirectory(prefix="billow-fuzz-") as folder:
        bench = fuzz_inputs.Bench(Path(folder))
        size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, resource.RLIM_INFINITY))
        trials = Trials(connection)
        for kind in kinds:
            share, feed = KINDS[kind]
            trials.begin(kind)
            feed(trials.attempt, max(1, round(share * count)), Random(f"{seed} {kind}"), bench)
    trials.report.peak_bytes = int(1e6 * peak_memory())
    connection.send((trials.report, True))


def _ring(number, frame) -> None:
    raise TooSlow(f"it took longer than {SECONDS if number == signal.SIGPROF else PATIENCE} s")


class Trials:
    """Counts how attempts end."""

    def __init__(self, connection):
        self.connection, self.report = connection, FuzzReport()
        self.kind = ""
        sys.unraisablehook = self._unraisable

    def begin(self, kind: str) -> None:
        self.kind = kind
        self.report.by_kind[kind] = [0, 0]

    def attempt(self, use: Callable[[], object], shown: object, file: str = "") -> bool:
        """Use one input; True if it was accepted. shown: the input, for the report; file: what a refusal must name."""
        report, begun = self.report, time.process_time()
        report.inputs += 1
        accepted = False
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        signal.setitimer(signal.ITIMER_REAL, PATIENCE)
        try:
            with warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                use()
            accepted = True
        except BillowError as error:
            problem = "it counts as a mistake in Billow" if error.code == "E-CLI-070" else badly_told(error)
            if file and not problem and file not in str(error):
                problem = f"{file} is not named"
            if problem:
                report.tracebacks.append(f"{self.kind}: {problem}: {error}")
            else:
                report.refused += 1
                report.by_kind[self.kind][1] += 1
        except BaseException:
            end = traceback.format_exc().splitlines()
            report.tracebacks.append("\n".join([f"{self.kind}: {brief(shown)}", *end[-8:]]))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        spoken = next((str(w.message) for w in warned if not issubclass(w.category, UNSEEN)), None)
        if spoken:
            report.tracebacks.append(f"{self.kind}: warning {spoken!r}: {brief(shown)}")
        report.accepted += accepted
        report.by_kind[self.kind][0] += accepted
        report.slowest_seconds = max(report.slowest_seconds, time.process_time() - begun)
        if report.inputs % 100 == 0:
            self.connection.send((report, False))
        return accepted

    def _unraisable(self, problem) -> None:
        """Python prints such errors, traceback and all, and goes on."""
        self.report.tracebacks.append(f"{self.kind}: ignored {problem.exc_value!r}")


def brief(shown: object) -> str:
    """The beginning of an input."""
    try:
        return repr(shown)[:400]
    except ValueError:  # Python refuses to write integers of more than 4,300 digits
        return "an input that holds a number too long to be written"


def main() -> int:
    """`python -m trust.fuzz --count 20000`: what went wrong, and a table of what was fed."""
    parser = argparse.ArgumentParser(prog="python -m trust.fuzz")
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", choices=KINDS, help="only the share of this kind")
    told = parser.parse_args()
    report = fuzz(told.count, told.seed, told.kind or KINDS)
    for problem in report.tracebacks:
        print(problem, end="\n\n")
    for kind, (accepted, refused) in report.by_kind.items():
        print(f"{kind:28}{accepted:8} accepted{refused:8} refused")
    print(
        f"{report.inputs} inputs, {len(report.tracebacks)} findings, slowest {report.slowest_seconds:.2f} s, "
        f"peak {report.peak_bytes / 1e9:.2f} GB"
    )
    return 1 if report.tracebacks else 0


def badly_told(error: BillowError) -> str | None:
    """What is wrong with a message, or None."""
    for part in ("what", "where", "why", "remedy"):
        text = getattr(error, part)
        if not text or not text.isprintable() or len(text) > 12 * LONGEST_TEXT:
            return f"{part} is empty, unprintable or endless"
        if INSIDES.search(text):
            return f"{part} shows Python's insides"
    return None


if __name__ == "__main__":
    sys.exit(main())
