"""A real run folder of the smallest mesh, for tests of what reads run folders."""

from pathlib import Path

import numpy as np

from billow.results.atomic import publish_folder
from billow.results.histories import write_histories
from billow.results.run_file import write_run_file
from billow.results.vtkhdf import FabricWriter

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
TIMES = np.array([0.0, 0.01, 0.02])


def displacement(amount: float) -> np.ndarray:
    """(times, nodes, 3): every node rises by `amount` metres a frame."""
    return amount * np.arange(len(TIMES))[:, None, None] * np.array([0.0, 0.0, 1.0]) * np.ones((len(POINTS), 1))


def write_small_run(folder: Path, amount: float = 1.0, points=POINTS, times=TIMES, status="completed") -> Path:
    partial = folder.with_name(folder.name + ".partial")
    partial.mkdir(parents=True)
    (partial / "case.toml").write_text(f"amount = {amount}\n")
    with FabricWriter(partial / "fabric.vtkhdf", points, TRIANGLES, np.array([0, 1]), ["front", "rear"]) as fabric:
        for time, moved in zip(times, displacement(amount), strict=True):
            force = np.tile([time, 0.0, amount], (len(points), 1))
            fabric.append(
                time,
                points + moved,
                {"displacement": moved, "contact_force": force},
                {"gauge_pressure": [time, 2 * time]},
            )
    write_histories(partial / "histories.csv", {"time [s]": times, "pressure [Pa]": 3 * times})
    write_run_file(partial, {"status": status, "reason": None, "case_digest": "00", "wall_seconds": 2.5, "ledger": {}})
    publish_folder(partial, folder)
    return folder
