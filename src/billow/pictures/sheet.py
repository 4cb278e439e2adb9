"""The sheet a picture is printed on: panels side by side with their times, a colour bar, a scale, axes, a title.

Everything has a place of its own, reckoned from the size of the letters, so that nothing overlaps at any size. Texts of
users are drawn as they are: no mathematics, no control characters, shortened to what fits.
"""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, MaxNLocator

from billow.base.plot_style import GREY, INK, styled
from billow.pictures.camera import Camera
from billow.pictures.deployment import COLOURS, Colouring
from billow.pictures.shown_units import factor_of, shown_unit

POINTS = 9.5
"""Size of letters [pt]; how many pixels that is, is the sheet's resolution."""
LETTER, SMALLEST_LETTER = 0.0165, 12.0
"""Height of letters over the root of the sheet's area, and least height [pixels]."""
ON_PAPER = 1.0 / 85.0
"""Least height of letters over the sheet's width: 6 pt where it fills the 180 mm of a printed page."""
TITLE_LINES, FOOT_LINES, TIME_LINES, BAR_LETTERS, GAP = 2.0, 3.3, 1.7, 7.5, 0.8
"""Room for the title, for scale and axes, for the time above a panel, for the colour bar, and between things, in
heights of letters."""
BAR_SHARE = 0.6
"""Length of the colour bar over the height there is."""
SCALE_SHARE = 0.25
"""Longest scale bar over the width of a panel."""


