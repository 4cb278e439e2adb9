"""A free obstacle by formula: a dome of fabric rises and pushes a body, whose motion follows from a simple force."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from scipy.stats import qmc
from synthetic import disc

from billow.results.dataset_files import Parameter
from billow.results.histories import History
from billow.rom.coupled.impactor import Impactor, area_vectors, node_area

PARAMETERS = (
    Parameter("pressure", "Pressure", "kPa", 10.0, 30.0),
    Parameter("radius", "Impactor radius", "m", 0.10, 0.20),
)
CLEARANCE, MASS = 0.10, 4.0


class FreeDataset:
    """Two parameters; force = pressure times the area vector of the nearest reach."""

    title = "Free synthetic obstacle"
    reference_length = 0.28
    parameters = PARAMETERS

    def __init__(self, train: int = 12, test: int = 3, nodes: int = 200):
        self.reference, self.triangles = disc(nodes)
        self.times = np.arange(1, 26) * 2e-3
        self.steps = np.arange(501) * 1e-4
        names = tuple(f"{run:04d}" for run in range(train + test))
        self.train, self.test, self.missing = names[:train], names[train:], {}
        self.trusted, self.left_out = self.train, {}
        low, high = (np.array([getattr(p, side) for p in PARAMETERS]) for side in ("low", "high"))
        unit = [qmc.LatinHypercube(2, rng=5 + part).random(n) for part, n in enumerate((train, test))]
        self._design = dict(zip(names, low + np.vstack(unit) * (high - low), strict=True))
        self._results = {run: self._simulate(*self._design[run]) for run in names}

    def design(self, runs):
        return np.array([self._design[run] for run in runs])

    def snapshots(self, field, runs):
        return np.stack([self._shape(self._design[run][0], self.times) for run in runs])

    def result(self, run):
        return self._results[run]

    def computing_seconds(self, runs):
        return np.full(len(runs), 4.0)

    def _shape(self, pressure, times):
        """Displacement: [m], (times, nodes, 3)."""
        r = np.linalg.norm(self.reference[:, :2], axis=1) / 0.36
        height = 0.22 * (1.0 - np.exp(-times / (0.2 / pressure)))
        shape = np.zeros((len(times), len(r), 3), np.float32)
        shape[:, :, 2] = height[:, None] * (1.0 - r**2)
        return shape

    def _simulate(self, pressure, radius):
        body = Impactor(np.full(3, radius), 3.0, np.array([0.0, 0.0, CLEARANCE + radius]), np.eye(3), MASS, np.zeros(3))
        shapes = self.reference + self._shape(pressure, self.steps)
        area, dt = node_area(self.reference, self.triangles), self.steps[1]
        centre, velocity, force = np.zeros((3, len(self.steps), 3))
        centre[0] = body.centre
        for k in range(len(self.steps)):
            if k:
                a = force[k - 1] / MASS
                velocity[k] = velocity[k - 1] + dt * a
                centre[k] = centre[k - 1] + dt * velocity[k - 1] + 0.5 * dt**2 * a
            force[k] = 1e3 * pressure * area_vectors(shapes[k], area, body, centre[k])[0]
        histories = {"time [s]": self.steps}
        for name, unit, vector in (("centre", "m", centre), ("velocity", "m/s", velocity), ("force", "N", force)):
            histories |= {f"head_{name}_{axis} [{unit}]": vector[:, k] for k, axis in enumerate("xyz")}
        return finished(histories, case(radius))


def finished(columns, effective_case):
    """A finished run as the coupled model reads it."""
    history = History(columns)
    return SimpleNamespace(histories=history, body=history.of, case_toml=effective_case, record={}, folder="RUN")


def case(radius, **changes):
    head = {
        "shape": "super-ellipsoid",
        "name": "head",
        "radii": radius,
        "degree": 3.0,
        "clearance": CLEARANCE,
        "offset": [0.0, 0.0],
        "angle_about_x": 0.0,
        "locked": False,
        "mass": MASS,
        "velocity": [0.0, 0.0, 0.0],
    }
    return {"obstacles": [{"shape": "plate", "name": "plate"}, head | changes], "run": {"gravity": [0.0, 0.0, 0.0]}}
