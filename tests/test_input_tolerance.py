"""Every file a user gives is read with the same tolerance; what is no file is told at once."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest

from billow.apps.tank.tank_case import TankCase
from billow.apps.tank.trace import load_trace
from billow.base.errors import BillowError
from billow.case.schema import Case
from billow.geometry.mesh_file import read_mesh
from billow.parts.fabric.curve_file import read_curve_file
from billow.results.dataset_files import Parameter, read_dataset_file, read_design, read_split
from billow.results.histories import read_histories
from billow.results.run_file import read_run_file
from billow.results.vtkhdf import FabricFile
from billow.rom.surrogate.surrogate import Surrogate
from billow.study.definition import StudyDefinition
from billow.study.foreign_run import read_run, read_times, read_triangles
from billow.study.grow import read_added_designs
from billow.study.import_runs import import_runs

AXES = (Parameter("a", "A", "m", 0.0, 9.0), Parameter("b", "B", "-", 0.0, 9.0))


def frames(path: Path):
    folder = path.parent / "r0"
    folder.mkdir(exist_ok=True)
    for k in (11, 21, 31):
        (folder / f"f{k}.csv").write_bytes(path.read_bytes())
    return read_run(path.parent, "r0").positions


def runs(path: Path):
    for k in range(3):
        np.save(path.parent / f"r{k}.npy", np.arange(45.0).reshape(3, 5, 3) * 1e-3)
    (path.parent / "times.csv").write_text("time [s]\n0\n0.01\n0.02\n")
    (path.parent / "triangles.csv").write_text("a,b,c\n0,1,2\n")
    out = path.parent / f"out{len(list(path.parent.iterdir()))}"
    import_runs(path.parent, out)
    return read_design(out, AXES)


TRACE = "time [ms],pressure [kPa]\n" + "".join(f"{k / 2},{101.5 + k}\n" for k in range(30))
TABLES = {
    "trace": ("trace.csv", TRACE, lambda p: load_trace(p).pressure.tolist()),
    "curve": ("c.csv", "strain [%],stress [MPa]\n0,0\n1.5,2.5\n", lambda p: read_curve_file(p, "strain")),
    "added designs": ("a.csv", "a [m],b [-]\n1.5,2\n2.5,3\n", lambda p: read_added_designs(p, AXES)),
    "designs": ("design.csv", "run,a [m],b [-]\nr0,1.5,2\nr1,2.5,3\n", lambda p: read_design(p.parent, AXES)),
    "runs": ("runs.csv", "run,a [m],b [-]\nr0,1.5,2\nr1,2.5,3\nr2,3.5,1\n", runs),
    "triangles": ("triangles.csv", "a,b,c\n0,1,2\n0,2,3\n", lambda p: read_triangles(p.parent).tolist()),
    "times": ("times.csv", "note [-],time [s]\n0,0\n1,0.5\n", lambda p: read_times(p.parent).tolist()),
    "frames": ("f1.csv", "x [m],y [m],z [m]\n0.5,1,0\n1.5,0,0\n0,0,2\n", lambda p: frames(p).tolist()),
    "histories": ("h.csv", "time [s],p [Pa]\n0,1\n0.5,2.5\n", lambda p: [*map(list, read_histories(p).values())]),
}  # fmt: skip


def spreadsheet(text: str) -> bytes:
    return b"\xef\xbb\xbf" + text.replace(",", ";").replace(".", ",").replace("\n", "\r\n").encode()


WRITTEN = {
    "by a spreadsheet": spreadsheet,
    "in UTF-16": lambda text: text.encode("utf-16"),
    "with tabs": lambda text: text.replace(",", "\t").encode(),
    "with a comment in Latin-1": lambda text: "# Überdruck\n\n".encode("latin-1") + text.replace("\n", "\n\n").encode(),
    "with lone carriage returns": lambda text: text.replace("\n", "\r").encode(),
}


@pytest.mark.parametrize("how", WRITTEN)
@pytest.mark.parametrize("table", TABLES)
def test_every_table_is_read_however_it_was_written(tmp_path, table, how):
    name, text, read = TABLES[table]
    path = tmp_path / name
    path.write_text(text)
    plain = read(path)
    path.write_bytes(WRITTEN[how](text))
    assert read(path) == plain


EMPTY = {
    "nothing": (b"", "it is empty"),
    "blank lines": (b"\n \n\n", "it is empty"),
    "zeros": (b"a,b\n1,\0\0\n", "control character 0x00"),
    "binary": (b"\x89PNG\r\n\x1a\n\x81", "not a text file"),
}


@pytest.mark.parametrize("content", [*EMPTY, "header", "ragged", "word"])
@pytest.mark.parametrize("table", TABLES)
def test_every_table_that_is_none_is_told_with_file_and_line(tmp_path, table, content):
    name, text, read = TABLES[table]
    head, first, *_ = text.splitlines()
    contents = EMPTY | {
        "header": (head.encode(), "has no rows"),
        "ragged": (f"{text}{first},7\n".encode(), f"line {len(text.splitlines()) + 1} has"),
        "word": (f"{text[:-2]}much\n".encode(), "much', not a number"),
    }
    (tmp_path / name).write_bytes(contents[content][0])
    with pytest.raises((BillowError, ValueError)) as caught:
        read(tmp_path / name)
    assert contents[content][1] in str(caught.value)
    assert name[1:] in str(caught.value) or table in ("triangles", "times")  # whoever asks for these names them
    for word in ("codec", "unpack", "ordinal", "NoneType", "index", "argument", "0x7f"):
        assert word not in str(caught.value)


TOML = {
    "case": ("c.toml", 'title = "Größe"\n[bag]\ndiameter = 0.6\n', Case.load),
    "study": ("s.toml", 'title = "Größe"\ncase = "s.toml"\nseed = 1\ntrain = 2\ntest = 1\nreference_length = 0.3\n'
              '[[parameters]]\nname = "a"\nlabel = "A"\nunit = "m"\nlow = 1.0\nhigh = 2.0\nkeys = ["b"]\n',
              StudyDefinition.load),
    "tank": ("t.toml", 'title = "Größe"\n[tank]\nvolume = "60 l"\n[inflator.gas]\nN2 = 1.0\n', TankCase.load),
}  # fmt: skip


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("kind", TOML)
def test_every_toml_file_is_read_however_it_was_saved(tmp_path, kind, encoding, end):
    name, text, load = TOML[kind]
    (tmp_path / name).write_bytes(text.replace("\n", end).encode(encoding))
    assert load(tmp_path / name).title == "Größe"


PATHS = {
    "case": ("x.toml", Case.load),
    "study": ("x.toml", StudyDefinition.load),
    "tank": ("x.toml", TankCase.load),
    "trace": ("x.csv", load_trace),
    "curve": ("x.csv", lambda path: read_curve_file(path, "strain")),
    "mesh": ("x.vtk", read_mesh),
    "hdf mesh": ("x.vtkhdf", read_mesh),
    "added designs": ("x.csv", lambda path: read_added_designs(path, AXES)),
    "histories": ("x.csv", read_histories),
    "frames": ("x.vtkhdf", FabricFile),
    "surrogate": ("x.safetensors", Surrogate.load),
    "record": ("run.json", lambda path: read_run_file(path.parent)),
    "designs": ("design.csv", lambda path: read_design(path.parent, AXES)),
    "split": ("split.toml", lambda path: read_split(path.parent)),
    "dataset": ("dataset.toml", lambda path: read_dataset_file(path.parent)),
    "npz": ("r0.npz", lambda path: read_run(path.parent, "r0")),
    "npy": ("r0.npy", lambda path: read_run(path.parent, "r0")),
    "runs": ("runs.csv", lambda path: import_runs(path.parent, path.parent / "out")),
}


@pytest.mark.parametrize("kind", ["pipe", "endless", "full", "folder", "nothing", "loop"])
@pytest.mark.parametrize("reader", PATHS)
def test_what_is_no_file_is_told_at_once_wherever_a_path_is_read(tmp_path, reader, kind):
    name, read = PATHS[reader]
    path = tmp_path / name
    match kind:
        case "pipe":
            os.mkfifo(path)
        case "endless":
            path.symlink_to("/dev/zero")
        case "full":
            path.symlink_to("/dev/full")
        case "folder":
            path.mkdir()
        case "loop":
            path.symlink_to(path)
    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(10)
    try:
        with pytest.raises(BillowError):
            read(path)
    finally:
        signal.alarm(0)


def too_long(*_):
    raise TimeoutError("it waits for something that never comes")
