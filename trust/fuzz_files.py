"""Hostile files, folders, command lines and environments: each function feeds a number of them, like `fuzz_inputs`."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sys
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path
from random import Random
from unittest import mock

import numpy as np
import tomli_w

from billow.apps.coupon.comparison import given_curves, read_test_data
from billow.apps.tank.evaluate import measured, predict_case
from billow.apps.tank.tank_case import TankCase
from billow.base import surroundings
from billow.base.cache_folder import cache_folder
from billow.base.errors import BillowError
from billow.case.schema import Case
from billow.cli import main as command
from billow.cli import surroundings as command_surroundings
from billow.geometry.mesh_file import read_mesh
from billow.injury.criteria import assess_run
from billow.results.result import Result
from billow.rom.surrogate.surrogate import Surrogate
from billow.run.check import describe
from billow.study.grow import read_added_designs
from billow.study.import_runs import import_runs
from billow.study.study import Study
from trust.environments import HOSTILE, TANK
from trust.fuzz_inputs import Attempt, Bench
from trust.mutations import mutate_bytes, mutate_dictionary, mutate_text

NUMBERS = [
    "nan",
    "inf",
    "-1e300",
    "1e999",
    "3e38",
    "-0",
    "",
    "1,5",
    "0x10",
    "1_0",
    "٣",
    '"',
    "1 2",
    "1e-400",
    "9" * 400,
]
"""What a number of a table is replaced by."""

ENCODINGS = ["utf-8-sig", "utf-16", "utf-16-le", "utf-32", "latin-1", "cp1252", "utf-8"]
LINES = ["\n", "\r\n", "\r", "\n\n", "\n# comment\n", "\x0b", "\x00\n", " \n"]
SEPARATORS = [",", ";", "\t", " ", ",,", "|"]


def _damaged(content: bytes, random: Random) -> bytes:
    """A file that others wrote, or that was damaged on its way."""
    if random.random() < 0.4:
        return mutate_bytes(content, random)
    try:
        text = content.decode()
    except UnicodeDecodeError:
        return mutate_bytes(content, random)
    for _ in range(random.randint(1, 3)):
        match random.randrange(6):
            case 0:
                text = mutate_text(text, random)
            case 1:
                words = text.split(" ")
                words[random.randrange(len(words))] = random.choice(NUMBERS)
                text = " ".join(words)
            case 2:
                cells = text.split(",")
                cells[random.randrange(len(cells))] = random.choice(NUMBERS)
                text = ",".join(cells)
            case 3:
                lines = text.splitlines()
                if lines:
                    lines[random.randrange(len(lines))] = random.choice(["", ",", "x", "#", "1", *NUMBERS])
                text = random.choice(LINES).join(lines)
            case 4:
                text = text.replace(",", random.choice(SEPARATORS)).replace("\n", random.choice(LINES))
            case _:
                text = text.upper() if random.random() < 0.5 else "é∅" + text
    return text.encode(random.choice(ENCODINGS) if random.random() < 0.3 else "utf-8", "replace")


# --- meshes ---------------------------------------------------------------------------------------------------------


def meshes(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Meshes in each format, damaged; what is accepted is made a bag."""
    place = _folder(bench, "meshes")
    sound = bench.run / "fabric.vtkhdf"
    mesh = read_mesh(sound)
    kinds = {
        "bag.vtkhdf": sound.read_bytes(),
        "bag3.vtk": _legacy(mesh, 3, False),
        "bag5.vtk": _legacy(mesh, 5, False),
        "bag3b.vtk": _legacy(mesh, 3, True),
    }
    parts = [
        {"name": name, "number": int(number), **({"kind": name.split("_")[0]} if name[:4] in ("mout", "vent") else {})}
        for name, number in mesh.part_names.items()
    ]
    for _ in range(count):
        name = random.choice(list(kinds))
        path, data = place / name, _damaged(kinds[name], random)
        path.write_bytes(data)
        bag = {"shape": "mesh", "start": name, "parts": parts, "frame": random.choice([0, 0, -1, 1, 10**6])}
        (place / "case.toml").write_text(tomli_w.dumps({"bag": bag, "obstacles": []}))
        if attempt(lambda path=path, frame=bag["frame"]: read_mesh(path, frame=frame), (name, data), name):
            attempt(lambda: describe(Case.load(place / "case.toml")), (name, data))


