"""The cache of compiled kernels: one for all processes, keyed by content, never stale. Tried with a toy package."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

import billow
from billow.base import cache_folder, compiled, compiled_parts, surroundings

LAW = """
from billow.base.compiled import scalar

@scalar
def stress(strain):
    return 2.0 * strain
"""

MEMBRANES = {
    "one": "from billow.toy.law import stress",
    "two": "from billow.toy import law\nstress = law.stress",
    "three": "import billow.toy.law\nstress = billow.toy.law.stress",
    "four": "from billow.toy.between import stress",
    "five": "from billow.toy import (  # the laws (of all)\n    law as ours,\n)\nstress = ours.stress",
    "six": "import os; from billow . toy . law import \\\n    stress",
    "seven": "from billow.toy.plain.through import stress",
}
"""Module -> how it imports the scalar; the fourth and seventh through another file."""

MEMBRANE = """
from billow.base.compiled import kernel, scalar

@scalar
def force(strain):
    return stress(strain) + 1.0

@kernel
def forces(n, strain):
    return n * force(strain)
"""

PROGRAM = """
import importlib, json, os, sys
from billow.base.compiled import telling
modules = {name: importlib.import_module("billow.toy." + name) for name in sys.argv[1:]}
if "PROCESSOR" in os.environ:
    import numba
    numba.config.CPU_NAME = os.environ["PROCESSOR"]
print("ready", flush=True)
sys.stdin.readline()
said = []
with telling(said.append):
    answers = {name: module.forces(1, 1.0) for name, module in modules.items()}
dispatchers = {d for m in modules.values() for d in (m.forces.serial, m.force, m.stress)}
compiled = {f"{d.__module__}.{d.__name__}": sum(d.stats.cache_misses.values()) for d in dispatchers}
print(json.dumps({"answers": answers, "compiled": compiled, "said": said}))
"""
"""Calls the kernels of the modules named and counts how often each function was compiled."""

STALLED = """
import time
from billow.toy import one
def stall(*_):
    print("compiling", flush=True)
    time.sleep(600)
one.force._compiler.compile = stall
one.forces(1, 1.0)
"""

PARTS = """
import importlib, json, os, pathlib, sys
one, two = (importlib.import_module("billow.toy." + name) for name in sys.argv[1:])
print("ready", flush=True)
sys.stdin.readline()

def kept():
    files = pathlib.Path(os.environ["BILLOW_CACHE"]).rglob("*.nbi")
    return sorted(f"{f.parent.name.split('-')[0]}.{f.name.split('.')[1].split('-')[0]}" for f in files)

kernels = [one.forces(1, 1.0), two.forces(1, 1.0)]
at_first = kept()
by_python = [one.force(1.0), one.force.py_func.__globals__["stress"].py_func(1.0)]
print(json.dumps([kernels + by_python, at_first, kept()]))
"""
"""Calls kernels, then what they call, and lists what is kept on disk."""

UNCACHED = """
import json
from billow.toy import one
from billow.base.compiled import scalar, telling
print("ready", flush=True)
exec('@scalar\\ndef typed(x):\\n    return 3.0 * x')
said = []
with telling(said.append):
    answers = [one.forces(1, 1.0), typed(2.0)]
