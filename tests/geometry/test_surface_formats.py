"""STL, OBJ, PLY, VTU and VTP of one cube are the same mesh, text or binary; what is damaged is refused."""

from __future__ import annotations

import base64
import struct

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.geometry.mesh_file import read_mesh

POINTS = np.array([[x, y, z] for z in (0, 300) for y in (0, 300) for x in (0, 300)], float)
QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]])
TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
PART = np.repeat([0, 1], 6)


def stl() -> bytes:
    text = ""
    for name in ("low half", "high"):
        text += f"solid {name}\n"
        for t in TRIANGLES[(name == "high") == PART]:
            text += "facet normal 0 0 0\nouter loop\n"
            text += "".join(f"vertex {x} {y} {z}\n" for x, y, z in POINTS[t]) + "endloop\nendfacet\n"
        text += f"endsolid {name}\n"
    return text.encode()


def stl_binary() -> bytes:
    rows = [struct.pack("<12fH", 0, 0, 0, *POINTS[t].ravel(), 0) for t in TRIANGLES]
    return b"solid as some programs begin".ljust(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def obj() -> bytes:
    text = "# a cube\n" + "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS) + "vn 0 0 1\n"
    for number, name in enumerate(("low half", "high")):
        text += f"g {name}\n" + "".join(f"f {a + 1}//1 {b + 1}//1 {c - 8}\n" for a, b, c in TRIANGLES[number == PART])
    return text.encode()


def ply(form: str) -> bytes:
    head = f"ply\nformat {form} 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float y\n"
    head += (
        "property float z\nproperty uchar red\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if form == "ascii":
        body = "".join(f"{x} {y} {z} 255\n" for x, y, z in POINTS)
        return (head + body + "".join(f"3 {a} {b} {c}\n" for a, b, c in TRIANGLES)).encode()
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(order + "3fB", *p, 255) for p in POINTS)
    return head.encode() + body + b"".join(struct.pack(order + "B3i", 3, *t) for t in TRIANGLES)


def xml(kind: str, form: str) -> bytes:
    def array(name: str, values: np.ndarray, dtype: str, components: int = 1) -> str:
        flat = values.ravel()
        if form == "ascii":
            body = " ".join(map(str, flat.tolist()))
        else:
            data = flat.astype({"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[dtype]).tobytes()
            body = base64.b64encode(struct.pack("<I", len(data)) + data).decode()
        head = f'<DataArray Name="{name}" type="{dtype}" format="{form}" NumberOfComponents="{components}">'
        return f"{head}{body}</DataArray>"

    cells = array("connectivity", TRIANGLES, "Int64") + array("offsets", 3 * np.arange(1, 13), "Int64")
    counts = f'NumberOfPoints="8" NumberOf{"Cells" if kind == "UnstructuredGrid" else "Polys"}="12"'
    tag = "Cells" if kind == "UnstructuredGrid" else "Polys"
    if tag == "Cells":
        cells += array("types", np.full(12, 5), "UInt8")
    return (
        f'<VTKFile type="{kind}" byte_order="LittleEndian"><{kind}><Piece {counts}><Points>'
        f"{array('Points', POINTS, 'Float64', 3)}</Points><{tag}>{cells}</{tag}>"
        f"<CellData>{array('part', PART, 'Int64')}</CellData></Piece></{kind}></VTKFile>"
    ).encode()


FILES = {
    "a.stl": (stl, ["low half", "high"]),
    "b.stl": (stl_binary, []),
    "a.obj": (obj, ["low half", "high"]),
    "a.ply": (lambda: ply("ascii"), []),
    "b.ply": (lambda: ply("binary_little_endian"), []),
    "c.ply": (lambda: ply("binary_big_endian"), []),
    "a.vtu": (lambda: xml("UnstructuredGrid", "ascii"), None),
    "b.vtp": (lambda: xml("PolyData", "binary"), None),
}


@pytest.mark.parametrize("name", FILES)
def test_a_cube_is_a_cube_in_every_format(tmp_path, name):
    make, parts = FILES[name]
    (tmp_path / name).write_bytes(make())
    mesh = read_mesh(tmp_path / name)
    assert mesh.points.shape == (8, 3)
    assert np.array_equal(mesh.points[mesh.cells[:, :3]], POINTS[TRIANGLES])
    assert (mesh.cells[:, 3] == -1).all()
    if parts != []:
        assert np.array_equal(mesh.part, PART)
    if parts:
        assert mesh.part_names == {part: k for k, part in enumerate(parts)}


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("a.stl", b"vertex 0.0 300.0 0.0", b"vertex 0.0 3oo 0.0", "line "),
        ("a.stl", b"endloop\nendfacet\nfacet", b"vertex 1 1 1\nendloop\nendfacet\nfacet", "three corners"),
        ("a.stl", b"outer loop", b"inner loop", "'inner'"),
        ("b.stl", b"solid", b"SOLIP", ""),
        ("a.obj", b"f 1//1", b"f 0//1", "vertex"),
        ("a.obj", b"g high", b"l 1 2", "'l'"),
        ("a.obj", b"v 0.0 0.0 0.0\n", b"v 0.0 0.0\n", "line 2"),
        ("a.ply", b"element face 12", b"element face 13", "cut short"),
        ("b.ply", b"element face 12", b"element face 1200000", "more elements"),
        ("b.ply", b"property float z", b"property half z", "header"),
        ("a.ply", b"format ascii", b"format ebcdic", "format"),
    ],
)
def test_what_is_damaged_is_refused(tmp_path, name, old, new, words):
    data = FILES[name][0]()
    assert old in data
    data = data.replace(old, new, 1)
    (tmp_path / name).write_bytes(data if words else data[:-7])
    with pytest.raises(InputError, match=r"E-GEO-03[01]") as error:
        read_mesh(tmp_path / name)
    assert words in error.value.why


@pytest.mark.parametrize("name", FILES)
def test_a_mesh_becomes_a_bag_with_what_it_lacks_from_a_case(tmp_path, name):
    (tmp_path / name).write_bytes(FILES[name][0]())
    (tmp_path / "base.toml").write_text("[fabric]\nthickness = 4e-4\n[inflator.jets]\ncount = 0\n")
    parts = {1: "fabric"} if FILES[name][1] == [] else {1: "fabric", 2: "vent"}
    options = Options(base=tmp_path / "base.toml", parts=parts, units="kg-mm-ms")
    import_deck(tmp_path / name, tmp_path / "case", options)
    case = Case.load(tmp_path / "case" / "case.toml")
    assert [part.kind for part in case.bag.parts] == list(parts.values())
    assert case.fabric.thickness == 4e-4
    assert np.ptp(read_mesh(case.bag.start).points, axis=0) == pytest.approx([0.3] * 3)
    with pytest.raises(InputError, match="E-DCK-009"):
        import_deck(tmp_path / name, tmp_path / "other", Options(base=tmp_path / "base.toml", parts=parts))