def _legacy(mesh, version: int, binary: bool) -> bytes:
    """A VTK legacy file of triangles."""

    def block(array: np.ndarray) -> bytes:
        if binary:
            return array.astype(array.dtype.newbyteorder(">")).tobytes() + b"\n"
        return "\n".join(" ".join(map(str, row)) for row in np.atleast_2d(array).tolist()).encode() + b"\n"

    points, cells, part = mesh.points.astype("f8"), mesh.cells[:, :3].astype("i4"), mesh.part.astype("i4")
    count = len(cells)
    parts = [f"# vtk DataFile Version {version}.0\nbag\n{'BINARY' if binary else 'ASCII'}\n".encode()]
    parts += [f"DATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n".encode(), block(points)]
    if version == 5:
        parts += [f"CELLS {count + 1} {3 * count}\nOFFSETS vtktypeint64\n".encode()]
        parts += [block(np.arange(0, 3 * count + 1, 3, dtype="i8")), b"CONNECTIVITY vtktypeint64\n"]
        parts += [block(cells.astype("i8"))]
    else:
        parts += [f"CELLS {count} {4 * count}\n".encode(), block(np.insert(cells, 0, 3, axis=1))]
    parts += [f"CELL_TYPES {count}\n".encode(), block(np.full(count, 5, "i4")[:, None])]
    parts += [f"CELL_DATA {count}\nSCALARS part int 1\nLOOKUP_TABLE default\n".encode(), block(part[:, None])]
    return b"".join(parts)


# --- tables ---------------------------------------------------------------------------------------------------------


