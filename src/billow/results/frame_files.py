"""From the journal of a run to the files ParaView opens: fabric.vtkhdf, gas.vtkhdf, particles.vtkhdf.

A frame in the journal is a set of named arrays; their prefix says to which picture they belong: "point." and "cell." to
the fabric, "cloud." to the gas in boxes, "particle." to the particles.
"""

from __future__ import annotations

from collections import defaultdict
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import numpy as np

from billow.geometry.surface import Surface
from billow.results import journal as journals
from billow.results.cloud import CloudWriter
from billow.results.vtkhdf import FabricWriter

FABRIC, GAS, PARTICLES = "fabric.vtkhdf", "gas.vtkhdf", "particles.vtkhdf"


def write_frames(folder: Path, journal: Path, start: np.ndarray, surface: Surface) -> None:
    """Write the frames of a journal into `folder`; gas and particles only if there are any.

    start: positions at time zero [m], (nodes, 3). Errors as `journal.frames`.
    """
    for name in (FABRIC, GAS, PARTICLES):
        (folder / name).unlink(missing_ok=True)  # of an earlier, interrupted part of the run
    with ExitStack() as files:
        writer = FabricWriter(folder / FABRIC, start, surface.triangles, surface.part, surface.part_names)
        fabric = files.enter_context(writer)

        @cache
        def cloud(name: str) -> CloudWriter:
            return files.enter_context(CloudWriter(folder / name))

        for arrays in journals.frames(journal):
            time, fields = float(arrays["time"][0]), defaultdict(dict)
            for name, array in sorted(arrays.items()):  # as read, their order is no order
                picture, _, field = name.partition(".")
                fields[picture][field] = array
            if "positions" in arrays:
                fabric.append(time, arrays["positions"], fields["point"], fields["cell"])
            if box := fields["cloud"]:
                cloud(GAS).boxes(time, box.pop("centre"), box.pop("size"), box)
            if particle := fields["particle"]:
                cloud(PARTICLES).points(time, particle.pop("position"), particle)
