"""The pages of `billow view` and `billow compare --html` in a browser: what is shown is what the files hold."""

from __future__ import annotations

import base64
import gzip

import numpy as np
import pytest
from typer.testing import CliRunner

from billow.case.schema import Case
from billow.cli.main import app
from billow.pages import viewer
from billow.pages.packed import MOST_STEPS, in_bytes, in_planes
from billow.pages.viewer import Shown, viewer_page
from billow.results.blocks import extent, mesh_of
from billow.results.histories import History
from billow.results.obstacles import obstacles_at
from billow.results.result import Result
from billow.run.simulate import simulate


@pytest.fixture(scope="module")
def pair(small_case, tmp_path_factory):
    """Two runs of one mesh that differ in the permeability of their fabric."""
    place = tmp_path_factory.mktemp("pair")
    simulate(small_case, place / "tight")
    simulate(small_case.vary({"fabric.permeability": 0.2}), place / "leaky")
    return place / "tight", place / "leaky"


def billow(*words, code=None):
    done = CliRunner().invoke(app, [str(word) for word in words])
    if code is None:
        assert done.exception is None, done.exception
        return done.output
    assert done.exception.code == code, done.exception
    return done.exception


@pytest.fixture(scope="module")
def opened(open_page, pair):
    out = pair[0].parent / "view.html"
    billow("view", pair[0], "--out", out, "--field", "stress", "--field", "pressure")
    return open_page(out)


@pytest.fixture(scope="module")
def compared(open_page, pair):
    out = pair[0].parent / "pages" / "compare.html"
    assert "impactor" in billow("compare", *pair, "--html", out)
    return open_page(out)


def numbers(opened, expression):
    """The value of an expression, an array of numbers."""
    text = opened(f"btoa(Array.from(new Uint8Array(Float32Array.from({expression}).buffer), "
                  "(x) => String.fromCharCode(x)).join(''))")  # fmt: skip
    return np.frombuffer(base64.b64decode(text), np.float32)


def test_positions_are_those_of_the_file_to_half_a_step(opened, pair):
    fabric = Result.open(pair[0]).fabric
    points = np.stack([fabric.points(k) for k in range(len(fabric.times))])
    step = np.ptp(points, axis=(0, 1)) / MOST_STEPS
    for frame, there in enumerate(points):
        opened(f"page.clock.go({frame})")
        shown = numbers(opened, "page.sides[0].at").reshape(-1, 3)
        assert (np.abs(shown - there) <= 0.5 * step + 1e-7).all()


def test_fields_are_those_of_the_file_to_half_a_colour(opened, pair):
    fabric = Result.open(pair[0]).fabric
    for field, name in enumerate(("stress", "gauge_pressure")):
        truth = fabric.cell_data(name)
        low, high = opened(f"[page.sides[0].fields[{field}].low, page.sides[0].fields[{field}].high]")
        unit = opened(f"page.sides[0].fields[{field}].unit")
        factor = {"kPa": 1e3, "MPa": 1e6}[unit]
        for frame in range(len(truth)):
            shown = numbers(opened, f"page.sides[0].fields[{field}].values.of({frame})")
            assert np.abs(shown - np.clip(truth[frame] / factor, low, high)).max() <= 0.51 * (high - low) / 254


def test_obstacles_are_where_the_run_says(opened, pair):
    result = Result.open(pair[0])
    last = len(result.times) - 1
    opened(f"page.clock.go({last})")
    body = next(o for o in obstacles_at(result, float(result.times[last])) if o["name"] == "impactor")
    place = opened("page.sides[0].obstacles.findIndex((one) => one.name === 'impactor')")
    shown = numbers(opened, f"page.sides[0].obstacles[{place}].at").reshape(-1, 3)
    assert np.abs(shown - mesh_of(body, *extent(result.fabric))[0]).max() < 1e-5


def test_curves_are_those_of_the_histories(opened, pair):
    history = Result.open(pair[0]).histories
    shown = opened("page.plots.get('pressure').chart.data")
    assert shown[0] == pytest.approx((1e3 * history.time).tolist())
    assert shown[1] == pytest.approx((1e-3 * history.find("", "pressure")).tolist(), rel=1e-6)
    assert opened("page.plots.get('pressure').mark") == pytest.approx(opened("1e3 * page.clock.time"))


