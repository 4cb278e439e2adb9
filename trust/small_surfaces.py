"""Response surfaces of made-up runs: known functions of two parameters and a factor, for tests of what is asked of
them."""

from __future__ import annotations

import numpy as np

from billow.design.surfaces import ResponseSurfaces
from billow.design.table import ResponseTable
from billow.results.dataset_files import Parameter
from billow.study.responses import StudyResponse

PARAMETERS = (
    Parameter("vent", "Vent diameter", "mm", 20.0, 50.0),
    Parameter("speed", "Speed", "m/s", 3.0, 7.0),
    Parameter("gas", "Gas", "-", 0.0, 1.0, ("nitrogen", "argon")),
)


def truth(designs: np.ndarray) -> np.ndarray:
    """Hardness, pressure, a contact that often never comes, and a constant: (designs, 4)."""
    vent, speed, gas = (designs[:, 0] - 20.0) / 30.0, (designs[:, 1] - 3.0) / 4.0, designs[:, 2]
    hard = 100.0 + 400.0 * speed**2 + 80.0 * (vent - 0.6) ** 2 + 30.0 * gas * speed
    pressure = 60.0 - 30.0 * vent + 5.0 * np.sin(3.0 * speed) + 4.0 * gas
    contact = np.where(vent > 0.6, 0.02 + 0.01 * speed, np.nan)
    return np.column_stack([hard, pressure, contact, np.full(len(designs), 7.0)])


def small_table(runs: int = 40, unseen: int = 10, noise: float = 0.0) -> ResponseTable:
    """Runs of a random design; noise: deviation of the pressure, a tenth of that of the hardness."""
    random = np.random.default_rng(3)
    designs = np.column_stack([random.uniform(20, 50, runs + unseen), random.uniform(3, 7, runs + unseen),
                               random.integers(0, 2, runs + unseen)])  # fmt: skip
    tables = [
        {"name": "hard", "measure": "hic15", "of": "head", "limit": {"below": 450.0}},
        {"name": "pressure", "measure": "peak", "quantity": "gauge_pressure", "unit": "kPa"},
        {"name": "contact", "measure": "first_contact", "of": "head"},
        {"name": "constant", "measure": "final", "quantity": "volume"},
    ]
    values = truth(designs)
    values[:, :2] += noise * random.standard_normal((len(values), 2)) * [10.0, 1.0]
    responses = tuple(map(StudyResponse.model_validate, tables))
    names = tuple(f"{k:04d}" for k in range(runs + unseen))
    return ResponseTable("Made up", PARAMETERS, responses, ("-", "kPa", "s", "m^3"), names, unseen, designs, values, {})


def small_surfaces(runs: int = 40) -> ResponseSurfaces:
    """Surfaces of `small_table`: of the first two responses, none of the others."""
    return ResponseSurfaces.learn(small_table(runs))
