"""Straps, obstacles and the scene beside the frames of a run."""

import h5py
import numpy as np
import pytest

from billow.case.schema import Case
from billow.results.blocks import BLOCKS, StrapsFile
from billow.results.obstacles import obstacles_at, outline
from billow.results.result import Result
from billow.run.simulate import simulate

CASE = {
    "bag": {"element_size": 0.06, "straps": {"count": 4}},
    "obstacles": [
        {"shape": "plate"},
        {"shape": "super-ellipsoid", "name": "still", "radii": 0.1, "clearance": 0.3},
        {"shape": "super-ellipsoid", "name": "thrown", "radii": 0.12, "clearance": 0.05, "offset": [0.5, 0.0],
         "locked": False, "velocity": [0.0, 1.0, -2.0]},
    ],
    "run": {"end_time": 0.006, "frames": 3, "histories_per_frame": 2},
}  # fmt: skip


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return simulate(Case.from_dict(CASE), tmp_path_factory.mktemp("blocks") / "run")


def test_bars_lie_where_their_nodes_are_and_say_their_tension(result):
    straps = result.straps
    start = {tuple(p) for p in result.fabric.points(0).tolist()}
    assert {tuple(p) for p in straps.points(0).tolist()} <= start
    with h5py.File(straps.path) as file:
        grid = file["VTKHDF"]
        strap, tension = grid["CellData/strap"][:], grid["CellData/tension"][:].reshape(4, -1)
        assert grid["CellData/tension"].attrs["units"] == "N"
        assert grid["FieldData/strap_names"][:].tolist() == [b"strap_1", b"strap_2", b"strap_3", b"strap_4"]
    assert sorted(set(strap.tolist())) == [0, 1, 2, 3]
    rows = [int(np.abs(result.histories.time - time).argmin()) for time in result.times]
    for k in range(4):
        told = result.histories.of(f"strap_{k + 1}").tension[rows]
        np.testing.assert_allclose(tension[:, strap == k].sum(axis=1), told, rtol=1e-5, atol=1e-6)
    nodes = {tuple(p): n for n, p in enumerate(result.fabric.points(0).tolist())}
    ends = [nodes[tuple(p)] for p in straps.points(0).tolist()]
    np.testing.assert_array_equal(straps.points(3), result.fabric.points(3)[ends])


def blocks(path, frame):
    """Points of a frame, triangles, owners and their names."""
    with h5py.File(path) as file:
        grid = file["VTKHDF"]
        begin, count = grid["Steps/PointOffsets"][frame], grid["NumberOfPoints"][0]
        return (
            grid["Points"][begin : begin + count], grid["Connectivity"][:].reshape(-1, 3),
            grid["CellData/obstacle"][:], [name.decode() for name in grid["FieldData/obstacle_names"][:]],
        )  # fmt: skip


@pytest.mark.parametrize("frame", [0, 3])
def test_obstacles_are_where_the_histories_say_and_face_outwards(result, frame):
    points, triangles, owner, names = blocks(result.folder / BLOCKS["obstacles"], frame)
    assert names == ["plate", "still", "thrown"]
    there = {o["name"]: o for o in obstacles_at(result, float(result.times[frame]))}
    for k, name in enumerate(names[1:], start=1):
        mine = triangles[owner == k]
        np.testing.assert_allclose(outline(there[name], points[np.unique(mine)].astype(float)), 0.0, atol=1e-4)
        a, b, c = (points[mine[:, j]].astype(float) - there[name]["center"] for j in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).min() > 0.0
    plate = points[np.unique(triangles[owner == 0])]
    np.testing.assert_array_equal(plate[:, 2], 0.0)
    bag = result.fabric.points(frame)
    assert plate[:, 0].min() <= bag[:, 0].min()
    assert plate[:, 0].max() >= bag[:, 0].max()


def test_what_stands_still_is_stored_once(tmp_path):
    still = {**CASE, "obstacles": CASE["obstacles"][:2]}
    folder = simulate(Case.from_dict(still), tmp_path / "run").folder
    with h5py.File(folder / BLOCKS["obstacles"]) as file:
        assert len(file["VTKHDF/Points"]) == file["VTKHDF/NumberOfPoints"][0]
        assert file["VTKHDF/Steps/PointOffsets"][:].tolist() == [0, 0, 0, 0]


def test_the_scene_links_to_all_of_them_in_order_and_can_be_moved(result, tmp_path):
    moved = result.folder.rename(tmp_path / "elsewhere")
    try:
        with h5py.File(moved / "scene.vtkhdf") as file:
            grid = file["VTKHDF"]
            assert grid.attrs["Type"] == b"PartitionedDataSetCollection"
            assert list(grid["Assembly"]) == list(BLOCKS)
            for k, name in enumerate(BLOCKS):
                assert grid["Assembly"].get(name, getlink=True).path == f"/VTKHDF/{name}"
                assert grid.get(name, getlink=True).filename == BLOCKS[name]
                assert grid[name].attrs["Index"] == k
                np.testing.assert_array_equal(grid[name]["Steps/Values"][:], result.times)
    finally:
        moved.rename(result.folder)


def test_a_bag_alone_has_no_scene(tmp_path):
    case = CASE | {"obstacles": [], "bag": {"element_size": 0.06, "straps": {"count": 0}}}
    alone = simulate(Case.from_dict(case), tmp_path / "run")
    assert alone.straps is None
    assert not [name for name in ("scene", "straps", "obstacles") if (alone.folder / f"{name}.vtkhdf").exists()]


def test_the_record_vouches_for_every_file(result):
    assert {"fabric.vtkhdf", "straps.vtkhdf", "obstacles.vtkhdf", "scene.vtkhdf"} <= set(result.record["files"])
    assert repr(Result.open(result.folder)) == repr(result)


def test_straps_of_a_damaged_file_are_refused(result, tmp_path):
    path = tmp_path / "straps.vtkhdf"
    path.write_bytes((result.folder / "straps.vtkhdf").read_bytes()[:2000])
    with pytest.raises(Exception, match="E-RES-007"):
        StrapsFile(path)


def test_fabric_in_the_file_faces_outwards_and_names_its_parts(result):
    points, triangles = result.fabric.points(3).astype(float), result.triangles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert volume == pytest.approx(result.histories.of("").volume[-1], rel=1e-4)
    with h5py.File(result.folder / "fabric.vtkhdf") as file:
        assert [n.decode() for n in file["VTKHDF/FieldData/part_names"][:]] == result.fabric.part_names
        for field in ("stretch", "strain_warp", "strain_weft", "stress", "gauge_pressure"):
            assert file[f"VTKHDF/CellData/{field}"].attrs["units"]


def test_vtk_reads_the_scene(result):
    vtk = pytest.importorskip("vtk")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(result.folder / "scene.vtkhdf"))
    reader.UpdateInformation()
    for frame in (3, 0):
        key = vtk.vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
        reader.GetOutputInformation(0).Set(key, float(result.times[frame]))
        reader.Modified()
        reader.Update()
        whole = reader.GetOutputDataObject(0)
        assert whole.GetNumberOfPartitionedDataSets() == 3
        for k, name in enumerate(BLOCKS):
            assert whole.GetMetaData(k).Get(vtk.vtkCompositeDataSet.NAME()) == name
        bounds = whole.GetPartitionedDataSet(0).GetPartition(0).GetBounds()
        assert bounds[5] == pytest.approx(float(result.fabric.points(frame)[:, 2].max()), abs=1e-6)
