"""Cross-sections: the plane y = 0 through a triangle mesh and through the obstacles of a run."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

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


def super_ellipsoid(obstacle: dict, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The function whose zero line is an obstacle's outline in the plane y = 0: [-], negative inside, shape of x and z.

    obstacle: "center" [m] (3,), "radii" [m] (3,), "degree" [-], "rotation" (3, 3) from body to space
    """
    space = np.stack([x, np.zeros_like(x), z], axis=-1) - np.asarray(obstacle["center"], float)
    body = space @ np.asarray(obstacle["rotation"], float)  # rotation transposed, from the left
    radii, degree = np.asarray(obstacle["radii"], float), float(obstacle["degree"])
    return (np.abs(body / radii) ** degree).sum(axis=-1) - 1.0


def obstacles_at(result: Result, time: float) -> list[dict]:
    """The super-ellipsoids of a finished run at a time [s], as `super_ellipsoid` takes them.

    The place of a locked one is in the run's record, that of a free one in its histories (nearest time). One whose
    place is not recorded is left out.
    """
    found = []
    for obstacle in result.record.get("obstacles", []):
        if obstacle.get("kind") != "super-ellipsoid":
            continue
        if obstacle.get("locked", True):
            found.append(obstacle)
        elif f"{obstacle['name']}_quaternion_w [-]" in result.histories:
            found.append(obstacle | _moved(result.histories, obstacle["name"], time))
    return found


def _moved(histories, name, time) -> dict:
    row = int(np.abs(histories["time [s]"] - time).argmin())
    centre = [histories[f"{name}_centre_{axis} [m]"][row] for axis in "xyz"]
    attitude = [histories[f"{name}_quaternion_{part} [-]"][row] for part in "xyzw"]  # SciPy has w last
    return {"center": centre, "rotation": Rotation.from_quat(attitude).as_matrix().tolist()}
