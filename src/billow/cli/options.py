"""What several commands of `billow` share: the console, --set, and arguments that mean the same everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from billow.base.errors import InputError

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


def make_console() -> Console:
    """Console for messages, with paths left as they are."""
    return Console(highlight=False, soft_wrap=True)


def parse_settings(texts: list[str] | None) -> dict[str, float | str]:
    """{"key": value} from "key=value" texts."""
    pairs = {}
    for text in texts or []:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise NOT_AN_ASSIGNMENT(text=text)
        try:
            pairs[key.strip()] = float(value)
        except ValueError:
            pairs[key.strip()] = value.strip()
    return pairs


CaseFile = Annotated[Path, typer.Argument(help="Case file (TOML). Keys, units and defaults: docs/case.md.")]
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
    list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Value of a design parameter.")
]
Extrapolate = Annotated[bool, typer.Option("--extrapolate", help="Allow values outside the trained ranges.")]
Memory = Annotated[float, typer.Option(min=0.1, help="GiB of snapshots held at once; more are streamed.")]
