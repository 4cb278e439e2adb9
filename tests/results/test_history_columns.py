"""A run writes the columns that docs/histories.md lists: all of them, and no others."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

from billow.case.schema import Case
from billow.geometry.bag_shapes import square_bag
from billow.results.vtkhdf import FabricWriter
from billow.run.simulate import simulate

PAGE = Path(__file__).parents[2] / "docs" / "histories.md"
FREE = {"shape": "super-ellipsoid", "name": "impactor", "clearance": 0.05, "locked": False}


def documented(**named: list[str]) -> set[str]:
    """Columns of the page: those of every run, and of each section named by a word of its title, with its placeholder
    replaced by each of the names."""
    sections = re.split(r"^## ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    words = {"every run": [""]} | {word.replace("_", " "): names for word, names in named.items()}
    found = []
    for word, names in words.items():
        (section,) = (s for s in sections if word in s.splitlines()[0].replace("-", " "))
        for column in re.findall(r"^\| `(.*?)` \|", section, flags=re.MULTILINE):
            found += [one for name in names for one in spelled_out(re.sub(r"^[A-Z]+(?=_)", name, column))]
    assert len(found) == len(set(found))
    return set(found)


def spelled_out(column: str) -> list[str]:
    """The columns of a vector: a_x, a_y, a_z for a_x|y|z."""
    parts = re.fullmatch(r"(.*_)(\w(?:\\\|\w)+)( \[.*\])", column)
    return [parts[1] + axis + parts[3] for axis in parts[2].split("\\|")] if parts else [column]


def columns(case: dict, folder: Path) -> set[str]:
    """Of a run of one step or so."""
    short = {"end_time": 5e-5, "frames": 1, "histories_per_frame": 1}
    return set(simulate(Case.from_dict(case | {"run": short | case.get("run", {})}), folder).histories)


@pytest.mark.parametrize("gas", ["uniform-pressure", "corpuscular", "none"])
def test_a_run_with_bodies_and_straps(gas, tmp_path):
    case = {
        "bag": {"element_size": 0.06, "straps": {"count": 2}, "initial_gap": 0.02},
        "fabric": {"permeability": 0.03},
        "gas": {"model": gas, "particles": 1000},
        "obstacles": [{"shape": "plate"}, {"shape": "plate", "name": "wall", "height": -0.5}, FREE],
        "run": {"sensors": [{"name": "middle", "position": [0.0, 0.0, 0.01]}]},
    }
    gas_columns = {"vent": ["vent_1", "vent_2"], "part": ["front", "rear"]}
    assert columns(case, tmp_path / "run") == documented(
        **({} if gas == "none" else gas_columns),
        **({"sensor": ["middle"], "self_contact": [""]} if gas == "corpuscular" else {}),
        each_obstacle=["plate", "wall", "impactor"],
        free_obstacle=["impactor"],
        can_meet_another=["plate", "wall", "impactor"],
        strap=["strap_1", "strap_2"],
    )


def test_a_run_with_moved_bodies_and_tear_seams(tmp_path):
    motion = {"kind": "speed", "speed": 1.0}
    guided = {"kind": "guided", "mass": 1.0}
    case = {
        "bag": {
            "shape": "square", "element_size": 0.06, "vents": {"count": 0},
            "tear_seams": [{"name": "zip", "begin": [-0.2, 0.1], "end": [0.2, 0.1], "strength": 1e3}],
        },
        "fabric": {"permeability": 0.0},
        "obstacles": [
            {"shape": "plate", "name": "press", "height": 0.2, "normal": [0.0, 0.0, -1.0], "motion": motion},
            {"shape": "box", "name": "sled", "size": [0.1, 0.1, 0.1], "place": [0.0, 0.0, 0.05], "motion": guided},
        ],
    }  # fmt: skip
    both = ["press", "sled"]
    assert columns(case, tmp_path / "run") == documented(
        part=["front", "rear"], each_obstacle=both, obstacles_that_are_moved=[""], moved_or_guided=both,
        each_guided=["sled"], seams_that_tear=[""], tear_seam=["zip"], can_meet_another=both,
    )  # fmt: skip


def test_a_run_with_layers_in_stacks(tmp_path):
    case = {
        "bag": {"element_size": 0.06, "vents": {"count": 0}, "straps": {"count": 0}},
        "fabric": {"self_contact": "layers"},
        "obstacles": [],
    }
    named = {"part": ["front", "rear"], "self_contact": [""], "layers_in_stacks": [""]}
    assert columns(case, tmp_path / "run") == documented(**named)


def test_a_run_with_chambers(tmp_path):
    case = {
        "bag": {
            "shape": "rectangular", "length": 0.5, "width": 0.3, "chambers": 2, "element_size": 0.05,
            "mouth_radius": 0.045, "vents": {"chambers": [2], "diameter": 0.03},
        },
        "fabric": {"permeability": 0.03},
        "obstacles": [],
    }  # fmt: skip
    chambers = ["chamber_1", "chamber_2"]
    assert columns(case, tmp_path / "run") == documented(
        vent=["vent_1"],
        part=[f"{side}_{chamber}" for side, chamber in itertools.product(("front", "rear"), chambers)],
        opening=["opening_1"],
        chamber_of_several=chambers,
    )


def test_a_run_with_a_birth_time(tmp_path):
    shape = square_bag(0.4, 4, 0.04)
    paths = [tmp_path / "start.vtkhdf", tmp_path / "reference.vtkhdf"]
    for path in paths:
        with FabricWriter(
            path, shape.positions, shape.surface.triangles, shape.surface.part, ["front", "rear"]
        ) as file:
            file.append(0.0, shape.positions)
    case = {
        "bag": {
            "shape": "mesh", "start": str(paths[0]), "reference": str(paths[1]), "birth_time": 0.01,
            "parts": [{"name": "front"}, {"name": "rear"}],
        },
        "fabric": {"permeability": 0.0},
        "inflator": {"jets": {"count": 0}},
        "obstacles": [],
    }  # fmt: skip
    assert columns(case, tmp_path / "run") == documented(birth_time=[""], part=["front", "rear"])
