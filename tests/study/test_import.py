"""Runs made elsewhere become a dataset, in every format, or are refused with the reason."""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.results.dataset import Dataset
from billow.study.import_runs import import_runs
from billow.study.vtk_frames import read_vtk

START = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]])
TRIANGLES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
TIMES = np.array([0.0, 0.01, 0.02, 0.03])
TABLE = "run,rise [m],idle [-]\n" + "".join(f"r{n},{n}.5,{7 * n % 5}\n" for n in range(5))


def positions(number):
    return START + TIMES[:, None, None] * (number + 0.5) * np.array([0.0, 0.0, 1.0])


def legacy(points, binary=False, since_5=False):
    n, flat = len(TRIANGLES), TRIANGLES.ravel()
    head = f"# vtk DataFile Version {'5.1' if since_5 else '3.0'}\nbag\n{'BINARY' if binary else 'ASCII'}\n"
    parts = [(head + f"DATASET POLYDATA\nPOINTS {len(points)} double\n").encode()]

    def array(values, kind):
        parts.append(values.astype(">" + kind).tobytes() if binary else " ".join(map(repr, values.tolist())).encode())
        parts.append(b"\n")

    array(points.ravel(), "f8")
    if since_5:
        parts.append(f"POLYGONS {n + 1} {3 * n}\nOFFSETS vtktypeint64\n".encode())
        array(np.arange(0, 3 * n + 1, 3), "i8")
        parts.append(b"CONNECTIVITY vtktypeint64\n")
        array(flat, "i8")
    else:
        parts.append(f"POLYGONS {n} {4 * n}\n".encode())
        array(np.column_stack([np.full(n, 3), TRIANGLES]).ravel(), "i4")
    parts.append(b"POINT_DATA 5\nSCALARS p float\nLOOKUP_TABLE default\n")
    array(np.arange(5.0), "f4")
    return b"".join(parts)


def xml(points, kind="ascii", packed=False, raw=False):
    arrays = {
        "points": ("Float32", points.astype("<f4").ravel()),
        "connectivity": ("Int64", TRIANGLES.astype("<i8").ravel()),
        "offsets": ("Int64", np.arange(3, 13, 3, dtype="<i8")),
        "types": ("UInt8", np.full(4, 5, "<u1")),
    }
    appended, elements = b"", {}
    for name, (vtk_type, values) in arrays.items():
        data = values.tobytes()
        if packed:
            cut = len(data) // 2  # two blocks
            blocks = [zlib.compress(data[:cut]), zlib.compress(data[cut:])]
            head = struct.pack("<5I", 2, cut, len(data) - cut, *map(len, blocks))
            encoded, block = [base64.b64encode(head), base64.b64encode(b"".join(blocks))], head + b"".join(blocks)
        else:
            block = struct.pack("<I", len(data)) + data
            encoded = [base64.b64encode(block)]
        text, offset = "", ""
        if kind == "ascii":
            text = " ".join(map(repr, values.tolist()))
        elif kind == "binary":
            text = b"".join(encoded).decode()
        else:
            offset = f' offset="{len(appended)}"'
            appended += block if raw else b"".join(encoded)
        components = ' NumberOfComponents="3"' if name == "points" else ""
        elements[name] = (
            f'<DataArray type="{vtk_type}" Name="{name}"{components} format="{kind}"{offset}>{text}</DataArray>'
        )
    compressor = ' compressor="vtkZLibDataCompressor"' if packed else ""
    cells = "".join(elements[name] for name in ("connectivity", "offsets", "types"))
    body = (
        f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" byte_order="LittleEndian"{compressor}>'
        f'<UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="4"><Points>{elements["points"]}</Points>'
        f"<Cells>{cells}</Cells></Piece>"
        "</UnstructuredGrid>"
    ).encode()
    if kind == "appended":
        body += f'<AppendedData encoding="{"raw" if raw else "base64"}">_'.encode() + appended + b"</AppendedData>"
    return body + b"</VTKFile>"


