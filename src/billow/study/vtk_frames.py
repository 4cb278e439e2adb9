"""Points and triangles of one VTK file, without VTK: legacy .vtk, and XML .vtu and .vtp.

Quadrilaterals are cut into two triangles; other cells are refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.input_file import LARGEST_DATA, read_bytes
from billow.geometry.mesh_file import corners_of
from billow.geometry.vtk_legacy import read_legacy
from billow.geometry.vtk_xml import read_xml

SUFFIXES = (".vtk", ".vtu", ".vtp")


def read_vtk(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points (nodes, 3) float64, in the file's unit, and triangles (triangles, 3) int64, of one file.

    ValueError, with a sentence that says why, for anything else than the above.
    """
    content = read_bytes(path, LARGEST_DATA)
    try:
        grid = read_legacy(content) if path.suffix.lower() == ".vtk" else read_xml(content)
    except (IndexError, KeyError, AttributeError, TypeError, OverflowError):
        raise ValueError("it is cut short or not the VTK file that its name says") from None
    cells = corners_of(grid)
    quads = np.flatnonzero(cells[:, 3] >= 0)
    halves = cells[quads][:, [0, 2, 3]]
    order = np.argsort(np.concatenate([2 * np.arange(len(cells)), 2 * quads + 1]), kind="stable")
    return grid.points, np.concatenate([cells[:, :3], halves])[order]
