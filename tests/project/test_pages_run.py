"""Every command and every snippet of the pages runs, as it stands there; only smaller, so that it takes seconds.

Blocks without a language are lines of a shell; `toml` is a case, a study, a tank test, or a file that the sentence
before names; `text` is not run, but for the table of a test. Some pages have tests of their own.
"""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.case.schema import Case
from billow.cli.main import app
from billow.run.check import describe
from billow.study.definition import StudyDefinition

ROOT = Path(__file__).parents[2]
ELSEWHERE = {
    "design": "tests/design/test_page.py", "decks": "tests/decks/test_decks_page.py",
    "dyna_results": "tests/study/test_dyna_page.py",
}  # fmt: skip

GIVEN = {
    "README": ("demo",),
    "index": (),
    "first_bag": (),
    "good_run": (),
    "own_mesh": (),
    "which_gas": (),
    "quickstart": ("study.toml", "my_study"),
    "pictures": ("runs", "test.csv", "study"),
    "pages": ("runs", "test.csv", "demo", "study"),
    "gallery": ("examples", "pillow.toml", "pillow.vtk", "my_study"),
    "rom": ("study.toml", "STUDY", "next.csv"),
    "coupled": ("examples",),
    "tank": ("examples",),
    "packing": ("head.stl",),
    "case": (),
    "folding": (),
    "mesh_gas": (),
    "study": (),
}
"""What a page takes for granted."""

SMALLER = {
    "element_size = 0.020": "element_size = 0.06",
    'element_size = "10 mm"': 'element_size = "30 mm"',
    'end_time = "50 ms"': 'end_time = "20 ms"',
    'end_time = "70 ms"': 'end_time = "20 ms"',
    "frames = 50 ": "frames = 20 ",
    "n, side, height = 20": "n, side, height = 8",
    "train = 24 ": "train = 12 ",
    "test = 6 ": "test = 3 ",
    "train = 400\ntest = 50\nnested = [100, 200]": "train = 10\ntest = 3",
    "element_size = 0.0085 ": "element_size = 0.06",
    "locked = true ": "locked = false\nmass = 4.5 ",
}
"""What of the files is made smaller; the obstacle is free, so that a coupled model can learn from the study."""

LINES = {
    "billow verify": "billow verify I1",  # all cases take minutes; tests/verification runs them
    # tests/study/test_workers.py has a cluster
    "billow study study.toml --out my_study --scheduler tcp://host:8786": "",
    # tests/study/test_dyna_results.py has runs of LS-DYNA, and what is asked of them
    "billow import crash_runs --out study --units kg-mm-ms --part 3": "",
    "billow train study": "",
    'print(respond("study", [slowest]).csv())': "",
}  # fmt: skip
"""Lines that are given in another way, or not."""

SETTINGS = {
    "bag.element_size=0.015": ["bag.element_size=0.05"],
    "bag.element_size=0.03": ["bag.element_size=0.06"],
    "run.end_time=20 ms": ["run.end_time=6 ms"],
    "gas.cell=15 mm": ["gas.cell=60 mm"],
    "gas.model=mesh": ["gas.model=mesh", "--set", "run.end_time=3 ms"],
    "gas.model=corpuscular": ["gas.model=corpuscular", "--set", "gas.particles=1000", "--set", "run.end_time=3 ms"],
}
"""Values of --set that ask for less."""

EXAMPLES = {
    "driver_locked": ["bag.element_size=0.06"],
    "driver_free": ["bag.element_size=0.06"],
    "driver_folded": ["bag.element_size=0.025", "run.end_time=1 ms"],
    "cover": ["run.end_time=0.05 ms"],
    "press": ["run.end_time=0.2 ms", "bag.element_size=0.02", "bag.mouth_radius=0.03"],
    "driver_mesh": ["bag.element_size=0.06", "gas.cell=60 mm", "run.end_time=5 ms"],
    "square_two_stage_up": ["bag.element_size=0.05"],
    "square_spinning_jet_up": ["bag.element_size=0.05"],
    "window_tubes_up": [
        "bag.element_size=0.018", "bag.length=0.7", "bag.tubes=4", "bag.mouth_tube=2", "run.end_time=0.2 ms"
    ],
    "folded_tube_up": ["bag.element_size=0.025", "run.end_time=1 ms"],
}  # fmt: skip
"""Settings that make examples of the gallery small."""


