"""A coupled model in one file: a surrogate file with one more block, so that whoever wants the bag alone reads that."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.results.tensor_file import write_tensors
from billow.rom.coupled.contact_force import REACHES, ContactLaw
from billow.rom.coupled.impactor import PROPERTIES, ImpactorOfDesign
from billow.rom.surrogate.regression import Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling
from billow.rom.surrogate.surrogate import Surrogate
from billow.rom.surrogate.surrogate_file import (
    network_content,
    read_checked,
    surrogate_content,
    surrogate_fields,
    take,
    take_networks,
)

FORMAT = 1
STATE = 3 * len(REACHES) + 3


def write_coupled(path: str | Path, coupled) -> Path:
    """Write a `Coupled` to `path`, atomically."""
    tensors, record = surrogate_content(coupled.surrogate)
    law = coupled.law
    tensors |= {
        "coupled.times": coupled.times,
        "coupled.gravity": coupled.gravity,
        "coupled.affine": coupled.impactor.affine,
        "coupled.state_mean": law.mean,
        "coupled.state_deviation": law.deviation,
        "coupled.force_mean": law.regression.outputs.mean,
        "coupled.force_deviation": law.regression.outputs.deviation,
    }
    tensors |= network_content(law.regression, "coupled.")
    return write_tensors(path, tensors, record | {"coupled": {"format": FORMAT, "name": coupled.impactor.name}})


def read_coupled(path: str | Path) -> dict:
    """The fields of the `Coupled` in a file.

    Raises InputError E-CPL-006 if the file holds a surrogate alone or a block of another format, and the errors of
    `read_checked`.
    """

    def fields(tensors, record) -> dict:
        surrogate, block = Surrogate(**surrogate_fields(tensors, record)), record.get("coupled")
        if not isinstance(block, dict) or block.get("format") != FORMAT:
            raise InputError(
                "E-CPL-006",
                "the file holds no coupled model",
                where=str(path),
                why="it is a surrogate of the bag alone" if block is None else "its coupled part has another format",
                remedy="make one: billow couple train FOLDER",
            )
        return _fields(tensors, block, surrogate)

    return read_checked(path, fields, "billow couple train FOLDER")


def _fields(tensors, block, surrogate: Surrogate) -> dict:
    if not isinstance(block.get("name"), str):
        raise ValueError("the obstacle has no name")
    times = take(tensors, "coupled.times", np.float64, None)
    if len(times) < 2 or not (np.diff(times) > 0.0).all():
        raise ValueError("times do not rise")
    affine = take(tensors, "coupled.affine", np.float64, len(PROPERTIES), 1 + len(surrogate.parameters))
    mean, deviation = (take(tensors, f"coupled.state_{name}", np.float64, STATE) for name in ("mean", "deviation"))
    if not (deviation > 0.0).all():
        raise ValueError("a state has no deviation")
    of = surrogate.regression.inputs
    inputs = InputScaling(of.low, of.high, of.start, of.end, "shared", STATE)
    weights, biases, width = take_networks(tensors, "coupled.", None, inputs.width)
    if width != 3:
        raise ValueError(f"the force has {width} components")
    force = (take(tensors, f"coupled.force_{name}", np.float32, 2, 3) for name in ("mean", "deviation"))
    outputs = OutputScaling(np.array([of.start, of.end]), *force)
    return {
        "surrogate": surrogate,
        "impactor": ImpactorOfDesign(block["name"], affine),
        "law": ContactLaw(Regression("shared", weights, biases, inputs, outputs), mean, deviation),
        "times": times,
        "gravity": take(tensors, "coupled.gravity", np.float64, 3),
    }
