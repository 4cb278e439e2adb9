"""The command answers as always whatever surrounds it. `trust/environments.py` tries each kind by itself, and more."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib

import pytest

from trust import environments

TOGETHER = (
    *("another compiler", "no threads", "other arithmetic", "other files", "other figures", "another Python"),
    *("settings of figures that cannot be read", "settings of a compiler that cannot be read", "other commands"),
    *("other learning", "a terminal of ASCII", "a terminal of one column", "a home without a path"),
)
PROGRAM = """
import sys
from billow.cli.main import main
for command in ("check case.toml", "tank forward tank.toml --out tank"):
    sys.argv = ["billow", *command.split()]
    try:
        main()
    except SystemExit as end:
        assert not end.code, command
"""


@pytest.mark.slow
def test_variables_settings_and_a_terminal_of_ascii_change_nothing(tmp_path):
    variables = {k: v for name in TOGETHER for k, v in environments.HOSTILE[name].variables.items()}
    for name in TOGETHER:
        for file, content in environments.HOSTILE[name].files.items():
            (tmp_path / file).write_bytes(content)
    (tmp_path / "case.toml").write_text(environments.CASE, encoding="utf-8")
    (tmp_path / "tank.toml").write_text(environments.TANK, encoding="utf-8")
    variables = {**os.environ, **{name: value for name, value in variables.items() if value is not None}}
    program = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(program, cwd=tmp_path, env=variables, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Gr??e ? ?" in done.stdout
    left = {"case.toml", "tank.toml", "tank", ".numba_config.yaml", "matplotlibrc"}
    assert {path.name for path in tmp_path.iterdir()} == left
    assert tomllib.loads((tmp_path / "tank" / "summary.toml").read_text(encoding="utf-8"))
