"""Frames of other solvers are put in the order of their times, or refused; nothing about them is guessed."""

from __future__ import annotations

import itertools
import os
import zipfile
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.results.dataset import Dataset
from billow.study.foreign_run import read_run
from billow.study.frame_order import frame_order
from billow.study.import_runs import import_runs
from billow.study.numpy_arrays import read_npy, read_npz
from billow.study.vtk_frames import read_vtk

START = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
TIMES = np.array([0.0, 0.005, 0.01, 0.015, 0.02])

NAMES = {
    "times": [f"bag_t{t}" for t in TIMES],
    "short times": [f"bag_{t:g}" for t in TIMES],
    "milliseconds": [f"bag_{1e3 * t:g}ms" for t in TIMES],
    "powers of ten": [f"bag_{t:.1e}" for t in TIMES],
    "p for point": [f"bag_{t}".replace(".", "p") for t in TIMES],
    "decimal comma": [f"bag {t}".replace(".", ",") for t in TIMES],
    "counts": [f"frame_{k}" for k in range(8, 13)],
    "filled counts": [f"frame.{k:04d}" for k in range(8, 13)],
    "run and count": [f"r3_{k}" for k in range(8, 13)],
    "count and time": [f"frame_{k}_t{t}" for k, t in enumerate(TIMES)],
}


@pytest.mark.parametrize("names", NAMES.values(), ids=NAMES)
def test_frames_are_in_the_order_of_their_times(names):
    for mixed in (sorted(names), names[::-1]):
        assert [mixed[k] for k in frame_order(mixed, TIMES)] == names


@given(st.permutations(range(5)), st.sampled_from(sorted(NAMES)))
def test_the_order_does_not_depend_on_that_of_the_folder(shuffled, kind):
    names = [NAMES[kind][k] for k in shuffled]
    assert [names[k] for k in frame_order(names, TIMES)] == NAMES[kind]


@pytest.mark.parametrize(
    ("names", "times"),
    [
        (["1.8", "1.9", "1.10", "1.11", "1.12"], TIMES),
        (["0p1", "0p15", "0p2"], None),
        (["bag_0.1", "bag_0.15", "bag_0.2"], None),
        (["a1", "a01", "a2"], TIMES),
        (["start", "f1", "f2"], TIMES),
        (["bag", "bag", "bag"], TIMES),
        (["f1", "f2", "g3"], TIMES),
    ],
)
def test_an_order_that_is_in_doubt_is_refused(names, times):
    with pytest.raises(ValueError, match=r"in doubt.*number them 1, 2, 3"):
        frame_order(names, times)


def folder_of(tmp_path, write, runs=4, times=TIMES):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "runs.csv").write_text("run,flow [kg/s]\n" + "".join(f"r{n},{n + 1}\n" for n in range(runs)))
    (folder / "times.csv").write_text("time [s]\n" + "".join(f"{t}\n" for t in times))
    (folder / "triangles.csv").write_text("a,b,c\n" + "".join(f"{a},{b},{c}\n" for a, b, c in TRIANGLES))
    for n in range(runs):
        write(folder, f"r{n}", START + np.arange(len(times))[:, None, None] * (n + 1) * np.array([0, 0, 0.01]))
    return folder


def csv_frames(names, head="x [m],y [m],z [m]", row="{1!r},{2!r},{3!r}", end="\n"):
    def write(folder, run, positions):
        (folder / run).mkdir()
        for name, points in zip(names, positions, strict=True):
            rows = [row.format(k, *point) for k, point in enumerate(points.tolist())]
            (folder / run / f"{name}.csv").write_bytes((end.join([head, *rows]) + end).encode())

    return write


def npz(**given):
    def write(folder, run, positions):
        np.savez(folder / f"{run}.npz", **{"positions": positions, **given})

    return write


def test_frames_named_by_decimal_times_are_imported_in_order(tmp_path):
    folder = folder_of(tmp_path, csv_frames(NAMES["times"]))
    import_runs(folder, tmp_path / "study")
    dataset = Dataset.open(tmp_path / "study")
    height = dataset.snapshots("displacement", ["r0"])[0][:, 0, 2]
    np.testing.assert_allclose(height, [0.01, 0.02, 0.03, 0.04], rtol=1e-6)


def test_frames_of_a_spreadsheet_are_the_same_frames(tmp_path):
    plain = folder_of(tmp_path, csv_frames(NAMES["counts"]))
    (tmp_path / "other").mkdir()
    row = "{0};{1!r};{2!r};{3!r}"
    sheet = folder_of(tmp_path / "other", csv_frames(NAMES["counts"], "node;x [m];y [m];z [m]", row, "\r\n"))
    for path in sheet.glob("r*/*.csv"):
        path.write_bytes(b"\xef\xbb\xbf# exported\r\n" + path.read_bytes().replace(b".", b","))
    np.testing.assert_array_equal(read_run(plain, "r1").positions, read_run(sheet, "r1").positions)


