"""Chambers: volumes of rooms that share a wall, and how an open room is refused."""

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.surface import Surface, check_closed


def two_boxes(left: float = 1.0, right: float = 2.0, wall: bool = True) -> tuple[Surface, np.ndarray]:
    """Boxes of unit section and these lengths side by side, sharing one wall whose normal points from left to right."""
    x = np.repeat([-left, 0.0, right], 4)
    section = np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (3, 1)).astype(float)
    positions = np.column_stack([x, section])
    quads, behind, ahead = [], [], []
    for chamber, first in enumerate((0, 4)):
        for k in range(4):
            n = (k + 1) % 4
            quads.append([first + k, first + 4 + k, first + 4 + n, first + n])
            behind.append(chamber), ahead.append(OUTSIDE)
    quads += [[0, 1, 2, 3], [11, 10, 9, 8]]
    behind += [0, 1]
    ahead += [OUTSIDE, OUTSIDE]
    if wall:
        quads.append([7, 6, 5, 4])
        behind.append(0), ahead.append(1)
    quads = np.array(quads)
    triangles = np.concatenate([quads[:, [0, 2, 1]], quads[:, [0, 3, 2]]])
    sides = Chambers(("left", "right"), *(np.tile(np.array(s, np.int32), 2) for s in (behind, ahead)))
    return Surface.build(triangles, np.zeros(len(triangles)), ("wall",), 12, chambers=sides), positions


def test_volumes_of_rooms_that_share_a_wall():
    surface, positions = two_boxes(1.0, 2.0)
    check_closed(surface, positions, "boxes")
    moved = positions + np.array([10.0, -3.0, 5.0])
    for where in (positions, moved):
        volumes = surface.chambers.volumes(surface.triangles, where)
        np.testing.assert_allclose(volumes, [1.0, 2.0], rtol=1e-13)
    pushed = positions + np.where(positions[:, :1] == 0.0, [[0.25, 0.0, 0.0]], 0.0)
    np.testing.assert_allclose(surface.chambers.volumes(surface.triangles, pushed), [1.25, 1.75], rtol=1e-13)


def test_a_room_without_its_wall_is_refused_by_name():
    surface, positions = two_boxes(wall=False)
    with pytest.raises(InputError, match="E-GEO-001") as caught:
        check_closed(surface, positions, "boxes")
    assert "chamber left" in caught.value.where


def test_a_single_chamber_is_the_volume_of_the_surface():
    surface, positions = two_boxes()
    outer = surface.chambers.ahead == OUTSIDE
    shell = Surface.build(surface.triangles[outer], np.zeros(outer.sum()), ("wall",), 12)
    assert shell.chambers.volumes(shell.triangles, positions)[0] == pytest.approx(3.0, rel=1e-13)
    assert shell.volume(positions) == pytest.approx(3.0, rel=1e-13)
