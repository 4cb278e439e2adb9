"""Comparisons of runs, surrogates and tests whose differences are known."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.apps.compare.differences import compare_curves, compare_shapes, compare_sides, injuries, rated
from billow.apps.compare.report import table
from billow.apps.compare.sides import open_sides
from billow.cli.main import app
from billow.injury.criteria import GRAVITY, assess, assess_run
from billow.injury.rating import rate
from billow.pictures.curves import Curve
from billow.pictures.source import labels
from billow.results.dataset_files import DatasetRecord, write_dataset_file, write_design, write_split
from billow.results.histories import write_histories
from billow.results.result import Result
from billow.results.run_file import write_run_file
from billow.results.vtkhdf import FabricWriter

sys.path.insert(0, str(Path(__file__).parents[2]))  # trust/ stands beside the package, not in it

from trust.small_surrogate import small_surrogate

TIMES = np.arange(401) * 1e-4
FRAMES = np.array([0.0, 0.01, 0.02, 0.03])
BUMP = np.exp(-(((TIMES - 0.02) / 0.004) ** 2))
DESIGN = {"permeability": 0.03, "temperature": 600.0}


def run_folder(folder, pressure=1e5 + 3e4 * BUMP, speed=None, moved=0.0, frames=FRAMES, bag=None):
    """A run of the four nodes of the small surrogate; speed: of a free head along z [m/s]."""
    bag = bag or small_surrogate()
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text("")
    place, part = np.array(bag.reference, float), np.array([0, 1])
    place[:, 2] += moved
    with FabricWriter(folder / "fabric.vtkhdf", bag.reference, bag.triangles, part, ["front", "rear"]) as fabric:
        for time in frames:
            fabric.append(float(time), place, {"displacement": place - bag.reference})
    columns = {"time [s]": TIMES, "pressure [Pa]": pressure}
    if speed is not None:
        for name, unit in (("velocity", "m/s"), ("acceleration", "m/s^2")):
            columns |= {f"head_{name}_{axis} [{unit}]": speed * (axis == "z") for axis in "xyz"}
    write_histories(folder / "histories.csv", columns)
    record = {
        "status": "completed",
        "reason": None,
        "case_digest": "",
        "wall_seconds": 1.0,
        "ledger": {},
        "title": "Run",
    }
    write_run_file(folder, record)
    return folder


def sides(one, other, design=None):
    return open_sides((one, other), tuple(labels((one, other))), design)


def billow(*words, code=None):
    done = CliRunner().invoke(app, ["compare", *map(str, words)])
    if code is None:
        assert done.exception is None, done.exception
        return done.output
    assert done.exception.code == code
    return done.exception


# --- curves ------------------------------------------------------------


def test_peaks_and_ends_differ_by_what_was_added(tmp_path):
    one = run_folder(tmp_path / "a", pressure=1e5 + 3e4 * BUMP)
    other = run_folder(tmp_path / "b", pressure=1.02e5 + 5e4 * BUMP)
    (found,) = compare_curves(*sides(one, other), ["pressure"], None)
    assert found.first.peak == (pytest.approx(1.3e5), pytest.approx(0.02))
    assert found.second.peak[0] - found.first.peak[0] == pytest.approx(2.2e4)
    assert found.second.end - found.first.end == pytest.approx(2e3, abs=1.0)
    said = json.loads(billow(one, other, "--json"))
    assert said["curves"][0]["first"]["peak"] == pytest.approx(1.3e5)
    assert said["curves"][0]["unit"] == "Pa"
    text = billow(one, other)
    assert "pressure [kPa]" in text
    assert "-22" in text
    assert f"{100 * (130 - 152) / 152:+.1f} %" in text


def test_the_second_is_the_reference_of_the_rating(tmp_path):
    one, other = 1e5 + 3e4 * BUMP, 1e5 + 6e4 * np.roll(BUMP, 10)
    first, second = (Curve("p", "Pa", TIMES, curve) for curve in (one, other))
    assert rated(first, second)[0] == rate(TIMES, one, other)
    assert rated(first, second)[0] != rated(second, first)[0]
    assert rated(first, second)[0].shift == pytest.approx(-1e-3)
    found = compare_curves(
        *sides(run_folder(tmp_path / "a", one), run_folder(tmp_path / "b", other)), ["pressure"], None
    )
    assert found[0].rating == rate(TIMES, one, other)


def test_curves_of_other_times_are_rated_where_both_have_values():
    fine = np.linspace(0.005, 0.035, 601)
    one = Curve("p", "Pa", TIMES, np.sin(200.0 * TIMES))
    other = Curve("p", "Pa", fine, np.sin(200.0 * fine))
    assert rated(one, other)[0].overall == pytest.approx(1.0, abs=1e-3)
    late = Curve("p", "Pa", TIMES + 1.0, one.values)
    assert rated(one, late) == (None, "they have no time in common")
    assert rated(one, Curve("p", "Pa", TIMES, np.ones(401)))[0] is None


def test_a_table_of_a_test_is_compared_with_a_run(tmp_path):
    one = run_folder(tmp_path / "a")
    table = tmp_path / "test.csv"
    rows = "".join(f"{1e3 * t:.1f},{(1e5 + 2e4 * b) / 1e3:.6f},7\n" for t, b in zip(TIMES, BUMP, strict=True))
    table.write_text("time [ms],pressure [kPa],camera [-]\n" + rows)
    said = json.loads(billow(one, table, "--json"))
    assert said["curves"][0]["second"]["peak"] == pytest.approx(1.2e5)
    assert said["shapes"] == []
    billow(one, table, "--out", tmp_path / "a.png")
    billow(one, table, "-q", "pressur", code="E-PIC-009")
    assert "only one of a and test.csv has camera" in billow(one, table, "-q", "pressure", "-q", "camera")


def test_two_without_anything_in_common_are_refused(tmp_path):
    table, other = tmp_path / "one.csv", tmp_path / "two.csv"
    table.write_text("time [ms],a [N]\n0,1\n1,2\n")
    other.write_text("time [ms],b [N]\n0,1\n1,2\n")
    billow(table, other, code="E-CMP-003")
    billow(table, code="E-CMP-004")
    billow(*[table] * 5, code="E-CMP-004")


def test_several_are_compared_each_with_the_last(tmp_path):
    runs = [run_folder(tmp_path / name, 1e5 + rise * BUMP) for name, rise in (("a", 3e4), ("b", 4e4), ("c", 6e4))]
    test = tmp_path / "test.csv"
    rows = "".join(f"{1e3 * t:.1f},{1e2 + 50 * b:.6f}\n" for t, b in zip(TIMES, BUMP, strict=True))
    test.write_text("time [ms],pressure [kPa]\n" + rows)
    said = json.loads(billow(*runs, test, "--json"))
    assert [one["first"] for one in said] == [str(run) for run in runs]
    peaks = [(one["curves"][0]["first"]["peak"], one["curves"][0]["second"]["peak"]) for one in said]
    assert np.allclose(peaks, [(1.3e5, 1.5e5), (1.4e5, 1.5e5), (1.6e5, 1.5e5)])
    told = billow(*runs, test)
    assert [f"{letter} - D" in told for letter in "ABC"] == [True] * 3
    billow(*runs, test, "--out", tmp_path / "all.png", "--html", tmp_path / "all.html")
    page = (tmp_path / "all.html").read_text()
    assert "a, b, c against test" in page[:3000]
    numbers = page_table([*runs, test])
    assert numbers["head"] == ["", "a", "b", "c", "test.csv, the reference"]
    assert numbers["rows"][0][1:] == [
        "130 at 20.0 ms (-13.3 %)", "140 at 20.0 ms (-6.7 %)", "160 at 20.0 ms (+6.7 %)", "150 at 20.0 ms",
    ]  # fmt: skip


def page_table(paths):
    *others, reference = open_sides(paths, labels(paths), None)
    return table([compare_sides(side, reference, ["pressure"], None) for side in others], ())


# --- injury metrics ------------------------------------------------------------


def test_injury_metrics_are_those_of_billow_injury(pair):
    for folder in pair:
        result = Result.open(folder)
        assert injuries(result.histories) == assess_run(result)


def test_a_half_sine_has_the_metrics_of_its_velocity_and_of_its_acceleration(tmp_path):
    speed = 0.5 * 500.0 * 0.02 / np.pi * (1.0 - np.cos(np.pi * np.clip(TIMES - 0.01, 0.0, 0.02) / 0.02)) * 2.0
    one = run_folder(tmp_path / "a", speed=speed)
    acceleration = np.gradient(speed, TIMES) / GRAVITY
    table = tmp_path / "test.csv"
    rows = "".join(f"{1e3 * t:.1f},{a:.9g}\n" for t, a in zip(TIMES, acceleration, strict=True))
    table.write_text("time [ms],head acceleration z [g]\n" + rows)
    said = json.loads(billow(one, table, "-q", "head_acceleration_z", "--json"))["injury"]
    expected = assess(TIMES, np.stack([0.0 * speed, 0.0 * speed, speed], axis=1))
    assert said["first"]["head"]["HIC15"] == pytest.approx(expected.hic15.value, rel=1e-12)
    assert said["second"]["head"]["HIC15"] == pytest.approx(expected.hic15.value, rel=0.01)
    assert said["second"]["head"]["peak, CFC 1000"] == pytest.approx(expected.peak / GRAVITY, rel=0.01)
    assert "head HIC15" in billow(one, table, "-q", "head_acceleration_z")


# --- shapes ------------------------------------------------------------


def test_shapes_are_apart_by_how_far_one_was_moved(tmp_path):
    one, other = run_folder(tmp_path / "a"), run_folder(tmp_path / "b", moved=0.004)
    found = compare_shapes(*sides(one, other))
    np.testing.assert_allclose([shape.time for shape in found], FRAMES)
    np.testing.assert_allclose([shape.rms for shape in found], 0.004, rtol=1e-5)
    np.testing.assert_allclose([shape.largest for shape in found], 0.004, rtol=1e-5)
    assert "4.00 mm" in billow(one, other)


def test_only_frames_of_one_time_are_compared(tmp_path):
    one, other = run_folder(tmp_path / "a"), run_folder(tmp_path / "b", frames=np.array([0.0, 0.015, 0.03]))
    assert [shape.time for shape in compare_shapes(*sides(one, other))] == [0.0, 0.03]
    apart = run_folder(tmp_path / "c", frames=np.array([0.001, 0.002]))
    assert "no frame of one has the time" in billow(one, apart)
    billow(one, apart, "--out", tmp_path / "a.png")


def test_other_meshes_are_drawn_and_not_compared_node_by_node(tmp_path, pair):
    one = run_folder(tmp_path / "a")
    assert compare_shapes(*sides(one, pair[0])) == []
    assert "their meshes differ" in billow(one, pair[0], "--out", tmp_path / "a.svg")


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_two_runs_are_drawn_over_one_another(pair, tmp_path, kind):
    for name in ("one", "two"):
        said = billow(
            *pair, "--out", tmp_path / f"{name}.{kind}", "--cfc", 180, "--section", "x=10 mm", "--view", "top"
        )
    assert f"two.{kind}: written" in said
    assert (tmp_path / f"one.{kind}").read_bytes() == (tmp_path / f"two.{kind}").read_bytes()


def test_the_figure_says_rating_times_and_distances(pair, tmp_path):
    billow(*pair, "--out", tmp_path / "a.svg")
    text = (tmp_path / "a.svg").read_text()
    for part in (
        "ISO/TS 18571",
        "RMS distance",
        "15.0 ms",
        f"distance from {pair[1].name} [mm]",
        "x [mm]",
        "z [mm]",
        pair[0].name,
        pair[1].name,
    ):
        assert part in text, part


# --- surrogates ------------------------------------------------------------


@pytest.fixture
def study(tmp_path):
    """A study of one run, and a surrogate of its mesh."""
    bag = small_surrogate()
    folder = tmp_path / "study"
    run_folder(folder / "runs" / "0000", frames=bag.times, moved=0.5)
    write_dataset_file(
        folder, DatasetRecord("S", 0.3, 1, bag.training["mesh_sha256"], tuple(bag.times.tolist()), bag.parameters)
    )
    write_design(folder, bag.parameters, {"0000": tuple(DESIGN.values())})
    write_split(folder, ["0000"], [])
    bag.save(tmp_path / "surrogate.safetensors")
    return folder


def test_a_surrogate_answers_for_the_design_of_the_run(study, tmp_path):
    path = tmp_path / "surrogate.safetensors"
    first, second = sides(study / "runs" / "0000", path)
    expected = small_surrogate().reference + small_surrogate().predict(DESIGN)
    np.testing.assert_array_equal(second.fabric.points(1), expected[1])
    assert second.fabric.part_names == ["front", "rear"]
    moved = np.array([0.0, 0.0, 0.5])
    away = np.linalg.norm(expected - small_surrogate().reference - moved, axis=2)
    np.testing.assert_allclose([shape.largest for shape in compare_shapes(first, second)], away.max(axis=1), rtol=1e-5)
    assert "not judged" in billow(study / "runs" / "0000", path)
    assert "not judged" in billow(path, study / "runs" / "0000", "--out", tmp_path / "a.png")


def test_a_run_outside_a_study_needs_its_design_to_be_told(study, tmp_path):
    path = tmp_path / "surrogate.safetensors"
    alone = shutil.copytree(study / "runs" / "0000", tmp_path / "alone")
    billow(alone, path, code="E-CMP-001")
    billow(path, path, code="E-CMP-002")
    values = [word for name, value in DESIGN.items() for word in ("--set", f"{name}={value}")]
    told = json.loads(billow(alone, path, "--json", *values))
    assert told["shapes"] == json.loads(billow(study / "runs" / "0000", path, "--json"))["shapes"]
    same = json.loads(billow(path, path, "--json", *values))
    assert {shape["largest"] for shape in same["shapes"]} == {0.0}
    billow(alone, path, "--set", "temperature=600", code="E-ROM-001")
