"""The commands of the tutorials work, in their order, as they stand there; only smaller, so that they take seconds."""

from __future__ import annotations

import re
import runpy
import shlex
import tomllib
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from billow.case.schema import Case
from billow.cli.main import app

DOCS = Path(__file__).parents[2] / "docs"
TUTORIALS = ("first_bag", "own_mesh", "good_run", "which_gas", "study_to_surrogate")
BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
SMALLER = {
    "element_size = 0.020": "element_size = 0.06",
    'end_time = "50 ms"': 'end_time = "8 ms"',
    'end_time = "70 ms"': 'end_time = "8 ms"',
    "frames = 50 ": "frames = 8 ",
    "n, side, height = 20": "n, side, height = 8",
}
"""What of the files is made smaller, and of the settings of commands."""
SMALLER_SETTINGS = {
    "bag.element_size=0.015": "bag.element_size=0.05", "bag.element_size=0.03": "bag.element_size=0.06",
    "run.end_time=20 ms": "run.end_time=6 ms",
}  # fmt: skip

COMMANDS = typer.main.get_command(app).commands


def blocks(name: str) -> list[tuple[str, str, str]]:
    """Language, text, and the file that the sentence before names, of each block of a tutorial."""
    page = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    found = []
    for match in BLOCK.finditer(page):
        indent, language, text = match.groups()
        named = re.search(r"`([\w.]+)`:\s*$", page[: match.start()])
        found.append((language, re.sub(f"^{indent}", "", text, flags=re.MULTILINE), named[1] if named else ""))
    return found


def smaller(text: str) -> str:
    for old, new in SMALLER.items():
        text = text.replace(old, new)
    return text


def obey(line: str, place: Path) -> None:
    """Run a line of a shell."""
    line, redirected, target = line.partition(" > ")
    program, *words = shlex.split(line)
    if program == "pip":
        return
    if program == "python":
        runpy.run_path(words[0], run_name="__main__")
        return
    assert program == "billow"
    done = CliRunner().invoke(app, [SMALLER_SETTINGS.get(word, word) for word in words])
    assert done.exception is None, f"{line}: {done.exception}"
    if redirected:
        (place / target.strip()).write_text(smaller(done.output))


@pytest.mark.parametrize("pages", [("first_bag", "good_run"), ("own_mesh",)], ids=" then ".join)
def test_a_tutorial_can_be_followed(pages, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for page in pages:
        for language, text, file in blocks(page):
            if file:
                (tmp_path / file).write_text(smaller(text))
            elif language == "python":
                exec(compile(text, f"{page}.md", "exec"), {})
            else:
                for line in text.splitlines():
                    obey(line, tmp_path)
    expected = {
        "first_bag": ("bag.html", "bag.png", "curves.png", "both.html", "python.png"),
        "own_mesh": ("pillow.html", "pillow.png", "hotter.png"),
    }
    for name in expected[pages[0]]:
        assert (tmp_path / name).stat().st_size > 5000


@pytest.mark.parametrize("name", TUTORIALS)
def test_commands_and_keys_of_a_tutorial_are_real(name):
    for language, text, _ in blocks(name):
        if not language:
            for line in text.splitlines():
                program, *words = shlex.split(line.partition(" > ")[0])
                if program == "billow":  # fails for options and arguments that the command does not have
                    COMMANDS[words[0]].make_context(words[0], words[1:])
        elif language == "toml":
            table = tomllib.loads(text)
            if "bag" in table:
                assert table["bag"]["shape"] == "mesh"
            else:
                keys = [key for parameter in table["parameters"] for key in parameter["keys"]]
                Case().vary({key: 600.0 if "temperature" in key else 0.01 for key in keys})


def test_every_tutorial_is_linked_from_the_quickstart():
    index = (DOCS / "quickstart.md").read_text(encoding="utf-8")
    assert [name for name in TUTORIALS if f"({name}.md)" not in index] == []
