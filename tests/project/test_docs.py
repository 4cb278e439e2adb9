"""What the pages name is there: files of the repository, and commands of `billow`."""

import re
import shlex
from pathlib import Path

import pytest
import typer

from billow.cli.main import app

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")])
BILLOW = typer.main.get_command(app)
COMMANDS = set(BILLOW.commands)


def missing_files(text: str, page: Path) -> list[str]:
    """Files in backticks and targets of links that are neither in the repository nor in the package, and pages that the
    site, which holds docs alone, would not have."""
    named = re.findall(r"`((?:[\w.-]+/)+[\w.-]+\.(?:py|json|csv))`", text)
    targets = re.findall(r"\]\(([^)#:]+)\)", text)
    linked = [target for target in targets if not (page.parent / target).exists()]
    if page.parent.name == "docs":
        linked += [target for target in targets if target.startswith("../") and target.endswith(".md")]
    places = (ROOT, ROOT / "src" / "billow")
    return linked + [path for path in named if not any((place / path).exists() for place in places)]


def shell_blocks(text: str) -> list[str]:
    """Blocks of code without a language. All blocks are matched: the end of one would else be taken for a beginning."""
    blocks = re.findall(r"^ *```([^\n`]*)\n(.*?)^ *```$", text, re.MULTILINE | re.DOTALL)
    return [block for language, block in blocks if not language]


def missing_commands(text: str) -> list[str]:
    """First words of `billow ...` in code that are no commands."""
    code = "\n".join(shell_blocks(text) + re.findall(r"`([^`\n]+)`", text))
    return sorted(set(re.findall(r"^ *billow ([a-z]+)", code, re.MULTILINE)) - COMMANDS)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_and_commands_that_a_page_names_exist(page):
    text = page.read_text(encoding="utf-8")
    assert missing_files(text, page) == []
    assert missing_commands(text) == []


def parse(line: str) -> None:
    """Fails for options, values and arguments that a command does not take; ... stands for more of the same."""
    _, *words = shlex.split(line.partition(" > ")[0], comments=True)
    command = BILLOW
    while hasattr(command, "commands"):
        name, *words = words
        command = command.commands[name]
    command.make_context(name, [word for word in words if word != "..."])


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "commands.md"], ids=lambda page: page.name)
def test_every_command_line_of_a_page_can_be_given(page):
    for block in shell_blocks(page.read_text(encoding="utf-8")):
        for line in block.replace("\\\n", " ").splitlines():
            if line.lstrip().startswith("billow "):
                parse(line)


def missing_options(text: str) -> list[str]:
    """Options in `billow ...` within sentences that the command does not have."""
    found = []
    for code in re.findall(r"`(billow [^`]+)`", text):
        _, *words = shlex.split(code)
        command = BILLOW
        while hasattr(command, "commands") and words and words[0] in command.commands:
            command = command.commands[words.pop(0)]
        known = {name for option in command.params for name in option.opts} | {"--help", "--install-completion"}
        found += [f"{code}: {word}" for word in words if word.startswith("--") and word not in known]
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_options_that_a_sentence_names_exist(page):
    assert missing_options(page.read_text(encoding="utf-8")) == []


def test_an_option_that_is_not_there_is_found():
    assert missing_options("so `billow run bag.toml --out a --fast` does") == [
        "billow run bag.toml --out a --fast: --fast"
    ]


def test_a_line_that_cannot_be_given_is_found():
    for wrong in ("billow run bag.toml", "billow run bag.toml --out a --fast", "billow schema nowhere"):
        with pytest.raises(Exception, match=r"out|fast|nowhere"):
            parse(wrong)


def test_what_is_not_there_is_found():
    page = ROOT / "docs" / "rom.md"
    text = "`rom/nowhere.py`, [a page](nothing.md), [another](../README.md), `billow fly`\n"
    text += "```\nbillow run bag.toml\nbillow land\n```\n"
    assert missing_files(text, page) == ["nothing.md", "../README.md", "rom/nowhere.py"]
    assert missing_commands(text) == ["fly", "land"]
