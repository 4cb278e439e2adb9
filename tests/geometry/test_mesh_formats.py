"""What mesh formats can hold beyond one closed surface of triangles at one time is read right, or refused by name."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from mesh_files import pillow, write_vtk, write_vtkhdf

from billow.base.errors import InputError
from billow.geometry import hdf_arrays
from billow.geometry.mesh_file import read_mesh

POINTS, CELLS, PART, *_ = pillow(n=2)
TEXT = "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n"
SQUARE = "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\n"


def told(path, **options):
    with pytest.raises(InputError, match="E-GEO-03") as caught:
        read_mesh(path, **options)
    return caught.value


def legacy(tmp_path, text):
    path = tmp_path / "mesh.vtk"
    path.write_text(text)
    return path


def temporal(path, meshes):
    """VTKHDF whose cells change from time to time, as VTK writes them. meshes: (points, cells, part) of each time."""
    counts = {
        "Point": [len(points) for points, _, _ in meshes],
        "Cell": [len(cells) for _, cells, _ in meshes],
        "ConnectivityId": [sum(map(len, cells)) for _, cells, _ in meshes],
    }
    with h5py.File(path, "w") as file:
        grid = file.create_group("VTKHDF")
        grid.attrs["Version"] = np.array([2, 2])
        grid.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        steps = grid.create_group("Steps")
        steps.attrs["NSteps"] = len(meshes)
        steps["PartOffsets"] = np.arange(len(meshes))
        steps["NumberOfParts"] = np.ones(len(meshes), int)
        for name, count in counts.items():
            grid[f"NumberOf{name}s"] = count
            steps[f"{name}Offsets"] = np.cumsum([0, *count[:-1]])
        lengths = [[len(cell) for cell in cells] for _, cells, _ in meshes]
        grid["Points"] = np.concatenate([points for points, _, _ in meshes])
        grid["Connectivity"] = np.concatenate([np.concatenate(cells) for _, cells, _ in meshes])
        grid["Offsets"] = np.concatenate([[0, *np.cumsum(n)] for n in lengths])
        grid["Types"] = np.concatenate([[{3: 5, 4: 9}[n] for n in ns] for ns in lengths]).astype(np.uint8)
        grid["CellData/part"] = np.concatenate([part for _, _, part in meshes])
    return path


def test_a_mesh_whose_cells_change_in_time_is_that_of_its_time(tmp_path):
    meshes = [pillow(n)[:3] for n in (3, 2, 4)]
    path = temporal(tmp_path / "t.vtkhdf", meshes)
    for frame, (points, cells, part) in enumerate(meshes):
        for asked in (frame, frame - 3):
            mesh = read_mesh(path, frame=asked)
            np.testing.assert_array_equal(mesh.points, points)
            assert mesh.cells.tolist() == cells
            assert mesh.part.tolist() == part
    assert "3 times; there is no frame 3" in told(path, frame=3).why


@pytest.mark.parametrize(("last", "corners"), [([0, 1, 2, 2], [0, 1, 2]), ([0, 1, 2, 0], [0, 1, 2])])
def test_a_quad_whose_last_node_repeats_a_neighbour_is_a_triangle(tmp_path, last, corners):
    mesh = read_mesh(write_vtk(tmp_path / "q.vtk", POINTS, [last, *CELLS[1:]], PART))
    assert mesh.cells[0].tolist() == [*corners, -1]
    assert mesh.cells[1].tolist() == CELLS[1]


@pytest.mark.parametrize("odd", [[0, 1, 0, 3], [0, 0, 1, 2], [0, 1, 1, 2], [0, 1, 2, 1], [0, 0, 1]])
def test_a_cell_that_names_a_node_twice_is_refused_otherwise(tmp_path, odd):
    error = told(write_vtk(tmp_path / "q.vtk", POINTS, [*CELLS[:-1], odd], PART))
    assert f"cell {len(CELLS) - 1} has a node twice" in error.why


def test_a_part_field_that_is_not_there_is_told_with_those_that_are(tmp_path):
    path = write_vtk(tmp_path / "u.vtk", POINTS, CELLS, PART)
    path.write_text(path.read_text().replace("SCALARS part", "SCALARS PART"))
    assert "no cell field 'part'; its cell fields are PART" in told(path).why
    assert read_mesh(path, "PART").part.tolist() == PART
    other = write_vtkhdf(tmp_path / "u.vtkhdf", POINTS, CELLS, PART)
    assert "no cell field 'panel'; its cell fields are part" in told(other, part_field="panel").why


def test_a_mesh_without_cell_fields_is_one_part(tmp_path):
    assert read_mesh(legacy(tmp_path, TEXT + SQUARE)).part.tolist() == [0, 0]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_titles_may_be_of_any_language_and_lines_end_in_any_way(tmp_path, encoding, end):
    path = tmp_path / "ü.vtk"
    text = TEXT.replace("\na\n", "\nPrüfkörper Ø 400\n") + SQUARE
    path.write_bytes(text.replace("\n", end).encode(encoding))
    assert read_mesh(path).cells[:, :3].tolist() == [[0, 1, 2], [0, 2, 3]]


def test_all_that_programs_write_around_the_cells_is_passed_over(tmp_path):
    head, points = TEXT.split("POINTS")
    text = (
        head + "FIELD FieldData 2\nTimeValue 1 1 double\n0.5\nname 1 1 string\nan airbag\nMETADATA\nINFORMATION 0\n\n"
        "POINTS" + points + "METADATA\nINFORMATION 1\nNAME L2_NORM\n\nVERTICES 0 0\nLINES 0 0\n" + SQUARE
        + "CELL_DATA 2\nCOLOR_SCALARS colour 3\n0 0 0 1 1 1\nSCALARS part int\nLOOKUP_TABLE mine\n7 8\n"
        "LOOKUP_TABLE mine 1\n0 0 0 1\nTENSORS t float\n" + "0 " * 18 + "\nGLOBAL_IDS g vtkIdType\n1 2\n"
        "POINT_DATA 4\nTEXTURE_COORDINATES uv 2 float\n" + "0 " * 8 + "\nSCALARS part int 1\nLOOKUP_TABLE d\n9 9 9 9"
    )  # fmt: skip
    mesh = read_mesh(legacy(tmp_path, text))
    assert mesh.part.tolist() == [7, 8]


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ("LINES 1 3\n2 0 1\n" + SQUARE, "LINES"),
        ("VERTICES 1 2\n1 0\n" + SQUARE, "VERTICES"),
        ("TRIANGLE_STRIPS 1 5\n4 0 1 2 3\n", "TRIANGLE_STRIPS"),
        ("POLYGONS 1 6\n5 0 1 2 3 0\n", "a polygon"),
        (SQUARE + "CELL_TYPES 2\n5 22\n", "cell 1 is a quadratic triangle"),
        (SQUARE + "CELL_TYPES 2\n5 10\n", "cell 1 is a tetrahedron"),
        (SQUARE + SQUARE, "a second list of cells"),
        ("POINTS 1 float\n0 0 0\n" + SQUARE, "a second list of points"),
        ("POLYGONS 1 4\n3 0 1 2.5\n", "2.5 is not a whole number"),
        ("POLYGONS 1 4\n3 0 1 two\n", "line 7 announces is 'two', not a number"),
        ("POLYGONS 1 4\n3 0 1 1_0\n", "'1_0', not a number"),
        ("POLYGONS 1 4\n3 0 1 9\n", "not among 0 to 3"),
        ("POLYGONS 2 8\n3 0 1 2 4 0 2 3\n", "does not fit cell 1"),
        ("POLYGONS 1 8\n3 0 1 2 3 0 2 3\n", "which take 4"),
        (SQUARE + "CELL_DATA 2\nSCALARS vtkGhostType int\nLOOKUP_TABLE default\n0 1\n", "ghost"),
        (SQUARE + "CELL_DATA 2\nSCALARS part int 2\nLOOKUP_TABLE default\n0 1 2 3\n", "shape (2, 2)"),
        (SQUARE + "CELL_DATA 2\nSCALARS part bit\nLOOKUP_TABLE default\n0 1\n", "the type 'bit'"),
        (SQUARE + "CELL_DATA 1\nSCALARS part int\nLOOKUP_TABLE default\n0\n", "shape (1,)"),
        (SQUARE + "SOMETHING 2\n", "line 10 begins with 'SOMETHING'"),
        (SQUARE + "CELL_DATA two\n", "'two' where a number of items"),
    ],
)
def test_what_a_legacy_file_can_hold_besides_is_refused_by_name(tmp_path, more, why):
    assert why in told(legacy(tmp_path, TEXT + more)).why


def changed(tmp_path, change):
    path = write_vtkhdf(tmp_path / "m.vtkhdf", POINTS, CELLS, PART)
    with h5py.File(path, "r+") as file:
        change(file["VTKHDF"])
    return path


def put(name, value):
    def change(grid):
        if name in grid:
            del grid[name]
        grid[name] = value

    return change


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda grid: grid.attrs.create("Type", np.bytes_("PolyData")), "it holds PolyData"),
        (put("NumberOfPoints", [9, 9]), "several pieces"),
        (put("NumberOfPoints", [10**6]), "Points has"),
        (put("NumberOfCells", [-1]), "NumberOfCells is -1"),
        (put("Points", np.zeros((20, 2))), "Points has shape (20, 2)"),
        (put("Points", "text"), "Points is no array of numbers"),
        (put("Types", np.full(8, 22, np.uint8)), "cell 0 is a quadratic triangle"),
        (put("CellData/vtkGhostType", np.ones(8, np.uint8)), "ghost cells"),
        (put("CellData/part", np.zeros((8, 5))), "CellData/part has shape (8, 5)"),
        (put("CellData/part", np.full(8, 0.5)), "0.5 is not a whole number"),
        (put("Connectivity", np.full(32, 2**40)), "not among 0 to 9"),
        (lambda grid: grid.pop("Offsets"), "Offsets"),
    ],
)
def test_what_a_vtkhdf_file_can_hold_besides_is_refused_by_name(tmp_path, change, why):
    assert why in told(changed(tmp_path, change)).why


def test_a_small_file_that_unpacks_to_gigabytes_is_refused(tmp_path):
    def bomb(grid):
        del grid["Points"]
        rows = hdf_arrays.LARGEST_CHUNK // 12 + 1
        grid.create_dataset("Points", (rows, 3), "f4", chunks=(rows, 3), compression="gzip")

    path = changed(tmp_path, bomb)
    assert path.stat().st_size < 100_000
    assert "packed in pieces of more than" in told(path).why
