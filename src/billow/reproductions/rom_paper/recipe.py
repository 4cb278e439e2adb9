"""The paper's own recipe, to compare with ours: one network per mode, 15,000 epochs of all samples at once.

It takes an hour or more of processor time for one component at full size, so it saves its state and resumes.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.reproductions.rom_paper.kept import Kept
from billow.reproductions.rom_paper.nested_design import NestedDesign
from billow.reproductions.rom_paper.published import EPOCHS, MODES, PublishedCase
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.judge.errors import Summary
from billow.rom.learn.progress import Progress
from billow.rom.learn.train import import_network
from billow.rom.surrogate.basis import COMPONENTS
from billow.rom.surrogate.design_space import bounds
from billow.rom.surrogate.regression import InputScaling, OutputScaling, Regression

SAVE_EVERY = 30.0
"""[s] of wall time between two checkpoints."""


@dataclass(frozen=True, eq=False)
class RecipeFit:
    """The paper's networks of one component.

    component: "x", "y" or "z"; networks: one per mode; epochs
    rmse: [m], (runs, times) of unseen snapshots; cpu_seconds: [s] of training, all sittings together
    """

    component: str
    networks: int
    epochs: int
    rmse: np.ndarray
    cpu_seconds: float

    @property
    def summary(self) -> Summary:
        return Summary.of(self.rmse)


class _Sittings:
    """The checkpoint of `network.train_paper` in one file that also adds up the processor time of all sittings."""

    def __init__(self, path: Path):
        self.path, self.spent, self._begun, self._saved = path, 0.0, time.process_time(), time.monotonic()

    def due(self) -> bool:
        return time.monotonic() - self._saved >= SAVE_EVERY

    def save(self, epoch: int, arrays: dict[str, np.ndarray]) -> None:
        write_tensors(self.path, arrays, {"epoch": epoch, "cpu_seconds": self.cpu_seconds})
        self._saved = time.monotonic()

    def load(self) -> tuple[int, dict[str, np.ndarray]]:
        try:
            arrays, record = read_tensors(self.path, ValueError)
        except (OSError, ValueError):
            return 0, {}
        self.spent = record["cpu_seconds"]
        return record["epoch"], arrays

    @property
    def cpu_seconds(self) -> float:
        return self.spent + time.process_time() - self._begun


def paper_recipe(
    nested: NestedDesign,
    case: PublishedCase,
    component: str,
    kept: Kept,
    *,
    epochs: int = EPOCHS,
    progress: Progress | None = None,
) -> RecipeFit:
    """Train the paper's networks for the coefficients of one component and judge them on unseen runs.

    component: "x", "y" or "z". Errors as `train`.
    """
    index = COMPONENTS.index(component)
    reduction = nested.reduction.cut(min(MODES, nested.modes))
    known = reduction.coefficients[:, :, index]
    design, times, modes = reduction.design, reduction.times, known.shape[2]
    inputs = InputScaling(*bounds(nested.dataset.parameters), float(times[0]), float(times[-1]), "paper")
    outputs = OutputScaling.of(known[:, :, None], times, "paper")
    settings = nested.made_of | {"component": component, "epochs": epochs, "modes": modes, "case": case.name}
    sittings = _Sittings(kept.path("paper-recipe", settings))
    weights, biases = import_network().train_paper(
        inputs(design, times), outputs.forward(known).reshape(-1, modes), epochs=epochs, progress=progress,
        hidden=case.hidden, rate=case.rate, checkpoint=sittings,
    )  # fmt: skip
    spent = read_tensors(sittings.path, ValueError)[1]["cpu_seconds"]
    regression = Regression("paper", weights, biases, inputs, outputs)
    learned = regression(np.asarray(nested.dataset.design(nested.unseen), float), times)  # (runs, times, modes)
    seen = nested.projection(nested.reduction.bases)
    wrong = np.square(learned - seen.known[:, :, index, :modes], dtype=float).sum(axis=2) / seen.nodes
    rmse = np.sqrt(wrong + np.square(seen.truncation(modes)[:, :, index]))
    return RecipeFit(component, modes, epochs, rmse, spent)