def test_other_quantities_are_drawn_when_asked_for(opened):
    page = opened.page
    drawn = opened("page.plots.size")
    page.locator("summary").click()
    box = page.locator("#boxes label", has_text="temperature").first
    box.click()
    assert opened("page.plots.size") == drawn + 1
    box.click()


def test_distances_between_two_runs_are_those_of_the_nodes(compared, pair):
    one, other = (Result.open(run).fabric for run in pair)
    frame = len(one.times) - 1
    compared(f"page.clock.go({frame})")
    truth = 1e3 * np.linalg.norm(one.points(frame).astype(float) - other.points(frame), axis=1)
    assert np.abs(numbers(compared, "page.distance(page.sides[0])") - truth).max() < 0.05
    assert compared("page.plots.get('pressure').chart.data.length") == 3
    assert "ISO/TS 18571" in compared.page.locator("#numbers").inner_text()


def test_two_runs_stand_side_by_side_or_over_one_another(compared):
    assert compared("page.sides.map((side) => side.mesh.visible)") == [True, False]
    compared.page.select_option("#arranged", "beside")
    assert compared("page.sides.map((side) => side.mesh.visible)") == [True, True]


def test_three_runs_are_shown_with_their_distances_from_the_last(open_page, pair):
    out = pair[0].parent / "pages" / "three.html"
    billow("compare", pair[1], pair[0], pair[0], "--html", out)
    page = open_page(out)
    last = page("page.clock.times.length - 1")
    page(f"page.clock.go({last})")
    most = [np.abs(numbers(page, f"page.distance(page.sides[{k}])")).max() for k in range(3)]
    assert most[0] > 1.0  # [mm]: the leaky bag
    assert most[1:] == [0.0, 0.0]
    page.page.select_option("#arranged", "beside")
    assert page("page.sides.map((side) => side.mesh.visible)") == [True] * 3
    assert page("page.plots.get('pressure').chart.data.length") == 4
    assert page.page.locator("#key span").count() == 3


@pytest.fixture(scope="module")
def gas_run(tmp_path_factory):
    """A closed bag with particles of air."""
    particles = {"model": "corpuscular", "particles": 5_000}
    run = {"end_time": 0.002, "frames": 2, "histories_per_frame": 4}
    case = {"gas": particles, "bag": {"element_size": 0.05, "initial_gap": 0.05}, "run": run}
    place = tmp_path_factory.mktemp("gas") / "run"
    simulate(Case.from_dict(case), place, threads=1)
    return place


def test_gas_in_the_section_is_that_of_the_boxes_it_cuts(open_page, gas_run):
    out = gas_run.parent / "view.html"
    billow("view", gas_run, "--out", out)
    page = open_page(out)
    gas = Result.open(gas_run).gas_frames
    for frame in range(len(gas.times)):
        boxes, place = gas.boxes(frame), 0.003
        cut = (boxes.low[:, 1] <= place) & (place < boxes.high[:, 1])
        shown = page(f"page.sides[0].gas.cut({frame}, 1, 1, {place})")
        assert len(shown) == cut.sum() > 0
        assert np.allclose([one["low"] for one in shown], boxes.low[cut][:, [0, 2]], atol=2e-5)
        field = page("page.sides[0].gas.fields[1]")
        assert (field["title"], field["unit"]) == ("temperature of the gas", "K")
        truth = boxes.values["temperature"][cut]
        steps = 1 + 254 * (np.clip(truth, field["low"], field["high"]) - field["low"]) / (field["high"] - field["low"])
        steps[np.isnan(truth)] = 0
        assert np.abs(np.array([one["step"] for one in shown]) - steps).max() <= 0.51
    assert page.page.locator("#gas-legend").is_visible()
    page.page.select_option("#gas", "none")
    assert not page.page.locator("#gas-legend").is_visible()
    assert page.barriers() == []


def test_a_gas_that_is_the_same_everywhere_has_no_choice(opened):
    assert not opened.page.locator("#gas").is_visible()


