"""Bags read from mesh files: the same bag from every format, flat pieces, chambers, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mesh_files import pillow, write_vtk, write_vtkhdf

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model, flat_area
from billow.case.schema import Case
from billow.geometry.flat_cut import flat_cut
from billow.geometry.mesh_file import read_mesh
from billow.geometry.surface import check_closed
from billow.geometry.triangulation import diagonals, split
from billow.results.vtkhdf import FabricWriter
from billow.solver.model import start_state
from billow.solver.step import advance

PARTS = [{"name": "front", "number": 1}, {"name": "rear", "number": 2}]


@pytest.fixture
def files(tmp_path):
    points, cells, part, flat_points, flat_cells = pillow()
    return {
        "start": str(write_vtk(tmp_path / "start.vtk", points, cells, part)),
        "reference": str(write_vtk(tmp_path / "flat.vtk", flat_points, flat_cells, part)),
    }


def case(files, parts=PARTS, **bag):
    table = {"shape": "mesh", **files, "parts": parts, **bag}
    return Case.from_dict({"bag": table, "gas": {"model": "none"}, "obstacles": []})


def refusal(files, **bag):
    with pytest.raises(InputError) as caught:
        build_shape(case(files, **bag).bag)
    return caught.value


# --- files -----------------------------------------------------------------------------------------------------------


def test_every_format_holds_the_same_mesh(tmp_path):
    points, cells, part, *_ = pillow()
    cells = [cells[0][:3], [cells[0][0], *cells[0][2:]], *cells[1:]]  # triangles among the quads
    part = [1, *part]
    read = [
        read_mesh(write_vtk(tmp_path / "3.vtk", points, cells, part)),
        read_mesh(write_vtk(tmp_path / "5.vtk", points, cells, part, version=5)),
        read_mesh(write_vtkhdf(tmp_path / "m.vtkhdf", points, cells, part)),
    ]
    for mesh in read:
        np.testing.assert_array_equal(mesh.points, points)
        assert [c[c >= 0].tolist() for c in mesh.cells] == cells
        assert mesh.part.tolist() == part


def test_a_run_is_a_mesh(tmp_path):
    """A frame of a run starts another: part names come with it."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    with FabricWriter(tmp_path / "fabric.vtkhdf", points, triangles, np.array([0, 0, 1, 1]), ["front", "rear"]) as run:
        run.append(0.0, points)
        run.append(0.1, 2.0 * points)
    assert read_mesh(tmp_path / "fabric.vtkhdf").part_names == {"front": 0, "rear": 1}
    for frame, scale in ((0, 1.0), (1, 2.0), (-1, 2.0)):
        np.testing.assert_array_equal(read_mesh(tmp_path / "fabric.vtkhdf", frame=frame).points, scale * points)
    with pytest.raises(InputError, match="E-GEO-030"):
        read_mesh(tmp_path / "fabric.vtkhdf", frame=2)
    parts = [{"name": "rear"}, {"name": "front"}]
    shape = build_shape(case({"start": str(tmp_path / "fabric.vtkhdf")}, parts).bag)
    assert shape.surface.triangles_of("front").tolist() == [0, 1]


def test_a_binary_file_whose_points_have_fields_too(files, tmp_path):
    text = read_mesh(files["start"])
    nodes, cells = len(text.points), len(text.cells)
    arrays = [
        (f"POINTS {nodes} double", text.points, ">f8"),
        (f"CELLS {cells} {5 * cells}", np.insert(text.cells, 0, 4, axis=1), ">i4"),
        (f"CELL_TYPES {cells}", np.full(cells, 9), ">i4"),
        (f"CELL_DATA {cells}\nFIELD FieldData 2\nother 2 {cells} float", np.full((cells, 2), 7.0), ">f4"),
        (f"part 1 {cells} int", text.part, ">i4"),
        (f"POINT_DATA {nodes}\nVECTORS velocity float", text.points, ">f4"),
        ("SCALARS part int 1\nLOOKUP_TABLE default", np.full(nodes, 7), ">i4"),
    ]
    path = tmp_path / "binary.vtk"
    head = b"# vtk DataFile Version 3.0\na bag\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
    path.write_bytes(head + b"".join(f"{h}\n".encode() + a.astype(kind).tobytes() + b"\n" for h, a, kind in arrays))
    binary = read_mesh(path)
    for name in ("points", "cells", "part"):
        np.testing.assert_array_equal(getattr(binary, name), getattr(text, name))


