"""Numbers of the ROM paper, to compare with ours ("Machine-Learning-Accelerated Simulations for the Design of
Airbag Constrained by Obstacles at Rest", Tables 2 to 5 and text)."""

from __future__ import annotations

from dataclasses import dataclass

MODES = 12
"""K of the paper's tables and cross-sections."""

EPOCHS = 15_000


@dataclass(frozen=True)
class PublishedCase:
    """One test case of the paper; all times [s].

    solver: one deployment; inference: evaluation of x, y and z; loading: of the models
    offline: N_DOE -> generation, POD, training of the networks
    hidden, rate: neurons of the hidden layers and learning rate of each network
    forces: whether its numbers are with the contact forces of the unseen run as inputs
    figures: its numbers of the figures that show RMSE against modes, distribution, break-even, sections
    tables: its numbers of the tables of inference and offline times
    """

    name: str
    heading: str
    solver: float
    inference: tuple[float, float, float]
    loading: float
    offline: dict[int, tuple[float, float, float]]
    hidden: tuple[int, ...]
    rate: float
    forces: bool
    figures: tuple[int, int, int, int]
    tables: tuple[int, int]


LOCKED = PublishedCase(
    name="locked",
    heading="Test case 1: locked flexible obstacle",
    solver=3930.0,
    inference=(0.29, 0.26, 0.27),
    loading=0.12,
    offline={100: (393e3, 93.0, 2376.0), 200: (786e3, 495.0, 3348.0), 400: (1572e3, 1254.0, 5832.0)},
    hidden=(25, 45, 15),
    rate=3e-4,
    forces=False,
    figures=(4, 5, 6, 11),
    tables=(2, 3),
)
FREE = PublishedCase(
    name="free",
    heading="Test case 2: free rigid obstacle",
    solver=3750.0,
    inference=(0.36, 0.33, 0.34),
    loading=0.08,
    offline={100: (375e3, 105.0, 3420.0), 200: (750e3, 492.0, 3960.0), 400: (1500e3, 1722.0, 6912.0)},
    hidden=(30, 40, 10),
    rate=1e-3,
    forces=True,
    figures=(9, 8, 10, 12),
    tables=(4, 5),
)
CASES = (LOCKED, FREE)
