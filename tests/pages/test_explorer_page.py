"""The page of `billow explore` in a browser: its answers are those of Python, and everything can be reached."""

from __future__ import annotations

import base64
import html
import io
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from made_models import PARAMETERS, made_coupled, made_surrogate
from PIL import Image
from typer.testing import CliRunner

from billow.cli.main import app
from billow.injury.criteria import assess
from billow.pages.explorer import LEAST_BOUND, PART_OF_WIDTH, in_half_precision
from billow.results.dataset_files import Parameter
from billow.results.obstacles import outline
from billow.rom.coupled.injury_metrics import METRICS, metric_values
from billow.rom.surrogate.design_space import from_unit
from billow.rom.surrogate.locked_obstacles import LockedObstacle, numbers_of
from billow.rom.surrogate.surrogate import Surrogate

DESIGNS = from_unit(np.random.default_rng(3).random((20, len(PARAMETERS))), PARAMETERS)
TIMES = (0.0, 0.0013, 0.01, 0.0271, 0.03, 0.0449, 0.05)


def written(place, model, name="model"):
    """A page of a model, saved by its file."""
    path = model.save(place / f"{name}.safetensors")
    done = CliRunner().invoke(app, ["explore", str(path)])
    assert done.exception is None, done.exception
    return path.with_suffix(".html")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("explorer")


@pytest.fixture(scope="module")
def surrogate():
    return made_surrogate()


@pytest.fixture(scope="module")
def opened(open_page, place, surrogate):
    return open_page(written(place, surrogate))


@pytest.fixture(scope="module")
def coupled():
    return made_coupled()


@pytest.fixture(scope="module")
def with_head(open_page, place, coupled):
    return open_page(written(place, coupled, "coupled"))


ASK = """([name, designs, times]) => {
  const words = designs.flatMap((design) => times.flatMap((time) => Array.from(page[name](design, time))));
  const bytes = new Uint8Array(Float32Array.from(words).buffer), parts = [];
  for (let i = 0; i < bytes.length; i += 8192) parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
  return btoa(parts.join(""));
}"""


def asked(opened, function, designs, times=TIMES):
    """What the page says of some designs: (designs, times, nodes, 3). As bytes: a driver's lists are slow."""
    answer = opened(ASK, [function, np.atleast_2d(designs).tolist(), list(times)])
    numbers = np.frombuffer(base64.b64decode(answer), np.float32)
    return numbers.reshape(len(np.atleast_2d(designs)), len(times), -1, 3)


def test_shapes_are_those_of_numpy(opened, surrogate):
    """In half precision to the bound that the page was written with, and their intervals as well as they are known."""
    bound = max(LEAST_BOUND, PART_OF_WIDTH * float(np.median(surrogate.half_width(DESIGNS[0]))))
    truth = surrogate.predict(DESIGNS, np.array(TIMES))
    assert np.abs(asked(opened, "displacement", DESIGNS) - truth).max() < bound
    widths = surrogate.half_width(DESIGNS[:4], np.array(TIMES))
    assert np.abs(asked(opened, "halfWidths", DESIGNS[:4]) - widths).max() < 1e-3 * widths.max()


@pytest.mark.parametrize(("recipe", "clock"), [("shared", False), ("shared", True), ("paper", False)])
def test_shapes_in_full_precision_are_those_of_numpy(open_page, place, recipe, clock, monkeypatch):
    monkeypatch.setattr("billow.pages.explorer.in_half_precision", lambda surrogate, modes: modes)
    surrogate = made_surrogate(100, recipe=recipe, width=16, clock=clock)
    page = open_page(written(place, surrogate, f"{recipe}_{clock}"))
    truth = surrogate.predict(DESIGNS, np.array(TIMES))
    assert np.abs(asked(page, "displacement", DESIGNS) - truth).max() < 1e-6
    if recipe == "shared":
        widths = surrogate.half_width(DESIGNS, np.array(TIMES))
        assert np.abs(asked(page, "halfWidths", DESIGNS) - widths).max() < 1e-6


def test_half_precision_is_read_without_the_browsers_own(open_page, place, surrogate):
    page = open_page(place / "model.html", before="delete globalThis.Float16Array; delete Uint8Array.fromBase64;")
    truth = surrogate.predict(DESIGNS[0], np.array([0.03]))[0]
    assert np.abs(asked(page, "displacement", DESIGNS[0], [0.03])[0, 0] - truth).max() < 1e-3


def test_modes_that_need_it_keep_full_precision():
    """A bag that moves by tens of metres would be off by more than the bound."""
    near, far = made_surrogate(100), made_surrogate(100)
    far.regression.outputs.mean[:] *= 1000.0
    found = [in_half_precision(one, np.stack([basis.modes for basis in one.bases])).dtype for one in (near, far)]
    assert found == [np.float16, np.float32]


