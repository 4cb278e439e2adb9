"""From the journal of a run to the files ParaView opens: fabric.vtkhdf, gas.vtkhdf, particles.vtkhdf, straps.vtkhdf,
obstacles.vtkhdf, and scene.vtkhdf, which joins fabric, straps and obstacles.

A frame in the journal is a set of named arrays; their prefix says to which picture they belong: "point." and "cell." to
the fabric, "bar." to the straps, "cloud." to the gas in boxes, "lattice." to the gas in cells of a lattice, "particle."
to the particles.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from billow.geometry.surface import Surface
from billow.results import journal as journals
from billow.results.blocks import (
    BLOCKS,
    FABRIC,
    SCENE,
    STRAPS,
    StrapsWriter,
    write_obstacles,
    write_scene,
)
from billow.results.cloud import CloudWriter
from billow.results.gas_frames import GAS
from billow.results.histories import History
from billow.results.lattice import LatticeWriter, extents
from billow.results.vtkhdf import FabricWriter

PARTICLES = "particles.vtkhdf"


class Lines(NamedTuple):
    """Lines between nodes. bars: (bars, 2) node pairs; strap: (bars,), which of the straps `names` each belongs to."""

    bars: np.ndarray
    strap: np.ndarray
    names: tuple[str, ...]


def write_frames(
    folder: Path,
    journal: Path,
    start: np.ndarray,
    surface: Surface,
    lines: Lines,
    obstacles: Sequence[dict],
    histories: History,
) -> None:
    """Write the frames of a journal into `folder`; gas, particles, straps and obstacles only if there are any.

    start: positions at time zero [m], (nodes, 3). obstacles: as run.json describes them. Errors as `journal.frames`.
    """
    for name in (*BLOCKS.values(), SCENE, GAS, PARTICLES):
        (folder / name).unlink(missing_ok=True)  # of an earlier, interrupted part of the run
    with ExitStack() as files:
        writer = FabricWriter(folder / FABRIC, start, surface.triangles, surface.part, surface.part_names)
        fabric = files.enter_context(writer)
        straps = None
        if len(lines.bars):
            ends = np.arange(2 * len(lines.bars)).reshape(-1, 2)
            straps = files.enter_context(StrapsWriter(folder / STRAPS, ends, lines.strap, lines.names, "strap"))

        @cache
        def cloud(name: str) -> CloudWriter:
            return files.enter_context(CloudWriter(folder / name))

        @cache
        def images() -> LatticeWriter:
            cells = (fields["lattice"] for _, fields in _frames(journal) if fields["lattice"])
            names = surface.chambers.names
            return files.enter_context(LatticeWriter(folder / GAS, names, extents(cells, len(names))))

        for arrays, fields in _frames(journal):
            time = float(arrays["time"][0])
            if "positions" in arrays:
                fabric.append(time, arrays["positions"], fields["point"], fields["cell"])
                if straps is not None:
                    straps.append(time, arrays["positions"][lines.bars].reshape(-1, 3), fields["bar"])
            if box := fields["cloud"]:
                cloud(GAS).boxes(time, box.pop("centre"), box.pop("size"), box)
            if fields["lattice"]:
                images().append(time, fields["lattice"])
            if particle := fields["particle"]:
                cloud(PARTICLES).points(time, particle.pop("position"), particle)
    write_obstacles(folder, obstacles, histories)
    write_scene(folder)


def _frames(journal: Path) -> Iterator[tuple[dict[str, np.ndarray], dict[str, dict[str, np.ndarray]]]]:
    """The arrays of each frame, and likewise by picture and field."""
    for arrays in journals.frames(journal):
        fields = defaultdict(dict)
        for name, array in sorted(arrays.items()):  # as read, their order is no order
            picture, _, field = name.partition(".")
            fields[picture][field] = array
        yield arrays, fields
