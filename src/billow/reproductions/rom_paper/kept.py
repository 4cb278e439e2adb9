"""Finished models, kept on disk: the same inputs get the same model at once."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from billow import __version__
from billow.base.errors import InputError, IntegrityError
from billow.results.atomic import write_atomically
from billow.results.dataset_files import mesh_sha256
from billow.rom.learn.clock import PARTS, STEPS
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.train import import_network

Model = TypeVar("Model")


class Kept:
    """A folder of models, each named after what it is and a digest of everything it was made from."""

    def __init__(self, folder: Path):
        self.folder = folder
        if not folder.exists():  # a folder of yours may have a .gitignore of its own
            folder.mkdir(parents=True)
            write_atomically(folder / ".gitignore", "*\n")  # large, and made again by the command that made them

    def path(self, name: str, inputs: dict) -> Path:
        """Where a model lies, or will. inputs: everything it depends on, plain JSON; the version of Billow is added."""
        text = json.dumps({"billow": __version__, **inputs}, sort_keys=True)
        return self.folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}.safetensors"

    def model(self, kind: type[Model], name: str, inputs: dict, make: Callable[[], Model]) -> Model:
        """A `Surrogate` or `Coupled`, read if it is there and whole, else made and saved."""
        path = self.path(name, inputs)
        with contextlib.suppress(InputError, IntegrityError):
            return kind.load(path)
        make().save(path)
        return kind.load(path)


def shared_settings() -> dict:
    """What the default recipe is at present, as plain JSON: models of other settings are not reused."""
    network = import_network()
    steps = [network.BATCH_SHARED, *network.EPOCHS_SHARED, network.STEPS_SHARED]
    clock = [PARTS, STEPS]
    return {"layers": [network.MEMBERS, *network.HIDDEN_SHARED], "steps": steps, "clock": clock}


def fingerprint(dataset: Dataset, runs) -> str:
    """SHA-256 of all that is learned from some runs of a dataset: axes, times, mesh, designs and the runs' files.

    Runs whose records carry no sum of their own (datasets in memory) are hashed by their displacements.
    """
    digest = hashlib.sha256(mesh_sha256(dataset.reference, dataset.triangles).encode())
    for part in (dataset.parameters, np.asarray(dataset.times, float).tolist()):
        digest.update(repr(part).encode())
    for run, row in zip(runs, dataset.design(runs), strict=True):
        digest.update(f"{run} {row.tolist()}".encode())
        known = dataset.result(run).record.get("record_sha256")
        digest.update(known.encode() if known else dataset.snapshots("displacement", [run]).tobytes())
    return digest.hexdigest()