def test_the_standing_of_a_design_is_that_of_python(opened, surrogate):
    for design in DESIGNS[:8]:
        stands = surrogate.standing(design)
        nearest = opened("(design) => page.known.nearest(design, page.sliders.parameters)", design.tolist())
        text, warning = opened("(design) => page.known.says(design, page.sliders.parameters)", design.tolist())
        assert nearest == pytest.approx(stands.nearest, abs=1e-9)
        assert f"{stands.nearest:.2f} away" in text
        assert warning == stands.isolated


def test_motion_and_injury_metrics_are_those_of_python(with_head, coupled):
    run = """(design) => {
      const work = page.curves(design);
      for (;;) { const {done, value} = work.next(); if (done) return [Array.from(value.motion.velocity),
        Array.from(value.motion.centre), Array.from(value.motion.acceleration), value.motion.metrics]; }
    }"""
    for design in DESIGNS[:3]:
        answer = coupled.answer(design)
        velocity, centre, acceleration, metrics = with_head(run, design.tolist())
        moved = np.abs(answer.motion.velocity[:, 2] - answer.motion.velocity[0, 2]).max()
        assert moved > 0.5  # it was hit
        assert np.abs(np.reshape(velocity, (-1, 3)) - answer.motion.velocity).max() < 1e-4 * moved
        # Networks and shapes are in single precision, 6e-8, and each of 125 steps adds to the motion.
        travelled = np.linalg.norm(answer.motion.displacement, axis=1).max()
        assert np.abs(np.reshape(centre, (-1, 3)) - answer.motion.centre).max() < 125 * 6e-8 * travelled
        truth = answer.motion.acceleration(60)[1][:, 2]
        assert np.abs(np.array(acceleration) - truth).max() < 1e-4 * np.abs(truth).max()
        for (value, low, high), name in zip(metrics, METRICS, strict=True):
            assert [value, low, high] == pytest.approx(
                [getattr(answer.injury[name], end) for end in ("value", "low", "high")], rel=1e-4
            )


def test_injury_metrics_of_the_same_motion_are_the_same_numbers(with_head):
    random = np.random.default_rng(5)
    times = np.linspace(0.0, 0.05, 501)
    velocity = np.cumsum(random.normal([0.0, 0.0, 0.06], 0.05, (501, 3)), axis=0)
    truth = metric_values(assess(times, velocity))
    found = with_head(
        "([times, velocity]) => page.metricValues(times, velocity)", [times.tolist(), velocity.ravel().tolist()]
    )
    assert found == pytest.approx(truth, rel=1e-9)


def test_a_slider_moves_by_keyboard_and_the_link_brings_the_design_back(opened):
    page = opened.page
    page.locator("#p1").focus()
    before = opened("page.sliders.values[1]")
    page.keyboard.press("ArrowRight")
    assert opened("page.sliders.values[1]") == pytest.approx(before + 300.0 / 400)
    page.locator("#time").focus()
    page.keyboard.press("End")
    assert opened("page.clock.time") == pytest.approx(0.05)
    link = page.url.partition("#")[2]
    assert f"temperature={before + 0.75}" in link
    asked = opened("page.sliders.values")
    opened("page.sliders.setAll([0.03, 600, 0.12]), page.clock.go(2)")
    opened("(link) => { location.hash = link; return new Promise((done) => setTimeout(done, 50)); }", link)
    assert opened("page.sliders.values") == pytest.approx(asked, rel=1e-8)
    assert opened("page.clock.time") == pytest.approx(0.05)


def test_a_slider_of_a_factor_stands_at_levels_only(open_page, place):
    gas = Parameter("gas", "Gas", "-", 0.0, 1.0, ("air", "argon"))
    made = made_surrogate(parameters=(PARAMETERS[0], gas))
    designs = made.designs * [1.0, 0.0] + np.outer(np.arange(len(made.designs)) % 2, [0.0, 1.0])
    opened = open_page(written(place, replace(made, designs=designs), "gases"))
    assert opened("page.sliders.values[1]") in (0, 1)
    for asked, level in ((0.4, 0), (0.6, 1)):
        opened(f"page.sliders.set(1, {asked})")
        assert opened("page.sliders.values[1]") == level
    opened.page.locator("#p1").focus()
    opened.page.keyboard.press("ArrowLeft")
    assert opened("page.sliders.values[1]") == 0
    assert opened.page.locator("#p1").get_attribute("aria-valuetext") == "air"
    assert "argon" in opened.page.locator("#sliders").inner_text()