def tables(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Tables of every kind, as other programs write them."""
    place = _folder(bench, "tables")
    (place / "tank.toml").write_text(TANK + '[measurement]\npressure = "absolute"\n')
    tank = TankCase.load(place / "tank.toml")
    trace = "time [ms],pressure [kPa]\n" + "".join(f"{k},{101.3 + 2 * k - 0.02 * k * k}\n" for k in range(40))
    curve = "strain,stress [MPa]\n0,0\n0.05,10\n0.1,30\n0.2,90\n"
    shear = "angle [deg],stress [MPa]\n0,0\n10,0.1\n30,0.5\n"
    axes = bench.study.definition.axes
    designs = ",".join(f"{axis.name} [{axis.unit}]" for axis in axes)
    designs += "\n" + ",".join(str(0.5 * (axis.low + axis.high)) for axis in axes) + "\n"
    fabric = {"law": "curves", "library": "nylon66-470dtex", "curves": {"warp": {"loading": "curve.csv"}}}
    (place / "fabric.toml").write_text(tomli_w.dumps({"fabric": fabric}))

    def curves() -> None:
        given_curves("biaxial", Case.load(place / "fabric.toml").fabric, 0.1)

    kinds: dict[str, tuple[str, Callable[[Path], object]]] = {
        "trace.csv": (trace, lambda path: measured(tank, path)),
        "curve.csv": (curve, lambda path: curves()),
        "warp.csv": (curve, lambda path: read_test_data(path, "warp")),
        "shear.csv": (shear, lambda path: read_test_data(path, "shear")),
        "added.csv": (designs, lambda path: read_added_designs(path, axes)),
    }
    for _ in range(count):
        name = random.choice(list(kinds))
        text, use = kinds[name]
        path, data = place / name, _damaged(text.encode(), random)
        path.write_bytes(data)
        attempt(lambda use=use, path=path: use(path), (name, data), name)


def tank_cases(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    path, content = _folder(bench, "tank") / "tank.toml", tomllib.loads(TANK)
    content["forward"] = {"end_time": 0.02, "step": 0.001}
    for number in range(count):
        data = _damaged(tomli_w.dumps(content).encode(), random)
        if number % 2:
            with contextlib.suppress(TypeError, ValueError, RecursionError):
                data = tomli_w.dumps(mutate_dictionary(content, random)).encode()
        path.write_bytes(data)
        if attempt(lambda: TankCase.load(path), data, path.name):
            attempt(lambda: predict_case(TankCase.load(path)), data)


def imports(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Folders of runs of other programs, with one file damaged."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    moving = [points + np.array([0.0, 0.0, 0.1 * k]) for k in range(4)]
    triangles = "a,b,c\n0,1,2\n0,2,3\n"
    table = "run,flow [kg/s]\n" + "".join(f"r{k},{k}\n" for k in range(3))

    def numpy_file(write: Callable, *arrays, **named) -> bytes:
        stream = io.BytesIO()
        write(stream, *arrays, **named)
        return stream.getvalue()

    def csv(frame: np.ndarray) -> bytes:
        return ("x [m],y [m],z [m]\n" + "".join(",".join(map(str, p)) + "\n" for p in frame.tolist())).encode()

    def vtk(frame: np.ndarray) -> bytes:
        mesh = mock.Mock(points=frame, cells=np.array([[0, 1, 2, -1], [0, 2, 3, -1]]), part=np.zeros(2))
        return _legacy(mesh, 3, False)

    def run_of(kind: str, run: str, shift: float) -> dict[str, bytes]:
        frames = [frame * [1, 1, 1 + shift] for frame in moving]
        if kind == "npy":
            return {f"{run}.npy": numpy_file(np.save, np.array(frames))}
        if kind == "npz":
            return {f"{run}.npz": numpy_file(np.savez, points=np.array(frames), times=np.arange(4) * 0.01)}
        write = csv if kind == "csv" else vtk
        return {f"{run}/frame_{k}.{kind}": write(frame) for k, frame in enumerate(frames)}

    for _ in range(count):
        kind = random.choice(["npy", "npz", "csv", "vtk"])
        files = {"runs.csv": table.encode(), "times.csv": b"time [s]\n0\n0.01\n0.02\n0.03\n"}
        files["triangles.csv"] = triangles.encode()
        for k in range(3):
            files |= run_of(kind, f"r{k}", 0.1 * k)
        name = random.choice(list(files))
        files[name] = _damaged(files[name], random)
        folder = _folder(bench, "foreign")
        for path, data in files.items():
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_bytes(data)
        out = bench.place / "imported"
        if attempt(lambda folder=folder, out=out: import_runs(folder, out), (name, files[name])):
            shutil.rmtree(out)


# --- paths, command lines, environments -----------------------------------------------------------------------------


def paths(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Every reader of a path, and paths that are no file, never end, or have names that cannot be printed."""
    place = _folder(bench, "paths")
    odd = _odd_paths(place)
    sound = {
        ".toml": bench.place / "case.toml", ".csv": None, ".vtk": None, ".vtkhdf": bench.run / "fabric.vtkhdf",
        ".safetensors": bench.surrogate, "": bench.run,
    }  # fmt: skip
    (place / "tank.toml").write_text(TANK)
    tank = TankCase.load(place / "tank.toml")
    axes = bench.study.definition.axes

    def new_study(path: Path) -> Study:
        return Study.create(bench.place / "study.toml", path)

    readers: list[tuple[str, Callable[[Path], object]]] = [
        (".toml", Case.load), (".toml", TankCase.load), (".toml", lambda p: Study.create(p, place / "study")),
        (".vtk", read_mesh), (".vtkhdf", read_mesh), (".hdf", read_mesh),
        (".csv", lambda p: measured(tank, p)), (".csv", lambda p: read_test_data(p, "warp")),
        (".csv", lambda p: read_added_designs(p, axes)), (".safetensors", Surrogate.load),
        ("", Result.open), ("", lambda p: assess_run(Result.open(p))), ("", Study.open),
        ("", lambda p: import_runs(p, place / "imported")),
        (".toml", new_study),
    ]  # fmt: skip
    with contextlib.chdir(place):  # where paths that are not absolute lead
        for _ in range(count):
            suffix, read = random.choice(readers)
            path = Path(random.choice(odd))
            if random.random() < 0.6:
                named = place / f"{random.choice(NAMES)}{suffix}"
                with contextlib.suppress(OSError, ValueError):
                    target = random.choice([path, sound.get(suffix) or path, named])
                    os.symlink(target, named)
                path = named
            if read is new_study and "\0" in str(path):
                continue  # no command line can hold it
            attempt(lambda read=read, path=path: _with_reason(read, path), str(path))
            for left in ("study", "imported"):
                shutil.rmtree(place / left, ignore_errors=True)
            with contextlib.suppress(OSError, ValueError):
                if path.is_symlink() and path.parent == place and path.name not in ("loop",):
                    path.unlink()


def _with_reason(read: Callable[[Path], object], path: Path) -> None:
    """The operating system's own refusals are told by the command."""
    try:
        read(path)
    except (OSError, RecursionError) as error:
        raise command._unexpected(error) from error


NAMES = [
    "a",
    "a b",
    "-a",
    "a\nb",
    "\x1b[31mred",
    "ü∅",
    "\udcff\udcfe",
    "'\"",
    "$HOME",
    "~",
    "x" * 240,
    ".",
    "%s{0}",
    "a;b",
]
"""Names of files, without their suffix."""


def _odd_paths(place: Path) -> list[str]:
    (place / "folder").mkdir()
    (place / "empty").touch()
    os.mkfifo(place / "pipe")
    os.symlink(place / "loop", place / "loop")
    os.symlink("/dev/zero", place / "zero.toml")
    made = [str(place / name) for name in ("folder", "empty", "pipe", "loop", "zero.toml", "none", "empty/below")]
    fixed = ["", "/dev/zero", "/dev/full", "/dev/null", "/dev/stdin", "/proc/self/mem", "/proc/self/environ", "/", "."]
    return [*made, *fixed, "\0", "x" * 5000, "a/" * 2000, "~nobody", "\udcff", "a\nb", "-", "--help"]


def command_lines(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Commands with options and arguments of all kinds, without those that run for long."""
    place = _folder(bench, "commands")
    for name in ("case.toml", "study.toml", "surrogate.safetensors"):
        shutil.copy(bench.place / name, place / name)
    (place / "tank.toml").write_text(TANK)
    (place / "sound.csv").write_text("time [ms],pressure [kPa]\n0,101\n1,102\n2,103\n")
    words = ["check", "case.toml", "--set", "run.end_time=1e-4", "--out", "out", "--help", "--threads", "1", "--quiet"]
    words += [
        "run",
        "tank",
        "forward",
        "inverse",
        "tank.toml",
        "sound.csv",
        "--case",
        "predict",
        "surrogate.safetensors",
    ]
    words += [
        "couple",
        "injury",
        "resume",
        "export",
        "suggest",
        "import",
        "evaluate",
        "verify",
        "--count",
        "T1",
        "study",
    ]
    words += ["permeability=0.03", "temperature=600", "--extrapolate", "--example", "--json", "--version", "coupon"]
    words += [*NAMES, *_odd_paths(place), *NUMBERS, "--scheduler", "nonsense://x", "--law", "--peak", "--memory", "-h"]
    begun = [
        ["check", "case.toml"], ["check"], ["run", "case.toml", "--out"], ["tank", "forward", "tank.toml", "--out"],
        ["tank", "inverse", "sound.csv", "--case", "tank.toml", "--out"], ["predict", "surrogate.safetensors"],
        ["predict", "surrogate.safetensors", "--set"], ["injury"], ["resume"], ["import"], ["verify", "none"],
        ["coupon", "strip", "--out", "c", "--law"], ["evaluate"], ["suggest"], ["couple"], ["export"],
        ["check", "--set"],
        ["coupon", "strip", "--fabric"], ["study", "study.toml", "--scheduler", "x", "--out"], [],
    ]  # fmt: skip
    words = [word for word in words if "\0" not in word]  # no command line can hold it
    with contextlib.chdir(place):
        for warm in (
            "tank forward tank.toml --out warm",
            "run case.toml --out warmer",
            "predict surrogate.safetensors",
        ):
            with contextlib.suppress(BillowError):
                _run(warm.split())  # compiles, without a limit of time
        for _ in range(count):
            line = [*random.choice(begun), *random.choices(words, k=random.randint(0, 4))]
            if line[:1] == ["verify"] and not any(word in line for word in ("none", "--help")):
                continue
            attempt(lambda line=line: _run(line), line)
            for path in set(place.iterdir()):
                if path.name in ("out", "c", "out.partial") or (path.is_symlink() and not path.exists()):
                    shutil.rmtree(path, ignore_errors=True)


class CommandFailed(Exception):
    """A command ended in a way that is our mistake."""


def _run(line: list[str]) -> None:
    """A command, in this process, with a terminal of its own."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "ascii", "strict") for _ in range(2))
    code: object = 0
    with mock.patch.multiple(sys, argv=["billow", *line], stdout=out, stderr=err):
        try:
            command.main()
        except SystemExit as end:
            code = end.code
    said = err.detach().getvalue().decode() + out.detach().getvalue().decode()
    if code not in (0, 1, 2, 3, 4, 5, None) or "E-CLI-070" in said or "Traceback" in said:
        raise CommandFailed(f"exit {code}: {said[-2000:]}")
    if code:
        raise BillowError(
            "E-CLI-000", "a command was refused", where=" ".join(line)[:200] or "billow", why=said or "?", remedy="-"
        )


def environments(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """What the command does with its environment before it begins. `trust/environments.py` begins it, too."""
    names = sorted({name for kind in HOSTILE.values() for name in kind.variables})
    values = [*NUMBERS, *NAMES, "1", "0", "-1", "none", "/dev/null", "/nowhere", "x" * 4000, "~/a", "~nobody/a"]
    kept = dict(os.environ)

    def settle() -> None:
        with mock.patch.dict(os.environ):
            surroundings.own_compiler()
            command_surroundings.take_away(command_surroundings.FOREIGN)
            root = cache_folder()
            if root is not None and not os.path.isabs(root):
                raise AssertionError(f"a cache in {root!r}")
            tempfile._candidate_tempdir_list()

    for _ in range(count):
        chosen = {random.choice(names): random.choice(values) for _ in range(random.randint(1, 12))}
        with mock.patch.dict(os.environ, {name: value for name, value in chosen.items() if "\0" not in value}):
            attempt(settle, chosen)
    assert dict(os.environ) == kept


def _folder(bench: Bench, name: str) -> Path:
    place = bench.place / name
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    return place
