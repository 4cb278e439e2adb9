"""Write docs/commands.md from the command line itself, so that the page cannot drift from `--help`.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

import enum
import inspect
import typing
from collections.abc import Iterator
from pathlib import Path

import typer

from billow.cli.main import app

TARGET = Path(__file__).with_name("commands.md")

INTRODUCTION = """# Commands

Everything that `billow --help` and `billow COMMAND --help` say. `python -m billow` is the same command,
`billow --install-completion` teaches the shell to complete it. Exit codes and messages: [errors](errors.md).
"""


KINDS = {Path: "path", str: "text", int: "whole number", float: "number", bool: ""}
"""What is written for a type; nothing for a switch."""


def commands(group, name: str) -> Iterator[tuple[str, object]]:
    """Every command with its whole name, in the order of `--help`, groups opened."""
    for word, command in group.commands.items():
        whole = f"{name} {word}"
        if hasattr(command, "commands"):
            yield from commands(command, whole)
        elif not command.hidden:
            yield whole, command


def kind_of(parameter) -> str:
    """What is to be written for a parameter: its metavar, its choices, or the name of its type and its limits."""
    annotation = parameter.type_descriptor.annotation
    if parameter.param_type_name == "option" and parameter.metavar:
        return f"`{parameter.metavar}`".replace("|", "` or `")
    if typing.get_origin(annotation) is typing.Literal:
        return " or ".join(f"`{choice}`" for choice in typing.get_args(annotation))
    if isinstance(annotation, enum.EnumType):
        return " or ".join(f"`{choice.value}`" for choice in annotation)
    if typing.get_origin(annotation) in (list, tuple):
        annotation = typing.get_args(annotation)[0]
    low, high = parameter.min, parameter.max
    ends = [f"{word} {limit:g}" for word, limit in (("from", low), ("to", high)) if limit is not None]
    return " ".join([KINDS[annotation], *ends])


def row(parameter) -> str:
    """One row of a table."""
    is_option = parameter.param_type_name == "option"
    names = (*parameter.opts, *parameter.secondary_opts) if is_option else [label(parameter)]
    kind = kind_of(parameter) + ", several" * (parameter.multiple or parameter.nargs == -1)
    default = parameter.default
    shown = "required" if parameter.required else ""
    if not (
        parameter.required or default is None or isinstance(default, bool) or default in ((), []) or callable(default)
    ):
        shown = f"`{getattr(default, 'value', default)}`"
    meaning = " ".join((parameter.help or "").split()).replace("|", "\\|")
    return f"| {', '.join(f'`{name}`' for name in names)} | {kind} | {shown} | {meaning} |"


def label(argument) -> str:
    """An argument as usage names it."""
    return argument.metavar or argument.name.upper()


def section(name: str, command) -> str:
    """The text of one command."""
    told = inspect.cleandoc(command.help or "")
    parameters = [parameter for parameter in command.params if not parameter.hidden and parameter.name != "help"]
    arguments = [label(parameter) for parameter in parameters if parameter.param_type_name == "argument"]
    required = [
        f"{parameter.opts[0]} {parameter.metavar or parameter.name.upper()}"
        for parameter in parameters
        if parameter.required and parameter.param_type_name == "option"
    ]
    parts = [f"## {name}\n", f"```text\n{' '.join([name, *arguments, *required, '[OPTIONS]'])}\n```\n", told, ""]
    if parameters:
        parts += ["| name | value | default | meaning |\n|---|---|---|---|", *map(row, parameters), ""]
    return "\n".join(parts)


def render() -> str:
    """The whole page."""
    group = typer.main.get_command(app)
    return "\n".join([INTRODUCTION, *(section(*each) for each in commands(group, "billow"))]).rstrip() + "\n"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
