"""Obstacles of a run: where they are at a time, and their outlines and surfaces there.

An obstacle is what run.json says of it: a shape as `Shape.describe` tells it, with "name", "locked", "center" [m] (3,)
and "rotation" (3, 3) from its own axes to space.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from billow.geometry.shapes.kinds import from_description
from billow.geometry.shapes.pose import rotation_matrix
from billow.geometry.shapes.triangulated import FINENESS, triangulated
from billow.results.histories import History

PLACE = ("name", "locked", "center", "rotation")
"""What of a description is not the shape."""


def outline(obstacle: dict, points: np.ndarray) -> np.ndarray:
    """The function whose zero line is an obstacle's outline: [-], negative inside, at points [m] (..., 3) of any plane:
    (...)."""
    away = points - np.asarray(obstacle["center"], float)
    return from_description(obstacle).level(away @ np.asarray(obstacle["rotation"], float))


def has_end(obstacle: dict) -> bool:
    """Whether an obstacle has an end, as an impactor has and a plate has not."""
    return bool(np.isfinite(from_description(obstacle).bound))


def placed(obstacles: Iterable[dict], histories: History, time: float) -> list[dict]:
    """Obstacles, as they were at the start, where they are at a time [s].

    A locked one stays; the place of a free one is in the histories (nearest time). One whose place is not recorded is
    left out.
    """
    found = []
    for obstacle in obstacles:
        if obstacle.get("locked", True):
            found.append(obstacle)
            continue
        body = histories.of(obstacle["name"])
        if "quaternion" in body:
            row = int(np.abs(histories.time - time).argmin())
            turn = rotation_matrix(body.quaternion[row]) @ rotation_matrix(body.quaternion[0]).T
            centre = body.centre[row] + turn @ (np.asarray(obstacle["center"]) - body.centre[0])
            found.append(obstacle | {"center": centre.tolist(), "rotation": (turn @ obstacle["rotation"]).tolist()})
    return found


def obstacles_at(result, time: float) -> list[dict]:
    """The obstacles of a `Result` at a time [s], as `placed`."""
    obstacles = result.record.get("obstacles", [])
    stay = all(obstacle.get("locked", True) for obstacle in obstacles)  # runs made elsewhere may have no histories
    return list(obstacles) if stay else placed(obstacles, result.histories, time)


def surface(obstacle: dict, fineness: int = FINENESS) -> tuple[np.ndarray, np.ndarray]:
    """Points [m] (nodes, 3) in space and triangles (n, 3), outwards, of an obstacle that has an end."""
    shape = {name: value for name, value in obstacle.items() if name not in PLACE}
    own, triangles = _own(json.dumps(shape, sort_keys=True), fineness)
    return own @ np.asarray(obstacle["rotation"], float).T + np.asarray(obstacle["center"], float), triangles


@lru_cache(maxsize=64)
def _own(shape: str, fineness: int) -> tuple[np.ndarray, np.ndarray]:
    """As `triangulated`, of a described shape: each frame of a film asks again."""
    return triangulated(from_description(json.loads(shape)), fineness)
