"""`python -m trust.disks`: commands on a disk that runs full, at 64 sizes of free space each.

The disk is a tmpfs in a mount namespace of its own. Every size is below what the command's results take, so every
attempt must end with exit code 4 and one of the codes of a full disk; what was there before must be as it was, what is
new must be whole or not be there; and once there is room, the same command must end well.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from billow.base.errors import BillowError
from billow.case.schema import Case
from billow.cli.main import main as billow_command
from billow.results.ownership import LOCK
from billow.results.run_file import read_run_file
from billow.rom.judge import evaluate, report  # noqa: F401 - once, not in every copy of this process
from billow.rom.learn.train import import_network
from billow.rom.surrogate.surrogate import Surrogate
from billow.run.interrupts import STOP_FILE
from billow.run.simulate import simulate
from trust.study_kills import CASE, STUDY

SIZES = 64
PATIENCE = 600
"""Seconds for one command: one that takes longer hangs."""
FULL = ("E-RES-020", "E-STU-012")
ROOM = 64 * 2**20
"""Bytes of the disk."""


@dataclass
class Sweep:
    """How a command fared: attempts, codes seen, and what went wrong, one line each."""

    command: str
    attempts: int = 0
    bytes_needed: int = 0
    wrong: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Job:
    """A command: its words, and what makes the files on the disk that it needs."""

    name: str
    words: tuple[str, ...]
    prepare: Callable[[Path], object] = lambda disk: None


def sweep() -> list[Sweep] | None:
    """All commands, in a namespace of their own; None where no disk can be mounted."""
    for shelter in (["unshare", "--user", "--map-root-user", "--mount"], ["unshare", "--mount"]):
        with contextlib.suppress(OSError):
            if subprocess.run([*shelter, "true"], capture_output=True, check=False).returncode == 0:
                environment = {**os.environ, "NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
                done = subprocess.run(
                    [*shelter, sys.executable, "-m", "trust.disks", "inside"],
                    env=environment, stdout=subprocess.PIPE, text=True, check=False,
                )  # fmt: skip
                if done.returncode == 0:
                    return [Sweep(**record) for record in json.loads(done.stdout)]
    return None


def inside() -> list[Sweep]:
    """What `sweep` does, once nobody else sees what is mounted."""
    with tempfile.TemporaryDirectory(prefix="billow-disks-") as folder:
        place, disk = Path(folder), Path(folder, "disk")
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", disk], check=True)
        try:
            return [_sweep(job, disk) for job in _jobs(place, disk)]
        finally:
            subprocess.run(["umount", disk], check=True)


def _jobs(place: Path, disk: Path) -> Iterator[Job]:
    (place / "case.toml").write_text(CASE)
    (place / "study.toml").write_text(STUDY.format(train=2, test=1))
    study, out = place / "study", f"{disk}/out"
    foreign = str(_foreign(place))
    partial = _interrupted(place)
    yield Job("run", ("run", f"{place}/case.toml", "--quiet", "--out", out))
    yield Job("resume", ("resume", out, "--quiet"), lambda disk: shutil.copytree(partial, disk / "out.partial"))
    yield Job("study", ("study", f"{place}/study.toml", "--workers", "1", "--out", out))
    yield Job("import", ("import", foreign, "--out", out))
    _made("import", foreign, "--out", str(study))

    def copied(disk: Path) -> None:
        shutil.copytree(study, disk / "study")

    import_network()  # once, not in every copy of this process
    train = "--modes", "2", "--epochs", "3"
    _made("train", str(study), *train, "--seed", "1")  # an earlier surrogate, which must stay
    yield Job("train", ("train", f"{disk}/study", *train), copied)
    yield Job("evaluate", ("evaluate", f"{disk}/study"), copied)


def _interrupted(place: Path) -> Path:
    """A run that was stopped at its first frame."""
    (place / "longer.toml").write_text(CASE.replace("frames = 4", "frames = 40"))

    partial = place / "r.partial"
    with contextlib.suppress(KeyboardInterrupt):  # in this process: it now has the kernels, and so have its copies
        simulate(
            Case.load(place / "longer.toml"), place / "r", progress=lambda _: (partial / STOP_FILE).touch(), threads=1
        )
    return partial


def _foreign(place: Path) -> Path:
    """Eight runs of another solver."""
    folder, random = place / "foreign", np.random.default_rng(0)
    folder.mkdir()
    (folder / "runs.csv").write_text("run,a [-]\n" + "".join(f"r{k},{k}\n" for k in range(8)))
    (folder / "times.csv").write_text("time [s]\n0\n0.1\n0.2\n0.3\n")
    (folder / "triangles.csv").write_text("a,b,c\n" + "".join(f"{k},{k + 1},{k + 2}\n" for k in range(98)))
    start, motion = random.random((100, 3)), random.random((100, 3))
    for run in range(8):
        np.save(folder / f"r{run}.npy", start + np.linspace(0.0, 1.0 + 0.1 * run, 4)[:, None, None] * motion)
    return folder


def _sweep(job: Job, disk: Path) -> Sweep:
    _emptied(disk)
    job.prepare(disk)
    before = _contents(disk)
    code, said = _attempt(job.words)
    made = [disk / name for name, digest in _contents(disk).items() if before.get(name) != digest]
    found = Sweep(job.name, bytes_needed=sum(path.stat().st_size for path in made))
    if code != 0:
        found.wrong.append(f"with room enough: exit {code}, {said}")
    for number in range(SIZES):
        free = found.bytes_needed * number // SIZES
        _emptied(disk)
        job.prepare(disk)
        there = _contents(disk)
        _fill(disk, free)
        code, said = _attempt(job.words)
        (disk / "filler").unlink()
        done = code == 0 and all(path.exists() for path in made)  # a file that gave way to a new one made room
        wrong = [] if done or (code == 4 and said in FULL) else [f"exit {code}, {said}"]
        wrong += _damage(disk, there)
        if number % 16 == 7:  # once there is room
            code, said = _attempt(job.words)
            wrong += [] if code == 0 else [f"later, with room enough: exit {code}, {said}"]
        found.attempts += 1
        found.wrong += [f"{free} bytes free: {line}" for line in wrong]
    print(
        f"{job.name}: {found.attempts} sizes below {found.bytes_needed} bytes, {len(found.wrong)} wrong",
        file=sys.stderr,
    )
    return found


def _emptied(disk: Path) -> None:
    for path in disk.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def _used(disk: Path) -> int:
    numbers = os.statvfs(disk)
    return (numbers.f_blocks - numbers.f_bavail) * numbers.f_frsize


def _fill(disk: Path, free: int) -> None:
    with open(disk / "filler", "wb") as file:
        os.posix_fallocate(file.fileno(), 0, ROOM - _used(disk) - free)


def _contents(disk: Path) -> dict[str, str]:
    """File -> SHA-256, of all that must not change."""
    return {
        str(path.relative_to(disk)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in disk.rglob("*")
        if path.is_file() and path.name not in (LOCK, "journal.bin", "solver.log", "filler", "STOP")
    }


def _damage(disk: Path, there: dict[str, str]) -> Iterator[str]:
    """What is not as it was, or half-written where a reader would look for it."""
    now = _contents(disk)
    replaceable = ("out.partial/fabric.vtkhdf", "out.partial/histories.csv", "out.partial/run.json")
    for name, digest in there.items():
        kept = now.get(name) == digest or (name == "study/surrogate.safetensors" and _judged(disk / name))
        if not kept and name not in replaceable and "checkpoint_" not in name:
            yield f"{name} was changed"
    slots = list(disk.glob("out.partial/checkpoint_*.safetensors"))
    if any("checkpoint_" in name for name in there) and not any(
        now[str(p.relative_to(disk))] in there.values() for p in slots
    ):
        yield "the checkpoint is gone"
    if (disk / "out").exists() and not (disk / "out" / "billow.lock").exists():
        yield "half a result was published"
    for path in disk.glob("*/runs/*"):
        with contextlib.suppress(FileNotFoundError):
            try:
                read_run_file(path)
            except BillowError as error:
                yield f"{path.name}: {error.code}"
    for path in disk.glob("study/report/*"):
        if path.suffix == ".html" and not path.read_text().rstrip().endswith("</html>"):
            yield f"half of {path.name}"
    yield from (f"{path.name} is left" for path in disk.rglob(".*.partial"))


def _judged(path: Path) -> bool:
    """Whether a surrogate is whole and has a verdict: `evaluate` keeps its verdict before it writes the report, which
    shows the sum of that file."""
    with contextlib.suppress(FileNotFoundError, BillowError):
        return Surrogate.load(path).judgement is not None
    return False


def _attempt(words: tuple[str, ...]) -> tuple[int, str]:
    """Exit code of a command, negative for a signal, and the code of its message. In a copy of this process, which
    ends as every process does: what HDF5 still holds is flushed then."""
    with tempfile.TemporaryFile() as said:
        process = os.fork()
        if process == 0:
            _become(words, said.fileno())
        _, status = os.waitpid(process, 0)
        said.seek(0)
        text = said.read().decode(errors="replace")
    code = re.search(r"[EW]-[A-Z]+-\d+", text)
    trouble = "Traceback " if "Traceback" in text else ""
    return os.waitstatus_to_exitcode(status), trouble + (code[0] if code else text[-200:])


def _become(words: tuple[str, ...], output: int) -> None:
    code = 70
    try:
        atexit._clear()  # what this process must do at its end, the copy must not
        os.dup2(output, 1)
        os.dup2(output, 2)
        signal.alarm(PATIENCE)  # ends it, should it hang
        sys.argv = ["billow", *words]
        billow_command()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException as problem:
        print(f"Traceback {problem!r}", file=sys.stderr)
    finally:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        ctypes.CDLL(None).exit(code)


def _made(*words: str) -> None:
    code, said = _attempt(words)
    if code != 0:
        raise RuntimeError(f"{words}: exit {code}, {said}")


if __name__ == "__main__":
    if sys.argv[1:] == ["inside"]:
        sweeps = inside()
        print(json.dumps([vars(one) for one in sweeps]))
    else:
        for one in sweep() or []:
            print(one.command, one.attempts, one.bytes_needed, *one.wrong, sep="\n  ")
