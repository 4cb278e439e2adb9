"""A dataset made by formula: a bag that swells, rings and is dented by an obstacle. Fast, and hard enough to learn."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay
from scipy.stats import qmc

from billow.results.dataset_files import Parameter

PARAMETERS = (
    Parameter("permeability", "Airbag permeability", "-", 0.02, 0.035),
    Parameter("temperature", "Inflator temperature", "K", 500.0, 800.0),
    Parameter("jet", "Jet direction", "deg", 30.0, 60.0),
    Parameter("radius", "Impactor radius", "m", 0.1, 0.25),
    Parameter("degree", "Ellipsoid degree", "-", 2.0, 4.5),
    Parameter("slope", "Contact slope", "N/m", 1e3, 1e6),
)


def disc(nodes: int = 800, radius: float = 0.35):
    """A triangulated disc: [m], (nodes, 3) and (triangles, 3)."""
    turn = np.arange(nodes) * 2.399963  # golden angle: even, and no node lies on another
    flat = radius * np.sqrt(np.arange(nodes) / (nodes - 1))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.column_stack([flat, np.zeros(nodes)]).astype(np.float32), Delaunay(flat).simplices.astype(np.int64)


def deploy(reference: np.ndarray, times: np.ndarray, design: np.ndarray) -> np.ndarray:
    """Displacement of one design: [m], (times, nodes, 3) float32."""
    permeability, temperature, jet, radius, degree, slope = design
    x, y = reference[:, 0].astype(float), reference[:, 1].astype(float)
    r = np.hypot(x, y) / 0.36
    strength = np.sqrt(temperature / 650.0) * (1.0 - 12.0 * (permeability - 0.0275))
    filled = 1.0 - np.exp(-times / (8e-3 / strength))
    ring = 1.0 + 0.12 * np.sin(2.0 * np.pi * times / (0.018 * strength))
    height = (0.24 * strength * filled * ring)[:, None] * (1.0 - r**2) ** (0.3 + jet / 90.0)
    # The obstacle's lower side; fabric that reaches it is held back, softly or hard: a kink in space and time.
    inside = np.minimum(np.hypot(x, y) / radius, 1.0)
    obstacle = np.where(inside < 1.0, 0.12 + radius * (1.0 - (1.0 - inside**degree) ** (1.0 / degree)), 1.0)
    give = 2e3 / (2e3 + slope)
    z = np.where(height > obstacle, obstacle + give * (height - obstacle), height)
    inwards = -(4.0 * z.max(axis=1)[:, None] ** 2 * r + 6.0 * z**2)
    return np.stack([inwards * x, inwards * y, z], axis=-1).astype(np.float32)


class Result:
    def __init__(self, record):
        self.record = record


class SyntheticDataset:
    """What the reduced-order model uses of `billow.results.dataset.Dataset`."""

    title = "Synthetic bag"
    reference_length = 0.28
    parameters = PARAMETERS

    def __init__(self, train: int = 30, test: int = 6, times: int = 20, nodes: int = 800, seed: int = 1):
        self.reference, self.triangles = disc(nodes)
        self.times = np.linspace(0.0, 0.04, times)
        names = tuple(f"{run:04d}" for run in range(train + test))
        self.train, self.test, self.missing = names[:train], names[train:], {}
        self.trusted, self.left_out = self.train, {}
        low, high = (np.array([getattr(p, side) for p in PARAMETERS]) for side in ("low", "high"))
        unit = [qmc.LatinHypercube(6, rng=seed + part).random(n) for part, n in enumerate((train, test))]
        designs = low + np.vstack(unit) * (high - low)
        self._design = dict(zip(names, designs, strict=True))
        self.read: list[str] = []

    def design(self, runs):
        return np.array([self._design[run] for run in runs])

    def snapshots(self, field, runs):
        self.read += runs
        return np.stack([deploy(self.reference, self.times, self._design[run]) for run in runs])

    def computing_seconds(self, runs):
        return np.full(len(runs), 4.0)

    def result(self, run):
        radius, degree = self._design[run][3:5]
        obstacle = {
            "kind": "super-ellipsoid",
            "center": [0.0, 0.0, 0.12 + radius],
            "radii": [radius] * 3,
            "degree": degree,
            "rotation": np.eye(3).tolist(),
            "locked": True,
        }
        ledger = {"gas_mass_error": 2e-15, "gas_energy_error": 1e-14, "energy_residual_of_injected": 0.004}
        return Result({"ledger": ledger, "obstacles": [obstacle]})
