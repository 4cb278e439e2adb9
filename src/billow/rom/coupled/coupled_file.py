"""A coupled model in one file: a surrogate file with one more block, so that the bag alone can be read from it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.errors import InputError
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

NOT_COUPLED = InputError.declare(
    "E-CPL-006",
    "the file holds no coupled model",
    where="{path}",
    cause="the file is a surrogate of the bag alone",
    remedy="make one: billow couple train FOLDER",
)

FORMAT = 1
STATE = 3 * len(REACHES) + 3


def coupled_content(coupled) -> tuple[dict[str, np.ndarray], dict]:
    """A `Coupled` as named arrays and a record."""
    tensors, record = surrogate_content(coupled.surrogate)
    law, outputs = coupled.law, coupled.law.regression.outputs
    block = {
        "times": coupled.times,
        "gravity": coupled.gravity,
        "affine": coupled.impactor.affine,
        "state_mean": law.mean,
        "state_deviation": law.deviation,
        "force_mean": outputs.mean,
        "force_deviation": outputs.deviation,
        **network_content(law.regression),
    }
    tensors |= {f"coupled.{name}": array for name, array in block.items()}
    return tensors, record | {"coupled": {"format": FORMAT, "name": coupled.impactor.name}}


def read_coupled(path: str | Path) -> dict:
    """The fields of the `Coupled` in a file.

    Raises InputError E-CPL-006 if the file holds a surrogate alone or a block of another format, and the errors of
    `read_checked`.
    """

    def fields(tensors, record) -> dict:
        surrogate, block = Surrogate(**surrogate_fields(tensors, record)), record.get("coupled")
        if not isinstance(block, dict) or block.get("format") != FORMAT:
            why = "it is a surrogate of the bag alone" if block is None else "its coupled part has another format"
            raise NOT_COUPLED(path=path, why=why)
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
