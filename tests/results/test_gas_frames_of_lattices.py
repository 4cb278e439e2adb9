"""Images of a gas on a lattice, read back as boxes; and united where they are many."""

import numpy as np
import pytest

from billow.base.errors import IntegrityError
from billow.results.gas_frames import MOST_BOXES, GasFrames
from billow.results.lattice import LatticeWriter, extents

SIZE = 0.125


def frame(corners, chamber, k=0):
    """Cells with these lower corners; their volume fractions and fields differ."""
    n, some = len(corners), np.random.default_rng(k)
    return {
        "centre": np.float32((corners + 0.5) * SIZE - 1.0),
        "size": np.full((n, 3), SIZE, np.float32),
        "chamber": np.float32(chamber),
        "pressure": np.float32(some.uniform(1e5, 2e5, n)),
        "velocity": np.float32(some.normal(size=(n, 3))),
        "volume_fraction": np.float32(some.uniform(0.1, 1.0, n)),
    }


def written(path, frames, names=("front", "rear")):
    with LatticeWriter(path, names, extents(frames, len(names))) as images:
        for k, cells in enumerate(frames):
            images.append(0.1 * k, cells)
    return GasFrames(path)


def test_boxes_are_the_cells_that_are_shown_of_all_chambers(tmp_path):
    corners = np.array([(0, 0, 0), (3, 1, 0), (1, 2, 1), (7, 7, 7), (7, 8, 7)])
    frames = [frame(corners, [0, 0, 0, 1, 1]), frame(corners[1:4], [0, 0, 1], 1)]
    gas = written(tmp_path / "gas.vtkhdf", frames)
    assert gas.times == pytest.approx([0.0, 0.1])
    assert set(gas.fields) == {"pressure", "velocity", "volume_fraction"}
    for k, cells in enumerate(frames):
        boxes = gas.boxes(k)
        assert boxes.high - boxes.low == pytest.approx(np.full((len(boxes.low), 3), SIZE))
        at = {tuple(row): i for i, row in enumerate((0.5 * (boxes.low + boxes.high)).tolist())}
        order = [at[tuple(row)] for row in cells["centre"].tolist()]
        assert sorted(order) == list(range(len(boxes.low)))
        for name in gas.fields:
            np.testing.assert_array_equal(boxes.values[name][order], cells[name], err_msg=name)


def test_many_cells_are_united_and_hold_the_same_gas(tmp_path):
    """A ball of 57,000 cells needs two rounds; of the boxes, four cells a side, one is looked at."""
    grid = np.stack(np.meshgrid(*[np.arange(48)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = grid[((grid - 23.5) ** 2).sum(axis=1) < 24.0**2]
    cells = frame(corners, np.zeros(len(corners)))
    boxes = written(tmp_path / "gas.vtkhdf", [cells], ("bag",)).boxes(0)
    assert MOST_BOXES / 8 < len(boxes.low) <= MOST_BOXES
    assert boxes.high - boxes.low == pytest.approx(np.full((len(boxes.low), 3), 4 * SIZE))
    share, united = cells["volume_fraction"].astype(float), boxes.values["volume_fraction"].astype(float)
    assert 64.0 * united.sum() == pytest.approx(share.sum(), rel=1e-6)
    low = corners.min(axis=0)
    one = len(boxes.low) // 2
    inside = (cells["centre"] > boxes.low[one]).all(axis=1) & (cells["centre"] < boxes.high[one]).all(axis=1)
    assert inside.sum() > 8
    for name in ("pressure", "velocity"):
        mean = np.average(cells[name][inside], weights=share[inside], axis=0)
        assert boxes.values[name][one] == pytest.approx(mean, rel=1e-5)
    assert boxes.low.min(axis=0) == pytest.approx(low * SIZE - 1.0)


def test_an_image_of_another_shape_is_refused(tmp_path):
    import h5py

    path = tmp_path / "gas.vtkhdf"
    written(path, [frame(np.array([(0, 0, 0), (1, 0, 0)]), [0, 0])], ("bag",))
    with h5py.File(path, "r+") as file:
        file["VTKHDF/bag"].attrs["WholeExtent"] = [0, 3, 0, 1, 0, 1]
    with pytest.raises(IntegrityError, match="E-RES-007"):
        GasFrames(path).boxes(0)