def test_a_file_that_names_more_cells_than_it_lists_ends_at_once(files):
    start = Path(files["start"])
    start.write_text(start.read_text().replace("CELLS 72 360\n4 0", "CELLS 999999999999 360\n-1 0"))
    assert refusal(files).code == "E-GEO-030"


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda text: text[: len(text) // 2], "E-GEO-030"),
        (lambda text: text.replace("ASCII", "BINARY"), "E-GEO-030"),
        (lambda text: text.replace("POINTS 74", "POINTS 999999999999"), "E-GEO-030"),
        (lambda text: text.replace("POINTS 74", "POINTS -1"), "E-GEO-030"),
        (lambda text: text.replace("UNSTRUCTURED_GRID", "STRUCTURED_GRID"), "E-GEO-030"),
        (lambda text: text.replace("\n4 0 7", "\n4 0 7777"), "E-GEO-031"),
        (lambda text: text.replace("CELL_TYPES 72\n9", "CELL_TYPES 72\n3"), "E-GEO-031"),
        (lambda text: text.replace("double\n-0.15", "double\nnan"), "E-GEO-031"),
        (lambda text: text.replace("LOOKUP_TABLE default\n1", "LOOKUP_TABLE default\n1.5"), "E-GEO-031"),
    ],
)
def test_a_damaged_file_is_refused(files, spoil, code):
    start = Path(files["start"])
    assert spoil(start.read_text()) != start.read_text()
    start.write_text(spoil(start.read_text()))
    assert refusal(files).code == code


@pytest.mark.parametrize("name", ["none.vtk", "folder.vtk", "mesh.stl", "none.vtkhdf", "nul\0byte.vtk"])
def test_a_file_that_is_no_mesh(tmp_path, name):
    (tmp_path / "folder.vtk").mkdir()
    with pytest.raises(InputError, match="E-GEO-030"):
        read_mesh(f"{tmp_path}/{name}")


# --- the bag ---------------------------------------------------------------------------------------------------------


def test_a_pillow_of_two_flat_pieces(files):
    shape = build_shape(case(files).bag)
    check_closed(shape.surface, shape.positions, "bag")
    assert flat_area(shape.reference).sum() == pytest.approx(2.0 * 0.3**2, rel=1e-12)
    model = build_model(case(files))
    assert model.mass.sum() == pytest.approx(2.0 * 0.3**2 * 800.0 * 3e-4, rel=1e-12)


def test_warp_layers_coating_and_fixed_parts(files):
    parts = [
        {"name": "front", "number": 1, "warp_angle": 90.0, "layers": 2.0},
        {**PARTS[1], "coated": True, "fixed": True},
    ]
    plain, shape = build_shape(case(files).bag), build_shape(case(files, parts, fixed_nodes=[24]).bag)
    front, rear = (shape.surface.triangles_of(p) for p in ("front", "rear"))
    np.testing.assert_allclose(shape.reference[front][..., 0], plain.reference[front][..., 1], atol=1e-15)
    assert (shape.layers[front] == 2.0).all()
    assert (shape.layers[rear] == 1.0).all()
    assert not shape.leak[rear].any()
    assert shape.fixed[shape.surface.triangles[rear]].all()
    assert shape.fixed[24]
    assert not shape.fixed[16]


def test_the_start_is_its_own_reference(files):
    shape = build_shape(case({"start": files["start"]}).bag)
    corners = shape.positions[shape.surface.triangles]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        np.testing.assert_allclose(
            np.linalg.norm(corners[:, a] - corners[:, b], axis=1),
            np.linalg.norm(shape.reference[:, a] - shape.reference[:, b], axis=1),
            rtol=1e-12,
        )


def test_units_and_paths_are_those_of_the_case_file(tmp_path):
    points, cells, part, flat_points, flat_cells = pillow()
    write_vtk(tmp_path / "start.vtk", 1e3 * points, cells, part)
    write_vtk(tmp_path / "flat.vtk", 1e3 * flat_points, flat_cells, part)
    text = 'bag = {shape="mesh", start="start.vtk", reference="flat.vtk", unit="mm", parts=[{name="front", number=1}, '
    (tmp_path / "case.toml").write_text(text + '{name="rear", number=2}]}\n')
    case = Case.load(tmp_path / "case.toml")
    assert flat_area(build_shape(case.bag).reference).sum() == pytest.approx(2.0 * 0.3**2, rel=1e-12)
    assert Case.from_dict(case.to_dict()) == case
    write_vtk(tmp_path / "flat.vtk", 1.1e3 * flat_points, flat_cells, part)
    with pytest.raises(InputError, match="E-GEO-035"):
        build_shape(case.bag)
    assert Case.load(tmp_path / "case.toml").digest() != case.digest()


