"""Nothing on a sheet overlaps, at any size, whatever people write."""

import itertools
import warnings

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from billow.pictures.camera import Camera
from billow.pictures.deployment import Colouring
from billow.pictures.fields import Field
from billow.pictures.sheet import Print, Sheet, length_text, on_white, one_line, printed, scale_length

TITLE = "Driver bag against a locked obstacle"
TITLES = (
    "Driver bag",
    "",
    "x" * 500,
    "$\\frac{",
    "</script><img onerror=1>",
    "日本 \N{CRYING FACE} \x00\x1b[31m\nnew line",
    "\u202eabc",
)
SIZES = ((1280, 960), (1600, 373), (320, 240), (4000, 3000), (500, 900))


def sheet_of(size, panels=1, has_bar=True, title=TITLE, high=2.5e5, name="gauge pressure", view="iso"):
    sheet = Sheet.fitting(*size, panels, has_bar, 1.3)
    camera = Camera.around([np.array([[-0.4, -0.4, 0.0], [0.4, 0.4, 0.5]])], view, *sheet.panel)
    field = Field(name, "Pa", True, np.array([[0.0, high]]))
    page = Print(sheet, camera, title, Colouring(field, 0.0, high) if has_bar else None)
    for panel in range(panels):
        page.show(panel, np.zeros((sheet.panel[1], sheet.panel[0], 4), np.float32), 0.0123 * panel)
    FigureCanvasAgg(page.figure).draw()
    return sheet, page


def boxes(page):
    """Every text and every picture on a sheet, and the colour bar."""
    figure = page.figure
    bar = [axes for axes in figure.axes if axes.axison]
    ticks = [text for axes in bar for text in axes.yaxis.get_ticklabels()]
    texts = [*(text for axes in figure.axes for text in axes.texts), *ticks]
    seen = [text for text in (*figure.texts, *texts) if text.get_text().strip() and text.get_visible()]
    # Numbers beyond the ends of the bar are not drawn.
    low, high = bar[0].get_ylim() if bar else (0.0, 0.0)
    found = {}
    for k, text in enumerate(seen):
        if text not in ticks or low <= text.get_position()[1] <= high:
            found[f"{k} {text.get_text()[:20]}"] = text.get_window_extent()
    for k, axes in enumerate(figure.axes):
        if axes.images:
            found[f"panel {k}"] = axes.get_window_extent()
    return found


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("panels", [1, 5])
@pytest.mark.parametrize(
    ("high", "view"), [(2.5e5, "iso"), (0.0, "front"), (1.0, "below"), (-4e9, "top"), (7.0, "side")]
)
def test_nothing_overlaps_and_nothing_leaves_the_sheet(size, panels, high, view):
    with printed():
        _, page = sheet_of(size, panels, high=high, view=view)
        found = boxes(page)
    for (one, a), (other, b) in itertools.combinations(found.items(), 2):
        wide, tall = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        letters = {one.split(" ")[-1], other.split(" ")[-1]} <= set("xyz")
        assert wide <= 1.0 or tall <= 1.0 or letters, f"{one} and {other}"
    for name, box in found.items():
        assert box.x0 >= -1.0, name
        assert box.x1 <= size[0] + 1.0, name
        assert box.y0 >= -1.0, name
        assert box.y1 <= size[1] + 1.0, name


@pytest.mark.parametrize("title", TITLES)
def test_any_title_can_be_drawn_and_fits(title):
    with warnings.catch_warnings(), printed():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        _, page = sheet_of((640, 480), title=title)
        head = page.figure.texts[0]
        assert head.get_window_extent().x1 < page.figure.texts[1].get_window_extent().x0
    assert "\n" not in head.get_text()


def test_a_name_of_a_field_that_is_long_is_shortened():
    with printed():
        sheet, page = sheet_of((640, 480), name="a_field_with_a_name_of_many_letters " * 3)
        assert page.figure.texts[-1].get_window_extent().width < 12.5 * sheet.letter


def test_every_pixel_of_a_picture_is_one_of_the_sheet():
    with printed():
        sheet, page = sheet_of((643, 487))
        random = np.random.default_rng(0).random((sheet.panel[1], sheet.panel[0], 4)).astype(np.float32)
        random[..., 3] = 1.0
        page.show(0, random, 0.0)
        canvas = FigureCanvasAgg(page.figure)
        canvas.draw()
        shown = np.asarray(canvas.buffer_rgba())[..., :3]
    left, top = round(0.8 * sheet.letter), round(2.0 * sheet.letter)
    np.testing.assert_array_equal(shown[top : top + sheet.panel[1], left : left + sheet.panel[0]], on_white(random))


@pytest.mark.parametrize(
    ("panels", "size", "grid"), [(5, (1600, 373), (1, 5)), (6, (1600, 900), (2, 3)), (4, (300, 1600), (4, 1))]
)
def test_panels_stand_where_they_are_largest(panels, size, grid):
    sheet = Sheet.fitting(*size, panels, True, 1.3)
    assert (sheet.rows, sheet.columns) == grid


@pytest.mark.parametrize(("longest", "length"), [(0.26, 0.2), (0.5, 0.5), (0.49, 0.2), (0.0012, 0.001), (3.0, 2.0)])
def test_scale_bars_have_round_lengths(longest, length):
    assert scale_length(longest) == pytest.approx(length)


def test_the_scale_bar_has_the_length_that_it_says():
    with printed():
        _, page = sheet_of((1280, 960))
        foot = next(axes for axes in page.figure.axes if axes.lines and not axes.images)
        drawn = np.ptp(foot.lines[0].get_xdata())
        text = foot.texts[0].get_text()
    assert text == length_text(drawn / page.camera.scale)


@pytest.mark.parametrize(("text", "line"), [("a\nb", "a b"), ("a\x00\x1bb", "a b"), ("x" * 300, "x" * 199 + "…")])
def test_texts_of_users_become_one_line(text, line):
    assert one_line(text) == line


@pytest.mark.parametrize("size", [(1600, 240), (1600, 410), (1600, 1600), (1280, 960)])
def test_letters_have_six_points_on_a_printed_page(size):
    sheet = Sheet.fitting(*size, 4, True, 1.3)
    assert sheet.letter / sheet.width * 180.0 / 25.4 * 72.0 >= 6.0