print(json.dumps([*answers, said]))
"""


@pytest.fixture
def package(tmp_path) -> Path:
    """A folder with a package `billow` of a few files: the real compiled.py, a law, and kernels that call it."""
    toy = tmp_path / "checkout" / "billow" / "toy"
    for folder in (toy.parent, toy.parent / "base", toy):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "__init__.py").touch()
    shutil.copy(billow.__file__, toy.parent)
    for module in (cache_folder, compiled, compiled_parts, surroundings):
        shutil.copy(module.__file__, toy.parent / "base")
    (toy / "law.py").write_text(LAW)
    for between in (toy / "between.py", toy / "plain" / "through.py"):  # the second in a folder without __init__.py
        between.parent.mkdir(exist_ok=True)
        between.write_text("from billow.toy.law import stress as stress\n")
    for name, imports in MEMBRANES.items():
        (toy / f"{name}.py").write_text(imports + MEMBRANE)
    return toy.parent.parent


def start(package: Path, *arguments: str, program: str = PROGRAM, **environment: str) -> subprocess.Popen:
    paths = {"PYTHONPATH": str(package), "BILLOW_CACHE": str(package.parent / "cache")}
    return subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, **paths, **environment},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def answer(*processes: subprocess.Popen, meanwhile: Callable[[], None] = lambda: None) -> list:
    """What they print last. They begin when all are ready."""
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    meanwhile()
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()
    outputs = [process.communicate(timeout=120)[0] for process in processes]
    assert [process.returncode for process in processes] == [0] * len(processes)
    return [json.loads(output) for output in outputs]


def test_kernels_are_compiled_again_after_an_edit_they_depend_on_and_only_then(package, tmp_path):
    """However the edited file is imported. Elsewhere and later the same text is not compiled again."""
    (first,) = answer(start(package, *MEMBRANES))
    assert first["answers"] == dict.fromkeys(MEMBRANES, 3.0)
    assert set(first["compiled"].values()) == {1}
    assert first["said"] == [compiled.COMPILING]

    elsewhere = tmp_path / "another" / "place"
    shutil.copytree(package, elsewhere)
    for path in elsewhere.rglob("*.py"):
        os.utime(path, (1e9, 1e9))
    (same,) = answer(start(elsewhere, *MEMBRANES, BILLOW_CACHE=str(tmp_path / "cache")))
    assert same["answers"] == first["answers"]
    assert set(same["compiled"].values()) == {0}
    assert same["said"] == []

    (package / "billow" / "toy" / "law.py").write_text(LAW.replace("2.0", "5.0"))
    (edited,) = answer(start(package, *MEMBRANES))
    assert edited["answers"] == dict.fromkeys(MEMBRANES, 6.0)


def test_processes_that_need_the_same_kernels_compile_each_once(package):
    """Two begin at the same time, and call the kernels in opposite order."""
    one, other = answer(start(package, *MEMBRANES), start(package, *reversed(MEMBRANES)))
    assert one["answers"] == other["answers"]
    kernels = [name for name in one["compiled"] if name.endswith(".forces")]
    assert len(kernels) == len(MEMBRANES)
    assert {name: one["compiled"][name] + other["compiled"][name] for name in kernels} == dict.fromkeys(kernels, 1)


def test_what_a_kernel_calls_is_a_part_of_it_and_whole_where_python_calls_it(package):
    (first,) = answer(start(package, "one", "two", program=PARTS))
    assert first == [[3.0, 3.0, 3.0, 2.0], ["one.forces", "two.forces"], ["one.force", "one.forces", "two.forces"]]
    (second,) = answer(start(package, "one", "two", program=PARTS))
    assert second[0] == first[0]


def test_a_process_killed_while_it_compiles_keeps_nobody_waiting(package):
    stalled, waiting = start(package, program=STALLED), start(package, "one")
    assert stalled.stdout.readline() == "compiling\n"
    threading.Timer(0.5, stalled.kill).start()
    assert answer(waiting)[0]["answers"] == {"one": 3.0}
    stalled.communicate()


def test_damaged_files_are_compiled_again_and_other_processors_have_their_own(package):
    answer(start(package, "one"))
    for path in (package.parent / "cache").rglob("*.nbc"):
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1  # in the machine code
        path.write_bytes(data)
    (again,) = answer(start(package, "one"))
    assert again["answers"] == {"one": 3.0}
    assert set(again["compiled"].values()) == {1}
    same, other = answer(start(package, "one"), start(package, "one", PROCESSOR="generic"))
    assert set(same["compiled"].values()) == {0}
    assert set(other["compiled"].values()) == {1}


def test_no_damage_to_an_entry_is_taken_for_a_kernel(tmp_path):
    entries, other = compiled._Entries(str(tmp_path), "forces"), compiled._Entries(str(tmp_path), "other")
    other.save("key", "other code")
    entries.save("key", "code")
    assert entries.load("key") == "code"
    for path in sorted(tmp_path.glob("forces-*")):
        sound = path.read_bytes()
        foreign = next(tmp_path.glob(f"other-*{''.join(path.suffixes)}")).read_bytes()
        damaged = [sound[:end] for end in range(len(sound))] + [foreign, sound + b"x"]
        damaged += [sound[:k] + bytes([sound[k] ^ 1]) + sound[k + 1 :] for k in range(len(sound))]
        for content in damaged:
            path.write_bytes(content)
            assert entries.load("key") is None
        path.unlink()
        for put in (lambda: None, path.mkdir, lambda path=path: os.mkfifo(path)):
            put()
            assert entries.load("key") is None
            if path.is_dir():
                path.rmdir()
        path.unlink()
        path.write_bytes(sound)
    assert entries.load("key") == "code"


def test_a_cache_that_vanishes_stops_nobody(package):
    def vanish() -> None:
        shutil.rmtree(package.parent / "cache")
        (package.parent / "cache").touch()

    (found,) = answer(start(package, "one"), meanwhile=vanish)
    assert found["answers"] == {"one": 3.0}


def test_surroundings_do_not_change_how_kernels_are_compiled(package, tmp_path, monkeypatch):
    """Variables of numba, and its settings file in the working folder."""
    (first,) = answer(start(package, "one"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / ".numba_config.yaml").write_text("opt: 0\nboundscheck: 1\ncpu_name: generic\ndisable_jit: 1\n")
    hostile = {
        "OPT": "0", "CPU_NAME": "generic", "DISABLE_JIT": "1", "NUM_THREADS": "0", "THREADING_LAYER": "none",
        "CACHE_LOCATOR_CLASSES": "none", "LOOP_VECTORIZE": "no", "DEBUGINFO": "1", "DUMP_IR": "1",
    }  # fmt: skip
    (same,) = answer(start(package, "one", **{f"NUMBA_{name}": value for name, value in hostile.items()}))
    assert same["answers"] == first["answers"]
    assert set(same["compiled"].values()) == {0}


@pytest.mark.parametrize(
    ("variables", "root"),
    [
        ({"HOME": "/home/a"}, "/home/a/.cache/billow"),
        ({"HOME": "/home/a", "XDG_CACHE_HOME": "/cache"}, "/cache/billow"),
        ({"HOME": "/home/a", "XDG_CACHE_HOME": "cache"}, "/home/a/.cache/billow"),
        ({"HOME": "/home/a", "BILLOW_CACHE": "~/mine"}, "/home/a/mine"),
        ({"HOME": "~"}, None),
        ({"HOME": "~", "BILLOW_CACHE": "~/mine"}, None),
        ({"HOME": "~", "BILLOW_CACHE": "/mine"}, "/mine"),
    ],
)
def test_the_cache_is_never_a_folder_named_tilde(variables, root, monkeypatch):
    for name in ("HOME", "XDG_CACHE_HOME", "BILLOW_CACHE"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert cache_folder.cache_folder() == root


def test_kernels_are_compiled_in_every_process_without_a_file_or_a_folder_that_can_be_written(package):
    (package.parent / "file").touch()
    answers = answer(start(package, program=UNCACHED, BILLOW_CACHE=str(package.parent / "file")))
    assert answers == [[3.0, 6.0, [compiled.NOT_KEPT]]]