def test_two_chambers_with_a_wall_between_them(tmp_path):
    """A cube of two halves and the wall that parts them; without the wall each half is open."""
    x = np.repeat([-1.0, 0.0, 1.0], 4)
    points = 0.1 * np.column_stack([x, np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (3, 1))])
    sides = [[f + k, f + (k + 1) % 4, f + 4 + (k + 1) % 4, f + 4 + k] for f in (0, 4) for k in range(4)]
    cells = [*sides, [3, 2, 1, 0], [8, 9, 10, 11], [4, 5, 6, 7]]
    start = str(write_vtk(tmp_path / "cube.vtk", points, cells, [1] * 4 + [2] * 4 + [1, 2, 3]))
    parts = [
        {"name": "low", "number": 1, "behind": "left"},
        {"name": "high", "number": 2, "behind": "right"},
        {"name": "wall", "number": 3, "behind": "left", "ahead": "right"},
    ]
    shape = build_shape(case({"start": start}, parts).bag)
    check_closed(shape.surface, shape.positions, "bag")
    volumes = shape.surface.chambers.volumes(shape.surface.triangles, shape.positions)
    assert volumes == pytest.approx([1e-3, 1e-3], rel=1e-12)
    assert shape.surface.chambers.names == ("left", "right")
    parts[2]["ahead"] = "ambient"
    shape = build_shape(case({"start": start}, parts).bag)
    with pytest.raises(InputError, match="E-GEO-001") as caught:
        check_closed(shape.surface, shape.positions, "bag")
    assert "chamber right" in caught.value.where
    assert "4 free edges" in caught.value.what


@pytest.mark.parametrize(
    ("bag", "code", "words"),
    [
        ({"parts": PARTS[:1]}, "E-GEO-032", "part 2"),
        ({"parts": [*PARTS, {"name": "vent", "number": 3}]}, "E-GEO-032", "no part 3"),
        ({"parts": [PARTS[0], {"name": "rear"}]}, "E-GEO-032", "'rear'"),
        ({"parts": [*PARTS, {"name": "again", "number": 2}]}, "E-GEO-032", "same part"),
        ({"fixed_nodes": [74]}, "E-GEO-034", "node 74"),
        ({"straps": [{"nodes": [[0, -1]]}]}, "E-GEO-034", "node -1"),
        ({"digest": "0" * 64}, "E-GEO-035", "not those"),
        ({"parts": [{**PARTS[0], "seen_from": "inside", "warp_angle": 45.0}, PARTS[1]]}, "E-GEO-037", "front"),
    ],
)
def test_what_does_not_fit_is_refused(files, bag, code, words):
    error = refusal(files, **bag)
    assert error.code == code
    assert words in error.what


def test_a_strap_without_length_is_refused(tmp_path):
    points, cells, part, *_ = pillow()
    start = {"start": str(write_vtk(tmp_path / "twin.vtk", [*points, points[16]], cells, part))}
    strap = {"nodes": [[16, 74]]}
    error = refusal(start, straps=[strap])
    assert error.code == "E-GEO-010"
    assert "nodes 16 and 74, are 0 mm apart" in error.why
    assert len(build_shape(case(start, straps=[{**strap, "slack": 0.1}]).bag).straps) == 1


def test_points_that_no_cell_uses_change_nothing(tmp_path):
    points, cells, part, *_ = pillow()
    runs = []
    for name, more in (("plain", []), ("more", [[9.0, 9.0, 9.0]])):
        start = {"start": str(write_vtk(tmp_path / f"{name}.vtk", [*points, *more], cells, part))}
        model = build_model(case(start).vary({"run.gravity": [0.0, 0.0, -9.81]}))
        state = start_state(model)
        for _ in range(20):
            advance(model, state, 1e-5)
        runs.append(state)
    np.testing.assert_array_equal(runs[1].positions[:-1], runs[0].positions)
    assert runs[0].positions[16, 2] != points[16, 2]
    assert runs[1].positions[-1].tolist() == [9.0, 9.0, 9.0]


