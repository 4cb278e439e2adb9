"""Cross-sections: the plane y = 0 through a triangle mesh and through the obstacles of a run."""

from __future__ import annotations

import numpy as np

from billow.geometry.shapes.kinds import from_description
from billow.geometry.shapes.pose import rotation_matrix
from billow.results.result import Result


def cut(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Where the plane y = 0 cuts a triangle mesh: [m], (segments, 2 ends, 2) as x and z.

    points: [m], (nodes, 3); triangles: (triangles, 3) int
    A node exactly on the plane counts as above it, so every cut triangle gives one segment, none is given twice, and
    a closed surface gives closed loops.
    """
    above = points[:, 1] >= 0.0
    side = above[triangles]
    crossed = triangles[side.any(axis=1) & ~side.all(axis=1)]
    edges = np.stack([crossed, np.roll(crossed, -1, axis=1)], axis=2)  # (triangles, 3 edges, 2 ends)
    ends = edges[above[edges[..., 0]] != above[edges[..., 1]]]  # two edges of each triangle, in order
    start, stop = points[ends[:, 0]].astype(float), points[ends[:, 1]].astype(float)
    part = (start[:, 1] / (start[:, 1] - stop[:, 1]))[:, None]
    return (start + part * (stop - start))[:, [0, 2]].reshape(-1, 2, 2)


def outline(obstacle: dict, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The function whose zero line is an obstacle's outline in the plane y = 0: [-], negative inside, shape of x and z.
    obstacle: as run.json describes it, a shape with "center" [m] (3,) and "rotation" (3, 3) from body to space."""
    space = np.stack([x, np.zeros_like(x), z], axis=-1) - np.asarray(obstacle["center"], float)
    return from_description(obstacle).level(space @ np.asarray(obstacle["rotation"], float))


def obstacles_at(result: Result, time: float) -> list[dict]:
    """The obstacles with an end, all but plates, of a finished run at a time [s], as `outline` takes them.

    The place of a locked one is in the run's record, that of a free one in its histories (nearest time). One whose
    place is not recorded is left out.
    """
    found = []
    for obstacle in result.record.get("obstacles", []):
        if not np.isfinite(from_description(obstacle).bound):
            continue
        if obstacle.get("locked", True):
            found.append(obstacle)
            continue
        body = result.histories.of(obstacle["name"])
        if "quaternion" in body:
            row = int(np.abs(result.histories.time - time).argmin())
            rotation = rotation_matrix(body.quaternion[row])
            found.append(obstacle | {"center": body.centre[row].tolist(), "rotation": rotation.tolist()})
    return found
