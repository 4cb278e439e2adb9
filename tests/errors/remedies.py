"""Whether a remedy names real things: commands with all they need, options, keys of the case, pages of the docs."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import typer

from billow.case import schema
from billow.case.bag.schema_bag import BAGS
from billow.case.bag.schema_folds import FOLDS
from billow.case.obstacles.obstacles import OBSTACLES
from billow.cli.main import app
from trust.generated_cases import fields

ROOT = Path(__file__).parents[2]
COMMANDS = typer.main.get_command(app).commands
OPTIONS = {option for command in COMMANDS.values() for p in command.params for option in p.opts if option[:2] == "--"}
FIELDS = [
    *fields(),
    *(field for bag in BAGS.values() for field in fields(bag, ("bag",))),
    *(field for fold in FOLDS.values() for field in fields(fold, ("bag", "folds"))),
    *(field for table in OBSTACLES.values() for field in fields(table, ("obstacles", 0))),
]
KEYS = {".".join("*" if isinstance(part, int) else part for part in path) for path, _ in FIELDS}
TABLES = {key.rsplit(".", depth)[0] for key in KEYS for depth in range(1, 4)}


def unreal(text: str) -> list[str]:
    """What a text names that does not exist."""
    return [*_commands(text), *_options(text), *_keys(text), *_pages(text)]


def _commands(text: str):
    for found in re.finditer(r"(`?)\bbillow ([a-z]+)([^`;>]*)", text):
        quoted, name, rest = found.groups()
        rest = re.split(r", |,$| \(", rest)[0]
        if name not in COMMANDS:
            yield f"billow {name}"
        elif rest.strip() or not quoted:  # a name in backticks is no command to copy
            try:
                COMMANDS[name].make_context(name, shlex.split(rest))
            except Exception as problem:  # typer has its own copy of click, and does not show it
                yield f"billow {name}{rest}: {problem}"


def _options(text: str):
    for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", text):
        if option not in OPTIONS:
            yield option


def _keys(text: str):
    for key in re.findall(r"(?<![\w/.-])[a-z_]+(?:\.[A-Za-z0-9_-]+)+", text):
        first, *_, last = key.split(".")
        if first not in schema.Case.model_fields:
            continue  # a file, a module
        if first == "obstacles":
            key = ".".join([first, "*", *key.split(".")[2:]])
        if key not in KEYS | TABLES and last not in ("toml", "partial"):
            yield key


def _pages(text: str):
    for page in re.findall(r"(?:docs|examples)/[\w.]*", text):
        if not (ROOT / page).exists():
            yield page
