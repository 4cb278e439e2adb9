"""A surrogate as named arrays and a record, and back again, with every shape and type checked on the way in."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np

from billow import __version__
from billow.base.errors import InputError, IntegrityError
from billow.results.dataset_files import parameter_of
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.learn.basis import Basis
from billow.rom.learn.force_inputs import ForceInputs
from billow.rom.surrogate.intervals import Intervals
from billow.rom.surrogate.regression import ACTIVATIONS, Regression
from billow.rom.surrogate.scaling import InputScaling, OutputScaling

FORMAT = 1


def write_surrogate(path: str | Path, surrogate) -> Path:
    """Write a `Surrogate` to `path`, atomically."""
    return write_tensors(path, *surrogate_content(surrogate))


def surrogate_content(surrogate) -> tuple[dict[str, np.ndarray], dict]:
    """A `Surrogate` as named arrays and a record. A file may hold more of both; `read_surrogate` passes over them."""
    regression = surrogate.regression
    tensors = {
        "times": surrogate.times,
        "reference": surrogate.reference,
        "triangles": surrogate.triangles,
        "modes": np.stack([basis.modes for basis in surrogate.bases]),
        "singular_values": np.stack([basis.singular_values for basis in surrogate.bases]),
        "energy": np.array([basis.energy for basis in surrogate.bases]),
        "outputs.mean": regression.outputs.mean,
        "outputs.deviation": regression.outputs.deviation,
    }
    tensors |= {f"weights.{layer}": array for layer, array in enumerate(regression.weights)}
    tensors |= {f"biases.{layer}": array for layer, array in enumerate(regression.biases)}
    forces = surrogate.forces
    if forces is not None:
        tensors |= {f"forces.{name}": getattr(forces, name) for name in ("modes", "mean", "deviation")}
        tensors["forces.components"] = np.array(forces.components)
    if surrogate.designs is not None:
        tensors["designs"] = surrogate.designs
    if surrogate.intervals is not None:
        tensors |= {f"intervals.{name}": array for name, array in vars(surrogate.intervals).items()}
    record = {
        "format": FORMAT,
        "title": surrogate.title,
        "recipe": surrogate.recipe,
        "parameters": [asdict(parameter) for parameter in surrogate.parameters],
        "training": surrogate.training,
    }
    return tensors, record


def read_surrogate(path: str | Path) -> dict:
    """The fields of the `Surrogate` in a file.

    Raises InputError E-ROM-005 if there is no such file or it has another format, IntegrityError E-ROM-004 if it is
    damaged or its arrays do not fit together.
    """
    path = Path(path)

    def damaged(why: str) -> IntegrityError:
        return IntegrityError(
            "E-ROM-004",
            "the surrogate file is damaged, cut short or not a surrogate",
            where=str(path),
            why=why,
            remedy="copy it again from where it came, or train it again: billow train FOLDER",
        )

    try:
        tensors, record = read_tensors(path, damaged)
    except OSError as error:
        raise InputError(
            "E-ROM-005",
            "the surrogate cannot be read",
            where=str(path),
            why=error.strerror or str(error),
            remedy="check the path, or train one: billow train FOLDER",
        ) from error
    if record.get("format") != FORMAT:
        raise InputError(
            "E-ROM-005",
            f"the surrogate has format {record.get('format')!r}",
            where=str(path),
            why=f"Billow {__version__} reads format {FORMAT}",
            remedy="use the version of Billow that wrote it, or train it again: billow train FOLDER",
        )
    try:
        return _fields(tensors, record)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise damaged(f"its parts do not fit together ({error})") from error


def _fields(tensors, record) -> dict:
    recipe = record["recipe"]
    if recipe not in ACTIVATIONS:
        raise ValueError(f"recipe {recipe!r}")
    title, training = record["title"], record["training"]
    if not isinstance(title, str) or not isinstance(training, dict) or not isinstance(training.get("runs"), list):
        raise ValueError("it does not say what it was trained on")
    parameters = tuple(map(parameter_of, record["parameters"]))
    low, high = (np.array([getattr(p, side) for p in parameters]) for side in ("low", "high"))
    if not (low < high).all():
        raise ValueError("a parameter has no range")
    times = _take(tensors, "times", np.float64, None)
    if len(times) < 2 or not (np.diff(times) > 0).all():
        raise ValueError("times do not rise")
    reference = _take(tensors, "reference", np.float32, None, 3)
    modes = _take(tensors, "modes", np.float32, 3, None, len(reference))
    singular_values = _take(tensors, "singular_values", np.float64, 3, None)
    energy = _take(tensors, "energy", np.float64, 3)
    triangles = _take(tensors, "triangles", np.int64, None, 3)
    if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(reference):
        raise ValueError("a triangle names a node that does not exist")

    forces = _forces(tensors, len(reference))
    further = 0 if forces is None else forces.width
    inputs = InputScaling(low, high, float(times[0]), float(times[-1]), recipe, further)
    count = 3 * modes.shape[1]  # coefficients of all components
    networks = None if recipe == "shared" else count
    weights, biases, width = [], [], inputs.width
    while f"weights.{len(weights)}" in tensors:
        weights.append(_take(tensors, f"weights.{len(weights)}", np.float32, networks, width, None))
        networks, _, width = weights[-1].shape
        biases.append(_take(tensors, f"biases.{len(biases)}", np.float32, networks, 1, width))
    if width != (count if recipe == "shared" else 1):
        raise ValueError(f"the last layer has {width} outputs")
    mean, deviation = (
        _take(tensors, f"outputs.{name}", np.float32, len(times), count) for name in ("mean", "deviation")
    )
    return {
        "title": title,
        "parameters": parameters,
        "times": times,
        "reference": reference,
        "triangles": triangles,
        "bases": tuple(Basis(modes[c], singular_values[c], float(energy[c])) for c in range(3)),
        "regression": Regression(recipe, tuple(weights), tuple(biases), inputs, OutputScaling(times, mean, deviation)),
        "training": training,
        "forces": forces,
        "designs": _take(tensors, "designs", np.float64, None, len(parameters)) if "designs" in tensors else None,
        "intervals": _intervals(tensors, len(times), len(reference)),
    }


def _intervals(tensors, times, nodes) -> Intervals | None:
    if "intervals.levels" not in tensors:
        return None
    levels = _take(tensors, "intervals.levels", np.float64, None)
    parts = [
        _take(tensors, f"intervals.{name}", np.float64, *shape)
        for name, shape in (("factors", (len(levels), 3)), ("lost_by_time", (3, times)), ("lost_by_node", (3, nodes)))
    ]
    if not all((part >= 0.0).all() for part in parts):
        raise ValueError("an interval has a negative width")
    return Intervals(levels, *parts)


def _forces(tensors, nodes) -> ForceInputs | None:
    if "forces.components" not in tensors:
        return None
    components = tuple(_take(tensors, "forces.components", np.int64, None).tolist())
    if not components or len(set(components)) != len(components) or not set(components) <= {0, 1, 2}:
        raise ValueError(f"force components {components}")
    modes = _take(tensors, "forces.modes", np.float32, len(components), None, nodes)
    mean, deviation = (_take(tensors, f"forces.{n}", np.float64, *modes.shape[:2]) for n in ("mean", "deviation"))
    if not (deviation > 0.0).all():
        raise ValueError("a force mode has no deviation")
    return ForceInputs(components, modes, mean, deviation)


def _take(tensors, name, dtype, *shape) -> np.ndarray:
    """An array of the given type and shape; None stands for any length. ValueError if it is not, or not finite."""
    array = tensors[name]
    fits = array.ndim == len(shape) and all(s in (None, n) for s, n in zip(shape, array.shape, strict=True))
    if array.dtype != dtype or not fits:
        raise ValueError(f"{name} is {array.dtype} {array.shape}, not {np.dtype(dtype)} {shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite")
    return array