def test_a_reference_of_another_mesh_is_refused(files, tmp_path):
    *_, part, flat_points, flat_cells = pillow()
    for odd in (
        (flat_points, flat_cells[:-1], part[:-1]),
        (flat_points, flat_cells, part[::-1]),
        (flat_points, [flat_cells[0][:3], *flat_cells[1:]], part),
    ):
        files["reference"] = str(write_vtk(tmp_path / "odd.vtk", *odd))
        assert refusal(files).code == "E-GEO-033"


def test_mirrored_triangles_are_refused(files, tmp_path):
    """A flat piece of which a corner is folded over."""
    *_, part, flat_points, flat_cells = pillow()
    folded = flat_points.copy()
    folded[0] = flat_points[16]  # the corner of the front lies beyond its neighbours
    files["reference"] = str(write_vtk(tmp_path / "folded.vtk", folded, flat_cells, part))
    error = refusal(files)
    assert error.code == "E-GEO-036"
    assert "part front" in error.where


def test_a_panel_drawn_from_inside_counts_its_angle_in_the_drawing(files, tmp_path):
    """The mirror image of the rear piece, with the mirrored angle, is the same fabric."""
    *_, part, flat_points, flat_cells = pillow()
    outside = [PARTS[0], {**PARTS[1], "warp_angle": 30.0}]
    inside = [PARTS[0], {**PARTS[1], "warp_angle": -30.0, "seen_from": "inside"}]
    one = build_shape(case(files, outside).bag)
    mirrored = np.where(np.arange(len(flat_points))[:, None] < 49, flat_points, flat_points * [1.0, -1.0, 1.0])
    files["reference"] = str(write_vtk(tmp_path / "inside.vtk", mirrored, flat_cells, part))
    two = build_shape(case(files, inside).bag)
    model_one, model_two = (s.reference - s.reference[:, :1] for s in (one, two))
    np.testing.assert_allclose(model_one[..., 0], model_two[..., 0], atol=1e-12)  # along the warp
    np.testing.assert_allclose(np.abs(model_one[..., 1]), np.abs(model_two[..., 1]), atol=1e-12)


# --- pieces ----------------------------------------------------------------------------------------------------------


def test_diagonals_alternate_and_corners_keep_theirs():
    for n in (3, 4):
        points, cells, *_ = pillow(n)
        quads = np.array(cells)
        diagonal = diagonals(quads, len(points))
        triangles, owner = split(quads, diagonal)
        assert np.bincount(owner).tolist() == [2] * len(quads)
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        assert (count == 2).all()  # no diagonal is shared by the panels
    inner = diagonal.reshape(2, 4, 4)[0]
    assert (inner[:, 1:] != inner[:, :-1]).all()
    assert (inner[1:] != inner[:-1]).all()


def test_a_plane_piece_keeps_its_drawing_wherever_it_lies():
    rng = np.random.default_rng(3)
    flat = rng.uniform(size=(30, 2))
    triangles = rng.permutation(30).reshape(10, 3)
    tilt, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    tilt *= np.linalg.det(tilt)
    for space in (np.column_stack([flat, np.full(30, 0.7)]), np.column_stack([flat, np.zeros(30)]) @ tilt.T + 3.0):
        cut = flat_cut(space, triangles)
        for a, b in ((0, 1), (1, 2), (2, 0)):
            np.testing.assert_allclose(
                np.linalg.norm(cut[:, a] - cut[:, b], axis=1),
                np.linalg.norm(flat[triangles[:, a]] - flat[triangles[:, b]], axis=1),
                rtol=1e-10,
            )
    np.testing.assert_allclose(flat_cut(np.column_stack([flat, np.zeros(30)]), triangles), flat[triangles], atol=1e-15)


def test_a_shaped_piece_is_cut_triangle_by_triangle():
    """A cylinder about x unrolls: its warp runs along x in every triangle."""
    angle = np.linspace(0.0, np.pi, 9)
    points = np.concatenate([np.column_stack([np.full(9, x), np.cos(angle), np.sin(angle)]) for x in (0.0, 1.0)])
    quads = np.array([[k, k + 9, k + 10, k + 1] for k in range(8)])
    triangles, _ = split(quads, np.zeros(8, int))
    cut = flat_cut(points, triangles)
    corners = points[triangles]
    np.testing.assert_allclose(cut[..., 0] - cut[:, :1, 0], corners[..., 0] - corners[:, :1, 0], atol=1e-12)
