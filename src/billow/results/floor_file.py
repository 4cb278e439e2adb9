"""floor.json: how far runs of a study are off when they are made again with a change that means nothing, such as a
shorter step. No model that learns from one run of each design can be closer to another."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.errors import IntegrityError
from billow.base.input_file import read_text
from billow.results.atomic import write_atomically
from billow.results.csv_files import csv_text

DAMAGED = IntegrityError.declare(
    "E-RES-170",
    "the floor of the study cannot be read",
    where="{path}",
    cause="an edit by hand, a copy that was cut short, or a study that records other times by now",
    remedy="delete it, and measure it again: billow floor STUDY",
)
FLOOR_FILE, FLOOR_TABLE = "floor.json", "floor.csv"


@dataclass(frozen=True, eq=False)
class Floor:
    """changes: entry of the case -> how it was changed; runs: made twice; times: [s], (times,)

    rmse: [m], (runs, times, 3): root mean square over nodes of the difference of both runs, over the root of two. Two
    runs that scatter alike about their mean are that root farther from each other than each is from the mean, which is
    the best any model could answer.
    """

    changes: dict[str, str]
    runs: tuple[str, ...]
    times: np.ndarray
    rmse: np.ndarray

    @property
    def means(self) -> np.ndarray:
        """[m], (3,): of x, y and z, over runs and times."""
        return self.rmse.mean(axis=(0, 1))

    @property
    def distance(self) -> float:
        """[m]: root mean square distance of the nodes in a run, mean over runs, as a surrogate is judged by."""
        return float(np.sqrt(np.square(self.rmse).sum(axis=2).mean(axis=1)).mean())

    def write(self, folder: str | Path) -> None:
        """Write floor.json, and floor.csv: mean and largest of the runs against time."""
        record = {"changes": self.changes, "runs": list(self.runs), "times_s": self.times.tolist(),
                  "rmse_m": self.rmse.tolist()}  # fmt: skip
        write_atomically(Path(folder, FLOOR_FILE), json.dumps(record, allow_nan=False) + "\n")
        head = ["time [s]", *(f"{kind} {axis} [m]" for kind in ("mean", "largest") for axis in "xyz")]
        values = np.column_stack([self.times, self.rmse.mean(axis=0), self.rmse.max(axis=0)])
        write_atomically(Path(folder, FLOOR_TABLE), csv_text([head, *values.tolist()]))


def read_floor(folder: str | Path, times: np.ndarray) -> Floor | None:
    """The floor of the study in `folder`, None if nobody measured it; times: [s], those that the study records.
    IntegrityError E-RES-170."""
    path = Path(folder, FLOOR_FILE)
    if not path.is_file():
        return None
    try:
        record = json.loads(read_text(path))
        floor = Floor(dict(record["changes"]), tuple(map(str, record["runs"])), np.array(record["times_s"], float),
                      np.array(record["rmse_m"], float))  # fmt: skip
        if floor.rmse.shape != (len(floor.runs), len(floor.times), 3) or not len(floor.runs):
            raise ValueError("its parts do not fit together")
        if floor.times.shape != times.shape or not np.allclose(floor.times, times, rtol=1e-9, atol=1e-12):
            raise ValueError("its times are not those of the study")
        if not (np.isfinite(floor.rmse) & (floor.rmse >= 0.0)).all():
            raise ValueError("a number is not finite, or below zero")
        return floor
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise DAMAGED(path=path, why=error) from error