@dataclass(frozen=True)
class Sheet:
    """Where everything goes. width, height: [pixels]. letter: height of letters [pixels]. rows, columns: of panels.
    panel: width and height of each [pixels]. has_bar: whether there is a colour bar. is_strip: whether each panel has a
    line for its time."""

    width: int
    height: int
    letter: float
    rows: int
    columns: int
    panel: tuple[int, int]
    has_bar: bool
    is_strip: bool

    @classmethod
    def fitting(cls, width: int, height: int, panels: int, has_bar: bool, aspect: float) -> Sheet:
        """The grid that shows `panels` pictures of an aspect, width over height, as large as they fit."""
        letter = max(SMALLEST_LETTER, LETTER * math.sqrt(width * height), ON_PAPER * width)
        best: Sheet | None = None
        for columns in range(1, panels + 1):
            rows = -(-panels // columns)
            made = cls._with(width, height, letter, rows, columns, has_bar, panels > 1)
            if best is None or made._shown(aspect) > best._shown(aspect):
                best = made
        return best

    @classmethod
    def _with(cls, width, height, letter, rows, columns, has_bar, is_strip) -> Sheet:
        wide = width - 2.0 * GAP * letter - (BAR_LETTERS * letter if has_bar else 0.0) - (columns - 1) * GAP * letter
        tall = height - (TITLE_LINES + FOOT_LINES) * letter - rows * (TIME_LINES * letter if is_strip else 0.0)
        panel = max(int(wide / columns), 16), max(int(tall / rows), 16)
        return cls(width, height, letter, rows, columns, panel, has_bar, is_strip)

    def _shown(self, aspect: float) -> float:
        """Size of a picture of an aspect in a panel."""
        return min(self.panel[0] / aspect, self.panel[1])

    def place(self, panel: int) -> tuple[float, float, float, float]:
        """Left, bottom, width, height of a panel as parts of the sheet."""
        row, column = divmod(panel, self.columns)
        line = TIME_LINES * self.letter if self.is_strip else 0.0
        left = (1 + column) * GAP * self.letter + column * self.panel[0]
        return self._part(left, TITLE_LINES * self.letter + row * (self.panel[1] + line) + line, *self.panel)

    def bar_place(self) -> tuple[float, float, float, float]:
        """Of the colour bar itself, without its numbers."""
        room = self.height - (TITLE_LINES + FOOT_LINES) * self.letter
        left, tall = self.width - (BAR_LETTERS - 1.2) * self.letter, BAR_SHARE * room
        return self._part(left, TITLE_LINES * self.letter + 0.5 * (room - tall), self.letter, tall)

    def _part(self, left: float, top: float, wide: float, tall: float) -> tuple[float, float, float, float]:
        """Parts of the sheet, from below, of a place in pixels, from above. It begins and ends at whole pixels, so that
        each pixel of a picture is one of the sheet."""
        left, top, wide, tall = round(left), round(top), round(wide), round(tall)
        return left / self.width, 1.0 - (top + tall) / self.height, wide / self.width, tall / self.height

    @property
    def resolution(self) -> float:
        """[pixels an inch] at which letters of `POINTS` have their height."""
        return 72.0 * self.letter / POINTS


@contextlib.contextmanager
def printed() -> Iterator[None]:
    """Where sheets are made and saved."""
    with styled(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a box stands for it
        matplotlib.rcParams.update({"text.parse_math": False, "font.size": POINTS, "axes.grid": False})
        yield


def one_line(text: str, most: int = 200) -> str:
    """A user's text as one line that can be drawn."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= most else line[: most - 1] + "…"


class Print:
    """A sheet with its figure. To be used within `printed`."""

    def __init__(
        self, sheet: Sheet, camera: Camera, title: str, colouring: Colouring | None, units: Sequence[str] = ()
    ):
        self.sheet, self.camera = sheet, camera
        inches = sheet.width / sheet.resolution, sheet.height / sheet.resolution
        self.figure = Figure(figsize=inches, dpi=sheet.resolution, facecolor="white")
        self._images, self._times = [], []
        for panel in range(sheet.rows * sheet.columns):
            axes = self.figure.add_axes(sheet.place(panel))
            axes.set_axis_off()
            self._images.append(axes)
        self._head(one_line(title))
        self._foot()
        if colouring is not None:
            self._bar(colouring, units)

    def show(self, panel: int, picture: np.ndarray, time: float) -> None:
        """Put a picture (height, width, 4) into a panel. time: [s]."""
        axes = self._images[panel]
        for old in (*axes.images, *axes.texts):
            old.remove()
        wide, tall = self.sheet.panel
        axes.imshow(on_white(picture), extent=(0, wide, tall, 0), interpolation="none", aspect="auto")
        label = f"{1e3 * time:.1f} ms"
        if self.sheet.is_strip:
            axes.text(0.0, 1.0, label, transform=axes.transAxes, va="bottom", weight="bold", color=INK)
        else:
            self._time.set_text(label)

    def _head(self, title: str) -> None:
        sheet = self.sheet
        middle = 1.0 - 0.5 * TITLE_LINES * sheet.letter / sheet.height
        left = GAP * sheet.letter / sheet.width
        head = self.figure.text(left, middle, title, weight="bold", va="center", ha="left", color=INK)
        self._time = self.figure.text(1.0 - left, middle, "", va="center", ha="right", color=INK)
        room = sheet.width * (1.0 - 2.0 * left) - (0 if sheet.is_strip else 6.0 * sheet.letter)
        shorten(head, room)

    def _foot(self) -> None:
        """A scale bar on the left, the axes of space on the right."""
        sheet, letter = self.sheet, self.sheet.letter
        length = scale_length(SCALE_SHARE * sheet.panel[0] / self.camera.scale)
        axes = self.figure.add_axes((0.0, 0.0, 1.0, FOOT_LINES * letter / sheet.height))
        axes.set(xlim=(0, sheet.width), ylim=(0, FOOT_LINES * letter))
        axes.set_axis_off()
        left, high, drawn = GAP * letter, 0.5 * FOOT_LINES * letter, length * self.camera.scale
        tick = 0.28 * letter
        axes.plot(
            [left, left, left, left + drawn, left + drawn, left + drawn],
            [high - tick, high + tick, high, high, high + tick, high - tick], color=INK, lw=1.3, solid_capstyle="butt",
        )  # fmt: skip
        axes.text(left + drawn + 0.5 * letter, high, length_text(length), va="center", ha="left", color=INK)
        self._triad(axes, sheet.width - 2.4 * letter, high)

    def _triad(self, axes, x: float, y: float) -> None:
        """Arrows of the axes of space as the camera sees them; one that points at the viewer is a dot."""
        long = 0.75 * self.sheet.letter
        for name, along in zip("xyz", self.camera.axes.T, strict=True):
            right, up, _ = along
            if math.hypot(right, up) < 0.05:
                axes.plot([x], [y], "o", ms=2.5, color=GREY)
                continue
            axes.plot([x, x + long * right], [y, y + long * up], color=GREY, lw=1.1, solid_capstyle="round")
            far = 1.0 + 0.55 / math.hypot(right, up)
            axes.text(
                x + long * right * far, y + long * up * far, name, color=GREY, ha="center", va="center",
                fontsize=0.8 * POINTS,
            )  # fmt: skip

    def _bar(self, colouring: Colouring, units: Sequence[str]) -> None:
        field = colouring.field
        unit = shown_unit(field.unit, max(abs(colouring.low), abs(colouring.high)), units)
        factor = factor_of(field.unit, unit)
        low, high = colouring.low / factor, colouring.high / factor
        if not high > low:
            high = low + max(abs(low), 1.0) * 1e-6
        axes = self.figure.add_axes(self.sheet.bar_place())
        lowest, highest = field.limits
        beyond = ("neither", "min", "max", "both")[(lowest < colouring.low) + 2 * (highest > colouring.high)]
        bar = self.figure.colorbar(
            ScalarMappable(Normalize(low, high), COLOURS), cax=axes, extend=beyond, extendfrac=0.03
        )
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=2.5, color=GREY)
        bar.ax.yaxis.set_major_locator(MaxNLocator(6))
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
        # Above the bar, so that its length sets no limit to the numbers beside it.
        _, bottom, _, tall = self.sheet.bar_place()
        letter = self.sheet.letter
        text = self.figure.text(
            1.0 - 0.5 * GAP * letter / self.sheet.width, bottom + tall + 1.0 * letter / self.sheet.height,
            f"{field.title}\n[{unit}]" if unit != "-" else field.title, ha="right", multialignment="right", color=INK,
        )  # fmt: skip
        shorten(text, (BAR_LETTERS + 4.0) * letter)


def on_white(picture: np.ndarray) -> np.ndarray:
    """Red, green, blue as bytes of a picture with its share of covered pixels, (height, width, 3)."""
    covered = picture[..., 3:]
    return np.round(255.0 * (picture[..., :3] * covered + 1.0 - covered)).astype(np.uint8)


def shorten(text: Text, room: float) -> None:
    """Shorten each line of a text until it has at most `room` pixels."""
    lines = text.get_text().split("\n")
    for k, line in enumerate(lines):
        text.set_text(line)
        while len(line) > 2 and (wide := text.get_window_extent().width) > room:
            letters = max(1, min(len(line) - 2, int(len(line) * room / wide) - 1))
            line = line[:letters].rstrip() + "…"
            text.set_text(line)
        lines[k] = line
    text.set_text("\n".join(lines))


def scale_length(longest: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is not longer than `longest`, both [m]."""
    power = 10.0 ** math.floor(math.log10(longest))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= longest * (1.0 + 1e-9))


def length_text(length: float) -> str:
    """A length [m] in the unit that reads best."""
    return f"{length:g} m" if length >= 1.0 else f"{1e3 * length:.4g} mm"