@dataclass(frozen=True)
class Block:
    """A block of code of a page."""

    language: str
    text: str
    file: str
    """What the sentence before names, if it ends with a file."""


def blocks(name: str) -> list[Block]:
    page = (ROOT / "README.md" if name == "README" else ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    found = []
    for match in re.finditer(r"^( *)```([^\n`]*)\n(.*?)^ *```$", page, re.MULTILINE | re.DOTALL):
        indent, language, text = match.groups()
        named = re.search(r"`([\w.]+)`:\s*$", page[: match.start()])
        text = re.sub(f"^{indent}", "", text, flags=re.MULTILINE)
        found.append(Block(language, text, named[1] if named else ""))
    return found


def smaller(text: str) -> str:
    for old, new in SMALLER.items():
        text = text.replace(old, new)
    return text


def within(times: str, end: float) -> str:
    """Those of the times of a picture [ms] that a shorter run has."""
    kept = [time for time in times.split(",") if float(time.removesuffix("ms")) <= end]
    return ",".join(kept or ["0 ms"])


class Shell:
    """Lines of a shell, given in the folder at hand."""

    def __init__(self):
        self.ends: dict[str, float] = {}
        """Of runs that are made smaller [ms]."""

    def obey(self, line: str) -> None:
        line = LINES.get(re.sub(r" +#.*", "", line), line)
        line, redirected, target = line.partition(" > ")
        words = shlex.split(line, comments=True)
        if not words or words[0] in ("pip", "make", "."):  # set-up, of which this test is a part
            return
        program, *words = words
        if program == "python":
            runpy.run_path(words[0], run_name="__main__")
            return
        assert program == "billow", line
        done = CliRunner().invoke(app, self.cheap([w for word in words for w in SETTINGS.get(word, [word])]))
        assert done.exception is None, f"{line}: {done.exception}\n{done.output}"
        if redirected:
            Path(shlex.split(target, comments=True)[0]).write_text(smaller(done.output))
        for option, value in pairwise(words):
            assert option != "--out" or Path(value).exists(), f"{line}: {value} was not written"

    def cheap(self, words: list[str]) -> list[str]:
        """The same command with less to do."""
        command, *rest = words
        if command == "run" and rest[0].startswith("examples"):
            settings = EXAMPLES[Path(rest[0]).stem]
            words = words + [word for setting in settings for word in ("--set", setting)]
            for setting in settings:
                if setting.startswith("run.end_time="):
                    self.ends[rest[2]] = float(setting.partition("=")[2].removesuffix("ms"))
        if command == "render":
            words = [*words, "--size", "240x200"]
            if "--times" in words and rest[0] in self.ends:
                k = words.index("--times") + 1
                words[k] = within(words[k], self.ends[rest[0]])
        if command == "train":
            words = [*words, "--epochs", "30"]
        if words[:2] == ["couple", "predict"]:
            words = [*words, "--despite-verdict"]  # a dozen small runs do not teach six parameters
        return words


def read_table(text: str, folder: Path) -> None:
    """A snippet of a case, added to the example; a study; or a tank test."""
    table = tomllib.loads(text)
    if "tank" in table:
        (folder / "tank.toml").write_text(text)
        Shell().obey("billow tank forward tank.toml --out by_table")
    elif "parameters" in table:
        (folder / "snippet.toml").write_text(text)
        shutil.copy(folder / "bag.toml", folder / table["case"])
        definition = StudyDefinition.load(folder / "snippet.toml")
        middle = {key: 0.5 * (p.low + p.high) for p in definition.parameters for key in p.keys}
        Case.load(folder / "bag.toml").vary(middle)
    elif "bag" in table and "mouth_radius" in table["bag"]:
        assert Case.from_dict(table).title
    else:
        case = Case.from_dict({**tomllib.loads((folder / "bag.toml").read_text()), **table})
        if "housing" not in text:  # which holds a folded bag, and not this one
            assert "triangles" in describe(case)


def walk(name: str, folder: Path) -> None:
    """All blocks of a page, in their order, in one folder and one session of Python."""
    shell, session = Shell(), {}
    for block in blocks(name):
        assert block.language in ("", "python", "toml", "text", "{toctree}"), block
        if block.file:
            (folder / block.file).write_text(smaller(block.text))
        elif block.language == "python":
            code = "\n".join(LINES.get(line, line) for line in block.text.splitlines())
            exec(compile(code, f"{name}.md", "exec"), session)
        elif block.language == "toml":
            read_table(smaller(block.text), folder)
        elif block.text.startswith("time ["):
            (folder / "page.csv").write_text(block.text)
            shell.obey("billow plot page.csv -q pressure --out page.png")
        elif not block.language:
            for line in block.text.replace("\\\n", " ").splitlines():
                shell.obey(line)


@pytest.fixture(scope="module")
def begun(tmp_path_factory) -> Path:
    """A folder with all that pages take for granted: it is the page `study_to_surrogate`, walked through."""
    folder = tmp_path_factory.mktemp("begun")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Shell().obey("billow check --example > bag.toml")
        Shell().obey("billow run bag.toml --out runs/bag")
        Shell().obey("billow run bag.toml --out runs/hot --set inflator.temperature=750")
        walk("study_to_surrogate", folder)
        for block in blocks("own_mesh"):
            if block.language == "python":
                exec(smaller(block.text), {})
            elif block.language == "toml":
                Path("pillow.toml").write_text(block.text)
    rows = "".join(f"{0.05 * k:.2f},{k * 0.02},101.3\n" for k in range(200))
    (folder / "test.csv").write_text("time [ms],impactor acceleration z [g],pressure [kPa]\n" + rows)
    corners = np.array([[0, 0, 0], [90, 0, 0], [0, 90, 0], [0, 0, 90]])
    facets = ["facet\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners[list(f)]) + "endloop\n"
              "endfacet\n" for f in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))]  # fmt: skip
    (folder / "head.stl").write_text("solid head\n" + "".join(facets) + "endsolid head\n")
    (folder / "next.csv").write_text("permeability [-]\n0.03\n")
    return folder


