"""Where the obstacles of a run are at a time, for pictures."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def obstacles_at(result, time: float) -> list[dict]:
    """The super-ellipsoids of a finished run at a time [s], as `sections.super_ellipsoid` takes them.

    A locked one is where the run's record has it; a free one where its histories say (centre and attitude), nearest in
    time. One whose place is not recorded is left out.
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