@pytest.mark.parametrize(
    ("write", "code", "told"),
    [
        (csv_frames(NAMES["counts"], "node,x [m],y [m],z [m]", "{0}1,{1},{2},{3}"), "E-STU-027", "node 1, not 0"),
        (csv_frames(["start", *NAMES["counts"][1:]]), "E-STU-027", "in doubt"),
        (csv_frames(NAMES["counts"], "x,y,z"), "E-STU-027", "x [m], y [m], z [m] missing"),
        (npz(times=[0, 0.005, 0.01, 0.015, np.inf]), "E-STU-029", "finite"),
        (npz(times=[0, 0.005, 0.005, 0.015, 0.02]), "E-STU-029", "0.005 s follows 0.005 s"),
        (npz(times=[0, 5, 10, 15, 20]), "E-UNIT-001", "it looks like 20 ms"),
        (npz(triangles=TRIANGLES + 0.5), "E-STU-027", "node 0.5 is not a whole number"),
        (npz(triangles=TRIANGLES + 1), "E-STU-029", "counted from 0, not from 1"),
        (npz(triangles=np.array([[0, 1, 1], [0, 2, 3]])), "E-STU-029", "triangle 0, counted from 0, has the same"),
        (lambda f, r, p: npz()(f, r, p - START), "E-STU-027", "these are displacements"),
        (lambda f, r, p: npz()(f, r, 1e3 * p), "E-UNIT-001", "it looks like 1000 mm"),
        (lambda f, r, p: (npz()(f, r, p), np.save(f / f"{r}.npy", p)), "E-STU-027", "both there"),
        (lambda f, r, p: os.mkfifo(f / f"{r}.npz"), "E-STU-027", "a pipe, not a file"),
        (lambda f, r, p: (f / f"{r}.npz").symlink_to("/dev/zero"), "E-STU-027", "a device, not a file"),
    ],
)
def test_what_cannot_be_read_in_one_way_is_refused(tmp_path, write, code, told):
    folder = folder_of(tmp_path, write)
    with pytest.raises(InputError, match=code) as caught:
        import_runs(folder, tmp_path / "study")
    assert told in str(caught.value)
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, 1e4])
def test_a_reference_length_that_cannot_be_is_refused(tmp_path, length):
    with pytest.raises(InputError, match="E-UNIT-001"):
        import_runs(folder_of(tmp_path, npz()), tmp_path / "study", reference_length=length)


def test_numpy_files_hold_numbers_and_no_more_than_they_say(tmp_path):
    path, values = tmp_path / "a.npy", np.asfortranarray(np.arange(12.0).reshape(3, 4))
    np.save(path, values)
    np.testing.assert_array_equal(read_npy(path), values)
    whole = path.read_bytes()
    for spoilt, told in (
        (whole[:-1], "cut short"),
        (whole + b"0", "longer"),
        (whole.replace(b"(3, 4)", b"(9**9,"), "does not begin like an array"),
        (whole.replace(b"'<f8'", b"'|O8'"), "does not begin|no numbers"),
        (whole.replace(b"(3, 4)", b"(3,-4)"), "does not begin|no numbers"),
        (whole.replace(b"(3, 4), }  ", b"(9999999, 4), }"), "cut short"),
        (b"", "does not begin"),
    ):
        path.write_bytes(spoilt)
        with pytest.raises(ValueError, match=told):
            read_npy(path)


def test_an_archive_that_unpacks_to_gigabytes_is_refused(tmp_path):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("positions.npy", "w") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (300_000_000,)})
        for _ in itertools.repeat(None, 3):
            file.write(bytes(1_000_000))
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo("positions.npy").file_size
    path.write_bytes(path.read_bytes().replace(size.to_bytes(4, "little"), (2_400_000_128).to_bytes(4, "little")))
    assert path.stat().st_size < 100_000
    with pytest.raises(ValueError, match="unpacked it has 2400000128 bytes"):
        read_npz(path)


def test_a_packed_array_that_unpacks_to_more_than_it_says_is_refused(tmp_path):
    packed = zlib.compress(bytes(50_000_000))
    for size, told in ((1000, "unpacks to more than it announces"), (2**31, "arrays of more than")):
        head = np.array([1, size, 0, len(packed)], "<u4").tobytes()
        path = tmp_path / "bomb.vtu"
        path.write_bytes(
            b'<VTKFile byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece><Points>'
            b'<DataArray type="Float32" format="appended" offset="0"/></Points><Cells/></Piece></UnstructuredGrid>'
            b'<AppendedData encoding="raw">_' + head + packed + b"</AppendedData></VTKFile>"
        )
        with pytest.raises(ValueError, match=told):
            read_vtk(path)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e200])
def test_a_frame_that_cannot_be_stored_is_named(tmp_path, value):
    positions = np.random.default_rng(0).normal(size=(4, 5, 3))
    positions[2, 3, 1] = value
    np.save(tmp_path / "r0.npy", positions)
    with pytest.raises(InputError, match="positions of frame 2 are not all finite, or beyond"):
        read_run(tmp_path, "r0")