def test_the_time_moves_by_keyboard_and_by_itself(opened):
    page = opened.page
    page.locator("#time").focus()
    page.keyboard.press("Home")
    assert opened("page.clock.frame") == 0
    page.keyboard.press("ArrowRight")
    assert opened("page.clock.frame") == 1
    page.locator("#play").click()
    opened.until("page.clock.frame !== 1")
    page.locator("#play").click()
    page.locator("#picture").focus()
    before = opened("page.picture.camera.position.x")
    page.keyboard.press("ArrowLeft")
    assert opened("page.picture.camera.position.x") != before


def test_pages_have_no_barriers(opened, compared):
    assert opened.barriers() == []
    assert compared.barriers() == []


def test_a_barrier_is_found(open_page, tmp_path):
    path = tmp_path / "page.html"
    path.write_text("<title>a</title><script>globalThis.ready = true</script><button></button>")
    assert "button-name" in open_page(path).barriers()[0]


def test_a_run_against_a_table_of_a_test(open_page, pair):
    table = pair[0].parent / "test.csv"
    table.write_text("time [ms],pressure [kPa]\n" + "".join(f"{k},{101 + k}\n" for k in range(20)))
    out = pair[0].parent / "test.html"
    billow("compare", table, pair[0], "--html", out)
    page = open_page(out)
    assert page("page.sides.length") == 1
    assert page("page.plots.get('pressure').chart.data.length") == 3
    billow("compare", table, table, "--html", out, code="E-PAG-003")


def test_a_page_that_would_be_too_large_shows_fewer_frames_and_says_so(pair, monkeypatch):
    result = Result.open(pair[0])
    shown = [Shown("run", result.fabric, result, result.histories)]
    monkeypatch.setattr(viewer, "page", lambda title, body, modules, data: data)
    whole = viewer_page(shown, "Run")
    monkeypatch.setattr(viewer, "MOST_BYTES", len(whole) - 1)
    fewer = viewer_page(shown, "Run")
    assert len(fewer) < len(whole)
    assert b"Only one" not in gzip.decompress(whole)
    assert b"Only one frame in 2" in gzip.decompress(fewer)


def test_names_from_files_are_text(open_page, pair, tmp_path):
    result = Result.open(pair[0])
    hostile = "</script><img src=x onerror=alert(1)>"
    curves = History({"time [s]": np.linspace(0.0, 0.015, 4), f"{hostile} [m]": np.ones(4)})
    table = {"head": [hostile] * 6, "rows": [[hostile] * 6]}
    path = tmp_path / "page.html"
    path.write_text(viewer_page([Shown(hostile, result.fabric, result, curves, hostile)] * 2, hostile, table=table))
    page = open_page(path)
    assert page.page.locator("h1").inner_text() == hostile
    assert page("document.querySelectorAll('img').length") == 0


def test_only_pages_are_replaced_and_names_end_in_html(pair, tmp_path):
    billow("view", pair[0], "--out", tmp_path / "view.png", code="E-PAG-002")
    billow("compare", *pair, "--html", tmp_path / "compare", code="E-PAG-002")
    mine = tmp_path / "mine.html"
    mine.write_text("<!doctype html><title>Mine</title>")
    billow("view", pair[0], "--out", mine, code="E-RES-024")
    billow("view", pair[0], "--out", tmp_path / "a.html")
    billow("view", pair[0], "--out", tmp_path / "a.html")


def test_packing_loses_half_a_step_at_most():
    random = np.random.default_rng(1)
    positions = random.normal(size=(5, 40, 3)) * [1.0, 10.0, 0.0]
    planes, box = in_planes(positions)
    steps = np.cumsum(planes[0].astype(int) + 256 * planes[1].astype(int), axis=0) % 65536
    back = box[0] + (box[1] - box[0]) / MOST_STEPS * steps.transpose(0, 2, 1)
    assert (np.abs(back - positions) <= 0.5001 * (box[1] - box[0]) / MOST_STEPS).all()
    values = random.normal(size=(4, 30))
    values[2, 3] = np.nan
    coded = np.cumsum(in_bytes(values, -1.0, 2.0).astype(int), axis=0) % 256
    assert coded[2, 3] == 0
    known = np.isfinite(values)
    assert np.abs((-1.0 + 3.0 * (coded - 1) / 254)[known] - np.clip(values, -1.0, 2.0)[known]).max() <= 1.5 / 254 + 1e-9
