"""Boxes in whole steps never part what overlaps, and part what lies more than a step apart."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.compiled import scalar
from billow.geometry.search_grid import SearchGrid
from billow.parts.gas.corpuscular.whole_steps import (
    SET_BITS,
    from_the_end,
    pack_boxes,
    packed,
    step_of,
    steps_per_metre,
)

N = 4000


@scalar
def _overlap(boxes, low, high, origin, per_metre, found_out):
    """Which of boxes (n, 2) overlap that from low to high [m], (n, 3)."""
    for t in range(len(boxes)):
        near = packed(
            step_of(low[t, 0], origin[0], per_metre), step_of(low[t, 1], origin[1], per_metre),
            step_of(low[t, 2], origin[2], per_metre),
        )  # fmt: skip
        far = from_the_end(
            step_of(high[t, 0], origin[0], per_metre), step_of(high[t, 1], origin[1], per_metre),
            step_of(high[t, 2], origin[2], per_metre),
        )  # fmt: skip
        found_out[t] = (boxes[t, 0] - near) & (boxes[t, 1] - far) & SET_BITS == SET_BITS


@pytest.mark.parametrize("beyond", [0.0, 0.5], ids=["in the grid", "and off it"])
def test_boxes_overlap_in_steps_where_they_do(beyond):
    rng = np.random.default_rng(5)
    triangles = np.arange(3 * N).reshape(N, 3)
    start = np.repeat(rng.uniform(-0.3, 0.4, (N, 3)), 3, axis=0) + rng.normal(0.0, 0.01, (3 * N, 3))
    end = start + rng.normal(0.0, 0.002, start.shape)
    grid = SearchGrid.build(triangles, start, end)
    both = np.concatenate([start.reshape(N, 3, 3), end.reshape(N, 3, 3)], axis=1)
    least, most = both.min(axis=1), both.max(axis=1)
    # Paths beside the boxes, some of them touching, some off the grid.
    low = least + rng.normal(0.0, 0.03, (N, 3)) + beyond * rng.choice([-1.0, 0.0, 1.0], (N, 3))
    low[: N // 4] = np.where(rng.random((N // 4, 3)) < 0.5, most[: N // 4], low[: N // 4])
    high = low + rng.exponential(0.02, (N, 3))
    boxes, found = np.empty((N, 2), np.uint64), np.empty(N, np.bool_)
    pack_boxes(N, triangles, start, end, grid.origin, steps_per_metre(grid), boxes)
    _overlap(boxes, low, high, grid.origin, steps_per_metre(grid), found)
    overlap = ((low <= most) & (high >= least)).all(axis=1)
    assert 100 < overlap.sum() < 0.9 * N
    assert found[overlap].all()
    step = 1.0 / steps_per_metre(grid) + 2e-9
    ends = grid.origin, grid.origin + grid.cell * grid.counts.max()
    inside = ((high > ends[0]) & (low < ends[1])).all(axis=1)
    apart = ((low > most + step) | (high < least - step)).any(axis=1)
    assert not found[apart & inside].any()
