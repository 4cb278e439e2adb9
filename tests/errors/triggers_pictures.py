"""What cannot be drawn or compared."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from billow.apps.compare.sides import open_sides
from billow.cli.compare import compare as compare_command
from billow.cli.picture_files import picture_kind
from billow.pictures.curves import require_quantities
from billow.pictures.fields import read_field
from billow.pictures.film import mp4
from billow.pictures.section import parse_plane
from billow.pictures.shown_units import check_units
from billow.pictures.source import open_source
from billow.results.vtkhdf import FabricFile

BLACK = [np.zeros((4, 4, 3), np.uint8)]


def without_ffmpeg(here):
    here.patch.setenv("PATH", os.fspath(here.place))
    mp4(BLACK, 10.0, Path("film.mp4"))


def with_a_broken_ffmpeg(here):
    here.write("ffmpeg", "#!/bin/sh\nexit 1\n").chmod(0o755)
    without_ffmpeg(here)


def against_a_surrogate(here):
    table = here.write("test.csv", "time [s],force [N]\n0,1\n1,2\n")
    open_sides((table, here.bench.surrogate), ("test", "surrogate"), None)


def two_surrogates(here):
    open_sides((here.bench.surrogate, here.bench.surrogate), ("a", "b"), None)


def of_two_tests(here):
    for name in "ab":
        here.write(f"{name}.csv", f"time [s],{name} [N]\n0,1\n1,2\n")
    compare_command([here.place / "a.csv", here.place / "b.csv"])


def one_alone(here):
    compare_command([here.place / "a.csv"])


TRIGGERS = {
    "E-CMP-001": against_a_surrogate,
    "E-CMP-002": two_surrogates,
    "E-CMP-003": of_two_tests,
    "E-CMP-004": one_alone,
    "E-PIC-001": lambda here: parse_plane("y"),
    "E-PIC-002": lambda here: read_field(FabricFile(here.bench.run / "fabric.vtkhdf"), "presure"),
    "E-PIC-003": lambda here: check_units(["kpa"]),
    "E-PIC-004": without_ffmpeg,
    "E-PIC-005": with_a_broken_ffmpeg,
    "E-PIC-006": lambda here: open_source(here.write("notes.txt", "hello"), "plot"),
    "E-PIC-007": lambda here: open_source(here.write("test.csv", "time\n0\n"), "plot"),
    "E-PIC-008": lambda here: picture_kind(Path("picture.jpg"), "plot"),
    "E-PIC-009": lambda here: require_quantities(
        ["presure"], [open_source(here.bench.run, "plot").histories], here.place
    ),
}
