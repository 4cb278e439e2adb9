"""What several commands of `billow` share: the console and its bars, --set, and arguments that mean the same.

Rich is loaded where something is drawn, 20 ms: `billow run` prints plain lines.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from billow.base.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

NOT_AN_ASSIGNMENT = InputError.declare(
    "E-CLI-001",
    "{text!r} is not KEY=VALUE",
    where="--set",
    why="a setting names a key and its value, with an equals sign between them",
    remedy="write for example --set fabric.permeability=0.03",
)
UNUSABLE_NUMBER = InputError.declare(
    "E-CLI-007",
    "--{option} {text!r} cannot be used",
    where="billow {command}",
    cause="a unit that does not fit, or a value outside its range",
    remedy="give a number, with a unit if it is not in the one of the help text",
)


QUIET_SECONDS = 5.0  # least time between two plain lines


def make_console() -> Console:
    """Console for messages, with paths left as they are."""
    from rich.console import Console

    return Console(highlight=False, soft_wrap=True, markup=False)


@contextlib.contextmanager
def epochs(console: Console, title: str) -> Iterator[Callable[..., None]]:
    """A function (epoch, epochs, loss, which) for training to call, as `Progress` of rom/learn/progress.py."""
    if console.is_terminal:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (TextColumn(title), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[loss]}"))
        with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=console) as bar:
            task = bar.add_task(title, total=None, loss="")
            yield lambda *told: bar.update(task, completed=told[0], total=told[1], loss=_loss(*told))
        return
    spoken = time.monotonic() - QUIET_SECONDS

    def line(epoch: int, total: int, *told) -> None:
        nonlocal spoken
        if epoch == total or time.monotonic() - spoken >= QUIET_SECONDS:
            spoken = time.monotonic()
            text = f"{title}: epoch {epoch} of {total} in all, {_loss(epoch, total, *told)}"
            console.print(text, markup=False, highlight=False)

    yield line


def _loss(epoch: int, epochs: int, loss: float, which: str = "") -> str:
    return f"loss of {which} {loss:.2e}" if which else f"loss {loss:.2e}"


@contextlib.contextmanager
def steps(console: Console) -> Iterator[Callable[[int, int, str], None]]:
    """A function (done, total, what) for evaluation to call."""
    if not console.is_terminal:
        yield lambda done, total, what: console.print(f"[{done}/{total}] {what}", markup=False, highlight=False)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    with Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), console=console) as bar:
        task = bar.add_task("evaluation", total=None)
        yield lambda done, total, what: bar.update(task, completed=done, total=total, description=what)


@contextlib.contextmanager
def usable(command: str, option: str, text: str, remedy: str | None = None) -> Iterator[None]:
    """Where the text of an option is read: a ValueError becomes InputError E-CLI-007."""
    try:
        yield
    except ValueError as error:
        raise UNUSABLE_NUMBER(option=option, text=text[:40], command=command, why=error, remedy=remedy) from None


def memory_bytes(gibibytes: float, command: str) -> int:
    """`Memory` in bytes. InputError E-CLI-007 unless it is a finite number."""
    with usable(command, "memory", str(gibibytes)):
        if not gibibytes < 2**30:
            raise ValueError("it is more than any machine has")
        return int(gibibytes * 2**30)


def parse_settings(texts: list[str] | None) -> dict[str, float | str]:
    """{"key": value} from texts "key=value", or "@design.toml", a file of values as the explorer saves it."""
    pairs = {}
    for text in texts or []:
        if text.startswith("@"):
            pairs |= _design_in(Path(text[1:]))
            continue
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise NOT_AN_ASSIGNMENT(text=text)
        try:
            pairs[key.strip()] = float(value)
        except ValueError:
            pairs[key.strip()] = value.strip()
    return pairs


CaseFile = Annotated[Path, typer.Argument(help="Case file (TOML). Keys, units and defaults: docs/case.md.")]


def _design_in(path: Path) -> dict[str, float | str]:
    """Values of the table [design] of a TOML file, or of the file itself. InputError E-CLI-001."""
    from billow.base.toml_file import read_toml

    try:
        content = read_toml(path)
        content = content.get("design", content)
        if not content or not all(type(value) in (int, float, str) for value in content.values()):
            raise ValueError("it holds a number, or the name of a level, for each parameter, and at least one")
    except (OSError, ValueError) as error:
        remedy = "give the design.toml that the explorer saved, or --set NAME=VALUE"
        raise NOT_AN_ASSIGNMENT(what=f"the design in {path} cannot be used", why=error, remedy=remedy) from error
    return {name: float(value) if type(value) is int else value for name, value in content.items()}


Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a key of the case; obstacles are addressed by name."),
]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads; results do not depend on it.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No solver log on the screen.")]
StudyFolder = Annotated[Path, typer.Argument(metavar="STUDY", help="Study folder.")]
SurrogateFile = Annotated[Path, typer.Argument(metavar="SURROGATE", help="Surrogate file.")]
SurrogateOption = Annotated[
    Path | None, typer.Option("--surrogate", help="Surrogate file (default: STUDY/surrogate.safetensors).")
]
DesignValues = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Value of a design parameter; @FILE: a design.toml."),
]
Extrapolate = Annotated[bool, typer.Option("--extrapolate", help="Allow values outside the trained ranges.")]
DespiteVerdict = Annotated[
    bool, typer.Option("--despite-verdict", help="Answer even if a simpler answer is better on unseen runs.")
]
Memory = Annotated[float, typer.Option(min=0.1, help="GiB of snapshots held at once; more are streamed.")]