VTK = {
    "ascii.vtk": lambda p: legacy(p),
    "binary.vtk": lambda p: legacy(p, binary=True),
    "ascii5.vtk": lambda p: legacy(p, since_5=True),
    "binary5.vtk": lambda p: legacy(p, binary=True, since_5=True),
    "ascii.vtu": lambda p: xml(p),
    "binary.vtu": lambda p: xml(p, "binary"),
    "packed.vtu": lambda p: xml(p, "binary", packed=True),
    "appended.vtu": lambda p: xml(p, "appended"),
    "appended_raw.vtu": lambda p: xml(p, "appended", raw=True),
    "appended_packed.vtu": lambda p: xml(p, "appended", packed=True),
    "appended_packed_raw.vtu": lambda p: xml(p, "appended", packed=True, raw=True),
}


@pytest.mark.parametrize("name", VTK)
def test_every_kind_of_vtk_file_gives_points_and_triangles(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(VTK[name](positions(2)[1]))
    points, triangles = read_vtk(path)
    np.testing.assert_allclose(points, positions(2)[1], rtol=1e-6)
    np.testing.assert_array_equal(triangles, TRIANGLES)


@pytest.mark.parametrize("name", VTK)
@pytest.mark.parametrize("part", [0.2, 0.5, 0.8])
def test_a_vtk_file_cut_short_is_refused(name, part, tmp_path):
    path, whole = tmp_path / name, VTK[name](positions(2)[1])
    path.write_bytes(whole[: int(part * len(whole))])
    try:
        points, _ = read_vtk(path)
    except ValueError:
        return
    assert len(points) == 5  # cut behind everything that is read


def test_quadrilaterals_are_cut_and_other_cells_refused(tmp_path):
    path = tmp_path / "q.vtk"
    head = "# vtk DataFile Version 3.0\nq\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n" + "0 0 0 " * 5 + "\n"
    path.write_text(head + "POLYGONS 2 9\n4 0 1 2 3\n3 1 2 4\n")
    np.testing.assert_array_equal(read_vtk(path)[1], [[0, 1, 2], [0, 2, 3], [1, 2, 4]])
    path.write_text(head + "POLYGONS 1 6\n5 0 1 2 3 4\n")
    with pytest.raises(ValueError, match="a polygon, neither a triangle nor a quad"):
        read_vtk(path)


def write_npz(folder, run, number):
    np.savez(folder / f"{run}.npz", positions=positions(number), contact_force=positions(number) - START)


def write_npy(folder, run, number):
    np.save(folder / f"{run}.npy", positions(number).astype(np.float32))


def write_csv(folder, run, number):
    (folder / run).mkdir()
    for frame, points in enumerate(positions(number)):
        rows = "".join(f"{k},{x!r},{y!r},{z!r}\n" for k, (x, y, z) in enumerate(points.tolist()))
        (folder / run / f"frame_{frame + 8}.csv").write_text("node,x [m],y [m],z [m]\n" + rows)


def write_vtk(folder, run, number):
    (folder / run).mkdir()
    for frame, points in enumerate(positions(number)):
        (folder / run / f"bag_{frame + 8}.vtu").write_bytes(xml(points, "binary", packed=True))


@pytest.fixture(params=[write_npz, write_npy, write_csv, write_vtk])
def foreign(request, tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "runs.csv").write_text(TABLE)
    (folder / "times.csv").write_text("time [s]\n" + "\n".join(map(str, TIMES)) + "\n")
    if request.param is not write_vtk:
        (folder / "triangles.csv").write_text("a,b,c\n" + "".join(f"{a},{b},{c}\n" for a, b, c in TRIANGLES))
    for number in range(5):
        request.param(folder, f"r{number}", number)
    return folder


def test_runs_made_elsewhere_become_a_dataset(foreign, tmp_path):
    assert import_runs(foreign, tmp_path / "study") == (4, 1)
    dataset = Dataset.open(tmp_path / "study")
    assert (len(dataset.train), len(dataset.test), dataset.missing) == (4, 1, {})
    assert dataset.trusted == dataset.train
    assert [(p.name, p.unit, p.low, p.high) for p in dataset.parameters] == [
        ("rise", "m", 0.5, 4.5), ("idle", "-", 0.0, 4.0),
    ]  # fmt: skip
    np.testing.assert_allclose(dataset.times, TIMES[1:])
    np.testing.assert_array_equal(dataset.triangles, TRIANGLES)
    for run in (*dataset.train, *dataset.test):
        number = int(run[1:])
        moved = dataset.snapshots("displacement", [run])[0]
        np.testing.assert_allclose(moved, (positions(number) - START)[1:], atol=1e-6)
        assert dataset.design([run]).tolist() == [[number + 0.5, 7 * number % 5]]
    assert dataset.reference_length == 1.0


def test_the_table_may_say_split_and_seconds(foreign, tmp_path):
    rows = [f"r{n},{n}.5,{7 * n % 5},{'test' if n in (1, 3) else 'train'},{n + 10}" for n in range(5)]
    (foreign / "runs.csv").write_text("run,rise [m],idle [-],split,wall_seconds [s]\n" + "\n".join(rows) + "\n")
    assert import_runs(foreign, tmp_path / "study", title="Madymo", reference_length=0.28) == (3, 2)
    dataset = Dataset.open(tmp_path / "study")
    assert (dataset.title, dataset.reference_length, dataset.test) == ("Madymo", 0.28, ("r1", "r3"))
    assert dataset.computing_seconds(["r2"]) == [12.0]
    with pytest.raises(InputError, match="E-RES-009"):
        import_runs(foreign, tmp_path / "study")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("rise [m]", "rise", "not of the form name"),
        ("run,", "name,", "the first must be run"),
        ("r1,", "r2,", "a name of its own"),
        ("r1,", "../r1,", "a name of its own"),
        ("r1,1.5", "r1,tall", "tall"),
        ("r1,1.5", "r1,inf", "not a finite number"),
        ("r1,1.5,2\n", "r1,1.5\n", "line 3 has 2 values, the header in line 1 names 3"),
        (TABLE[TABLE.index("r1") :], "r1,1.5,1\n", "at least three runs"),
    ],
)
def test_a_table_that_cannot_be_used_is_told(tmp_path, old, new, told):
    assert old in TABLE
    (tmp_path / "runs.csv").write_text(TABLE.replace(old, new))
    with pytest.raises(InputError, match="E-STU-026") as caught:
        import_runs(tmp_path, tmp_path / "study")
    assert told in caught.value.why


