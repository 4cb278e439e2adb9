"""Small mesh files as other programs would write them."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np


def write_vtk(path: Path, points, cells, part, version: int = 3) -> Path:
    """VTK legacy text; cells: lists of 3 or 4 nodes."""
    lengths = [len(c) for c in cells]
    lines = [f"# vtk DataFile Version {version}.0", "a bag", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines += [f"POINTS {len(points)} double", *(" ".join(map(repr, map(float, p))) for p in points)]
    if version >= 5:
        offsets = np.concatenate([[0], np.cumsum(lengths)])
        lines += [f"CELLS {len(cells) + 1} {sum(lengths)}", "OFFSETS vtktypeint64", " ".join(map(str, offsets))]
        lines += ["CONNECTIVITY vtktypeint64", *(" ".join(map(str, c)) for c in cells)]
    else:
        lines += [f"CELLS {len(cells)} {sum(lengths) + len(cells)}"]
        lines += [f"{len(c)} {' '.join(map(str, c))}" for c in cells]
    lines += [f"CELL_TYPES {len(cells)}", *(str({3: 5, 4: 9, 2: 3}[n]) for n in lengths), f"CELL_DATA {len(cells)}"]
    if version >= 5:
        lines += ["FIELD FieldData 1", f"part 1 {len(cells)} int", " ".join(map(str, part))]
    else:
        lines += ["SCALARS part int 1", "LOOKUP_TABLE default", *map(str, part)]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_vtkhdf(path: Path, points, cells, part) -> Path:
    """VTKHDF without time steps."""
    with h5py.File(path, "w") as file:
        grid = file.create_group("VTKHDF")
        grid.attrs["Version"] = np.array([2, 2])
        grid.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        lengths = [len(c) for c in cells]
        grid["NumberOfPoints"], grid["NumberOfCells"] = [len(points)], [len(cells)]
        grid["NumberOfConnectivityIds"] = [sum(lengths)]
        grid["Points"] = np.asarray(points, float)
        grid["Connectivity"] = np.concatenate(cells).astype(np.int64)
        grid["Offsets"] = np.concatenate([[0], np.cumsum(lengths)])
        grid["Types"] = np.array([{3: 5, 4: 9, 2: 3}[n] for n in lengths], np.uint8)
        grid["CellData/part"] = np.asarray(part)
    return path


def pillow(n: int = 6, side: float = 0.3, height: float = 0.01):
    """A bag of two square panels of n x n quads sewn at the rim: points, cells, part (1 front, 2 rear), and the same
    cells on two flat pieces side by side, both seen from outside."""
    s = np.linspace(-0.5 * side, 0.5 * side, n + 1)
    x, y = (g.ravel() for g in np.meshgrid(s, s, indexing="ij"))
    rim = (np.abs(x) > 0.499 * side) | (np.abs(y) > 0.499 * side)
    dome = height * (1.0 - (2.0 * x / side) ** 2) * (1.0 - (2.0 * y / side) ** 2)
    quads = [[a, a + n + 1, a + n + 2, a + 1] for i in range(n) for a in range(i * (n + 1), i * (n + 1) + n)]
    rear = np.where(rim, np.arange(len(x)), len(x) + np.cumsum(~rim) - 1)
    points = np.concatenate([np.column_stack([x, y, dome]), np.column_stack([x, y, -dome])[~rim]])
    cells = quads + [rear[q[::-1]].tolist() for q in quads]
    flat = np.column_stack([x, y, np.zeros(len(x))])
    flat_points = np.concatenate([flat, flat * [-1.0, 1.0, 1.0] + [2.0 * side, 0.0, 0.0]])
    flat_cells = quads + [[v + len(x) for v in q[::-1]] for q in quads]
    return points, cells, [1] * n**2 + [2] * n**2, flat_points, flat_cells
