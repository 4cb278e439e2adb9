"""The commands of docs/decks.md do what it says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "decks.md"


def commands() -> list[str]:
    """Lines of the guide's code blocks."""
    blocks = re.findall(r"^```\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines() if line]


def test_every_command_of_the_guide_runs(tmp_path):
    lines = commands()
    assert len(lines) >= 6
    assert all(line.startswith("billow ") for line in lines)
    for line in lines:
        words, _, target = line.removeprefix("billow ").partition(" > ")
        done = subprocess.run(
            [sys.executable, "-m", "billow.cli.main", *words.split()], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == 0, (line, done.stdout, done.stderr)
        if target:
            (tmp_path / target).write_text(done.stdout)
    assert (tmp_path / "driver" / "import.md").stat().st_size > 1000
    assert (tmp_path / "driver_run" / "run.json").exists()


@pytest.mark.parametrize("word", ["--units", "--part", "--close", "--merge", "--base", "--fabric-curves"])
def test_the_page_names_the_options(word):
    assert word in PAGE.read_text(encoding="utf-8")