def begin(name: str, begun: Path, folder: Path) -> None:
    """Copies what the page takes for granted."""
    shutil.copy(begun / "bag.toml", folder / "bag.toml")  # snippets are added to it
    for given in GIVEN[name]:
        if given == "examples":
            shutil.copytree(ROOT / "examples", folder / "examples")
            for path in (folder / "examples" / "studies").glob("*.toml"):
                path.write_text(smaller(path.read_text()))
        elif given in ("demo", "study", "STUDY"):
            shutil.copytree(begun / "my_study", folder / given)
        elif (begun / given).is_dir():
            shutil.copytree(begun / given, folder / given)
        else:
            shutil.copy(begun / given, folder / given)


@pytest.mark.parametrize("name", GIVEN)
def test_a_page_runs(name, begun, tmp_path, monkeypatch):
    begin(name, begun, tmp_path)
    monkeypatch.chdir(tmp_path)
    walk(name, tmp_path)


def test_no_page_with_code_is_left_out():
    pages = {"README", *(path.stem for path in (ROOT / "docs").glob("*.md"))}
    with_code = {page for page in pages if any(block.language not in ("text", "{toctree}") for block in blocks(page))}
    assert with_code == {*GIVEN, *ELSEWHERE, "study_to_surrogate"}
    assert all((ROOT / test).exists() for test in ELSEWHERE.values())


def test_every_tutorial_is_linked_from_the_quickstart():
    index = (ROOT / "docs" / "quickstart.md").read_text(encoding="utf-8")
    tutorials = ("first_bag", "own_mesh", "study_to_surrogate", "dyna_results", "which_gas", "good_run")
    assert [name for name in tutorials if f"({name}.md)" not in index] == []