def change(change_array):
    def apply(folder):
        np.save(folder / "r3.npy", change_array(positions(3)))

    return apply


def without(name):
    return lambda folder: (folder / name).unlink()


def rewrite(name, text):
    return lambda folder: (folder / name).write_text(text)


@pytest.mark.parametrize(
    ("spoil", "code", "told"),
    [
        (change(lambda p: p[:, :4]), "E-STU-028", "4 nodes, run r0 has 5"),
        (change(lambda p: p[:3]), "E-STU-028", "3 frames for 4 times"),
        (change(lambda p: p + 1e-3), "E-STU-028", "start shape differs"),
        (change(lambda p: np.where(p > 1.05, np.nan, p) * np.array([1, 1, np.nan])), "E-STU-027", "not all finite"),
        (change(lambda p: p[..., :2]), "E-STU-027", "expected (times, nodes, 3)"),
        (change(lambda p: p.astype(object)), "E-STU-027", "holds no numbers"),
        (without("r2.npy"), "E-STU-027", "neither r2.npz nor r2.npy nor a folder r2"),
        (without("times.csv"), "E-STU-029", "times"),
        (without("triangles.csv"), "E-STU-029", "triangles"),
        (rewrite("times.csv", "time [s]\n0\n2\n1\n3\n"), "E-STU-029", "rise"),
        (rewrite("times.csv", "time [s]\n1\n2\n3\n4\n"), "E-STU-029", "the first time is 1 s; it must be 0"),
        (rewrite("times.csv", "t\n1\n"), "E-STU-029", "time [s] missing"),
        (rewrite("triangles.csv", "a,b,c\n0,1,5\n"), "E-STU-029", "not among 0 to 4"),
    ],
)
def test_what_does_not_fit_is_told_and_nothing_written(tmp_path, spoil, code, told):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "runs.csv").write_text(TABLE)
    (folder / "times.csv").write_text("time [s]\n" + "\n".join(map(str, TIMES)) + "\n")
    (folder / "triangles.csv").write_text("a,b,c\n" + "".join(f"{a},{b},{c}\n" for a, b, c in TRIANGLES))
    for number in range(5):
        write_npy(folder, f"r{number}", number)
    spoil(folder)
    with pytest.raises(InputError, match=code) as caught:
        import_runs(folder, tmp_path / "study")
    assert told in caught.value.why
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elsewhere"]