@pytest.mark.parametrize(
    ("link", "temperature", "told"),
    [
        ("#temperature=9000&unknown=3&permeability=x&radius=&t=-1", 800.0, ""),
        ("#temperature=0x10&of=123456789abc", 500.0, "another surrogate"),
    ],
)
def test_a_hostile_link_stays_inside_the_ranges(opened, link, temperature, told):
    opened("page.sliders.setAll([0.03, 600, 0.12])")
    opened("(link) => { location.hash = link; return new Promise((done) => setTimeout(done, 50)); }", link)
    assert opened("page.sliders.values") == pytest.approx([0.03, temperature, 0.12])
    assert told in opened.page.locator("#told").inner_text()


def test_the_design_as_toml_is_a_design(opened):
    text = opened("page.toml()")
    assert tomllib.loads(text) == {
        "design": dict(
            zip((p.name for p in PARAMETERS), map(pytest.approx, opened("page.sliders.values")), strict=True)
        )
    }


def test_every_control_is_reached_by_keyboard_and_has_a_name(with_head):
    page = with_head.page
    visible = with_head("""() => [...document.querySelectorAll('input, select, button, canvas[tabindex]')]
        .filter((e) => !e.disabled && e.offsetParent !== null).map((e) => e.id || e.getAttribute('aria-label'))""")
    page.locator("body").click(position={"x": 2, "y": 2})
    reached = set()
    for _ in range(len(visible) + 5):
        page.keyboard.press("Tab")
        reached.add(with_head("document.activeElement.id || document.activeElement.getAttribute('aria-label')"))
    assert set(visible) <= reached
    nameless = with_head("""() => [...document.querySelectorAll('input, select, button, canvas')].filter((e) =>
        !(e.labels && e.labels.length) && !e.getAttribute('aria-label') && !e.textContent.trim()
        && !e.closest('.uplot') && !e.closest('.legend')).map((e) => e.outerHTML)""")
    assert nameless == []


def test_locked_obstacles_are_where_the_design_puts_them(open_page, place):
    head, box = HEAD, {"name": "box", "locked": True, "kind": "box", "half": [0.1, 0.2, 0.1], "edge": 0.0}
    box |= {"center": [0.0, 0.0, -0.2], "rotation": np.eye(3).tolist()}
    grows = LockedObstacle(box, np.column_stack([numbers_of(box), np.ones((16, 3))]))
    model = replace(made_surrogate(60, width=8), obstacles=(radius_of(head), LockedObstacle(box, fixed(box)), grows))
    page = open_page(written(place, model, "obstacles"))
    for design in DESIGNS[:3]:
        for k, obstacle in enumerate(model.obstacles[:2]):
            ask = "([k, design]) => Array.from(page.bodies[k].body.surface(design)[0])"
            points = np.reshape(page(ask, [k, design.tolist()]), (-1, 3))
            assert np.abs(outline(obstacle.at(design), points)).max() < 1e-5
            assert len(points) >= 8
    assert "changes with the design: box" in page.page.locator("#source").inner_text()


HEAD = {
    "name": "head", "locked": True, "kind": "super-ellipsoid", "radii": [0.1, 0.1, 0.1], "degree": 2.5,
    "center": [0.0, 0.1, 0.3], "rotation": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
}  # fmt: skip


def test_an_obstacle_without_a_shape_is_refused(place):
    wrong = HEAD | {"kind": "dragon"}
    model = replace(made_surrogate(60, width=8), obstacles=(LockedObstacle(wrong, fixed(wrong)),))
    path = model.save(place / "spoilt.safetensors")
    assert CliRunner().invoke(app, ["explore", str(path)]).exception.code == "E-ROM-004"


def fixed(described):
    return np.column_stack([numbers_of(described), np.zeros((len(numbers_of(described)), len(PARAMETERS)))])


def radius_of(described):
    """The obstacle, whose radii are the third parameter."""
    affine = fixed(described)
    affine[:3] = [0.0, 0.0, 0.0, 1.0]
    return LockedObstacle(described, affine)


def test_the_explorer_has_no_barriers(with_head):
    assert with_head.barriers() == []


def test_a_kept_design_is_compared_and_swapped(opened):
    page = opened.page
    opened("page.sliders.setAll([0.02, 600, 0.12])")
    page.locator("#keep").click()
    opened("page.sliders.setAll([0.03, 700, 0.18])")
    page.locator("#swap").click()
    assert opened("page.sliders.values") == pytest.approx([0.02, 600.0, 0.12])
    opened.until("document.querySelectorAll('#numbers thead th').length === 3")
    page.select_option("#field", "difference")
    assert "distance between A and B" in page.locator("#legend").inner_text()
    page.locator("#drop").click()
    assert page.locator("#field").input_value() == "displacement"


