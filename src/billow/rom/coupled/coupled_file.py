"""A coupled model in one file: a surrogate file with one more block, so that whoever wants the bag alone reads that."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.errors import InputError, IntegrityError
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.coupled.contact_law import ContactLaw
from billow.rom.coupled.contact_reach import REACHES
from billow.rom.coupled.impactor_of_design import PROPERTIES, ImpactorOfDesign
from billow.rom.surrogate.regression import Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling
from billow.rom.surrogate.surrogate import Surrogate
from billow.rom.surrogate.surrogate_file import read_surrogate, surrogate_content

FORMAT = 1
STATE = 3 * len(REACHES) + 3


def write_coupled(path: str | Path, coupled) -> Path:
    """Write a `Coupled` to `path`, atomically."""
    tensors, record = surrogate_content(coupled.surrogate)
    law = coupled.law
    mean, deviation = law.regression.outputs.mean, law.regression.outputs.deviation
    tensors |= {
        "coupled.times": coupled.times,
        "coupled.gravity": coupled.gravity,
        "coupled.affine": coupled.impactor.affine,
        "coupled.state_mean": law.mean,
        "coupled.state_deviation": law.deviation,
        "coupled.force_mean": mean,
        "coupled.force_deviation": deviation,
    }
    tensors |= {f"coupled.weights.{layer}": array for layer, array in enumerate(law.regression.weights)}
    tensors |= {f"coupled.biases.{layer}": array for layer, array in enumerate(law.regression.biases)}
    return write_tensors(path, tensors, record | {"coupled": {"format": FORMAT, "name": coupled.impactor.name}})


def read_coupled(path: str | Path) -> dict:
    """The fields of the `Coupled` in a file.

    Raises InputError E-CPL-006 if the file holds a surrogate alone or a block of another format, and the errors of
    `read_surrogate`.
    """
    surrogate = Surrogate(**read_surrogate(path))

    def damaged(why: str) -> IntegrityError:
        return IntegrityError(
            "E-ROM-004",
            "the surrogate file is damaged, cut short or not a surrogate",
            where=str(path),
            why=why,
            remedy="copy it again from where it came, or train it again: billow couple train FOLDER",
        )

    tensors, record = read_tensors(path, damaged)
    block = record.get("coupled")
    if not isinstance(block, dict) or block.get("format") != FORMAT:
        raise InputError(
            "E-CPL-006",
            "the file holds no coupled model",
            where=str(path),
            why="it is a surrogate of the bag alone" if block is None else "its coupled part has another format",
            remedy="make one: billow couple train FOLDER",
        )
    try:
        return {"surrogate": surrogate, **_fields(tensors, block, surrogate)}
    except (KeyError, TypeError, ValueError) as error:
        raise damaged(f"its parts do not fit together ({error})") from error


def _fields(tensors, block, surrogate) -> dict:
    def take(name, dtype, *shape):
        array = tensors[f"coupled.{name}"]
        fits = array.ndim == len(shape) and all(s in (None, n) for s, n in zip(shape, array.shape, strict=True))
        if array.dtype != dtype or not fits or not np.isfinite(array).all():
            raise ValueError(
                f"coupled.{name} is {array.dtype} {array.shape}, not {np.dtype(dtype)} {shape}, or no number"
            )
        return array

    if not isinstance(block.get("name"), str):
        raise ValueError("the obstacle has no name")
    times = take("times", np.float64, None)
    if len(times) < 2 or not (np.diff(times) > 0.0).all():
        raise ValueError("times do not rise")
    affine = take("affine", np.float64, len(PROPERTIES), 1 + len(surrogate.parameters))
    mean, deviation = (take(f"state_{name}", np.float64, STATE) for name in ("mean", "deviation"))
    if not (deviation > 0.0).all():
        raise ValueError("a state has no deviation")
    of = surrogate.regression.inputs
    inputs = InputScaling(of.low, of.high, of.start, of.end, "shared", STATE)
    weights, biases, networks, width = [], [], None, inputs.width
    while f"coupled.weights.{len(weights)}" in tensors:
        weights.append(take(f"weights.{len(weights)}", np.float32, networks, width, None))
        networks, _, width = weights[-1].shape
        biases.append(take(f"biases.{len(biases)}", np.float32, networks, 1, width))
    if width != 3:
        raise ValueError(f"the force has {width} components")
    outputs = OutputScaling(
        np.array([of.start, of.end]),
        take("force_mean", np.float32, 2, 3),
        take("force_deviation", np.float32, 2, 3),
    )
    regression = Regression("shared", tuple(weights), tuple(biases), inputs, outputs)
    return {
        "impactor": ImpactorOfDesign(block["name"], affine),
        "law": ContactLaw(regression, mean, deviation),
        "times": times,
        "gravity": take("gravity", np.float64, 3),
    }
