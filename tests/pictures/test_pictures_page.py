"""docs/pictures.md: its Python runs, and its commands draw."""

import re
import shlex
import shutil
from pathlib import Path

from typer.testing import CliRunner

from billow.cli.main import app

PAGE = (Path(__file__).parents[2] / "docs" / "pictures.md").read_text(encoding="utf-8")


def test_commands_of_the_page_work(pair, tmp_path, monkeypatch):
    """But for those that need a surrogate, a run of a study, or a table with the test's own names."""
    shutil.copytree(pair[0], tmp_path / "runs" / "bag")
    shutil.copytree(pair[1], tmp_path / "runs" / "hot")
    rows = "".join(f"{0.05 * k:.2f},{k * 0.02},101.3\n" for k in range(400))
    (tmp_path / "test.csv").write_text("time [ms],impactor acceleration z [g],pressure [kPa]\n" + rows)
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^billow (.*?)(?:  +#.*)?$", PAGE, flags=re.MULTILINE)
    tried = [command for command in commands if "safetensors" not in command]
    assert len(tried) == 8
    for command in tried:
        done = CliRunner().invoke(app, shlex.split(command) + (["--size", "240x200"] if "render" in command else []))
        assert done.exception is None, (command, done.exception)
    drawn = {path.name for path in tmp_path.iterdir()}
    assert {"render.png", "strip.png", "inside.png", "bag.gif", "plot.png", "compare.png"} <= drawn


def test_the_python_of_the_page_works(pair, tmp_path, monkeypatch):
    shutil.copytree(pair[0], tmp_path / "runs" / "bag")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    told: dict = {}
    exec(code, told)
    assert told["picture"].startswith(b"\x89PNG")