def test_the_bag_is_seen_and_a_slider_changes_it(opened):
    first = seen(opened, "page.sliders.setAll([0.02, 500, 0.1])")
    second = seen(opened, "page.sliders.setAll([0.035, 800, 0.2])")
    drawn = (np.abs(second.astype(int) - 255).max(axis=2) > 20).mean()
    assert 0.05 < drawn < 0.7
    assert (np.abs(first.astype(int) - second).max(axis=2) > 10).mean() > 0.005


def seen(opened, script):
    opened(script)
    opened("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return np.array(Image.open(io.BytesIO(opened.page.locator("#picture").screenshot())).convert("RGB"))


def test_without_webgl_curves_and_numbers_still_work(open_page, place, opened):
    page = open_page(
        place / "model.html",
        before="""const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return kind.startsWith('webgl') ? null : get.call(this, kind, ...more); };
        console.error = () => {};""",
    )
    assert page.page.locator("#nopicture").is_visible()
    page.until("document.querySelectorAll('#numbers tbody tr').length >= 4")


def test_it_works_inside_a_report(open_page, place, opened):
    """As the report of a study holds it: in a frame of the same file."""
    path = place / "report.html"
    inside = html.escape((place / "model.html").read_text(encoding="utf-8"))
    head = "<meta charset=utf-8><script>globalThis.ready = true</script>"
    path.write_text(f"{head}<iframe srcdoc='{inside}' width=1000 height=700></iframe>", encoding="utf-8")
    page = open_page(path)
    page.until("document.querySelector('iframe').contentWindow.ready === true")
    page("document.querySelector('iframe').contentWindow.page.sliders.set(0, 0.03)")
    assert "model.html" not in page.page.url


@pytest.mark.parametrize(("nodes", "megabytes", "of_loop"), [(1770, 1.5, 2.0), (10_000, 3.0, 8.0)])
def test_a_slider_move_is_fast_and_the_page_small(open_page, place, nodes, megabytes, of_loop):
    """Work without drawing. The limit is in milliseconds of a machine on which the loop takes one; measured in turn."""
    path = written(place, made_surrogate(nodes), f"nodes_{nodes}")
    assert path.stat().st_size < megabytes * 1e6
    page = open_page(path)
    moves, loops = page("""() => {
      page.picture.renderer = null; // drawing is the graphics card's work, which this machine does in software
      const moves = [], loops = [], x = new Float32Array(36 * 10000).fill(0.5);
      for (let k = 0; k < 60; k++) {
        page.sliders.values[0] = 0.02 + 0.00025 * k;
        moves.push(page.answer());
        const begun = performance.now();
        let sum = 0;
        for (let i = 0; i < 3 * x.length; i++) { sum += x[i % 360000] * 1.0001; x[i % 360000] = sum * 1e-9; }
        loops.push(performance.now() - begun);
      }
      return [moves, loops];
    }""")
    assert np.median(moves) / np.median(loops) < of_loop


def test_titles_are_text(open_page, place):
    title = "</script><img src=x onerror=alert(1)><!--<script>Ä ☃ \"'&"
    names = tuple(
        type(p)(p.name, title if k == 0 else p.label, "</b>" if k == 0 else p.unit, p.low, p.high)
        for k, p in enumerate(PARAMETERS)
    )
    page = open_page(written(place, made_surrogate(60, width=8, title=title, parameters=names), "hostile"))
    assert page.page.locator("h1").inner_text() == title
    assert page.page.locator("label[for=p0]").inner_text() == f"{title} [</b>]"
    assert page("document.querySelectorAll('img').length") == 0
    assert page.page.title() == f"{title}: explorer"


def test_a_single_parameter_and_an_open_mesh_work(open_page, place):
    one = made_surrogate(60, width=8, parameters=PARAMETERS[:1])
    page = open_page(written(place, replace(one, triangles=one.triangles[:-3], intervals=None, designs=None), "one"))
    assert page.page.locator("#sliders .slider").count() == 1
    assert "Volume" not in page.page.locator("#numbers").inner_text()
    assert "no intervals" in page.page.locator("#interval").inner_text()
    assert page.page.locator("#standing").inner_text() == ""


def test_a_surrogate_that_lost_is_shown_only_to_those_who_insist(place):
    made = made_surrogate(60, width=8)
    lost = replace(made.judgement, comparisons=(replace(made.judgement.comparisons[0], own=3.0),))
    path = replace(made, judgement=lost).save(place / "lost.safetensors")
    assert CliRunner().invoke(app, ["explore", str(path)]).exception.code == "E-ROM-023"
    assert CliRunner().invoke(app, ["explore", str(path), "--despite-verdict"]).exception is None
    assert re.search(r"explorer", path.with_suffix(".html").read_text()[:2000])
    assert Surrogate.load(path).judgement.lost
