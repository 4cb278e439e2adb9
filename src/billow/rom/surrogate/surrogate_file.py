"""A surrogate as named arrays and a record, and back again, with every shape and type checked on the way in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from billow import __version__
from billow.base.errors import InputError, IntegrityError
from billow.base.input_file import require_file
from billow.results.dataset_files import MeshParts, parameter_of
from billow.results.tensor_file import read_tensors
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.clock import Clock
from billow.rom.surrogate.design_space import bounds, has_range
from billow.rom.surrogate.force_inputs import ForceInputs
from billow.rom.surrogate.intervals import Intervals
from billow.rom.surrogate.judgement import judgement_of
from billow.rom.surrogate.locked_obstacles import MOST as MOST_OBSTACLES
from billow.rom.surrogate.locked_obstacles import LockedObstacle, numbers_of
from billow.rom.surrogate.polynomial import count as terms_of
from billow.rom.surrogate.regression import ACTIVATIONS, BY_CLOCK, FREQUENCIES, InputScaling, OutputScaling, Regression
from billow.rom.surrogate.start_shapes import StartShapes

DAMAGED = IntegrityError.declare(
    "E-ROM-004",
    "the surrogate file is damaged, cut short or not a surrogate",
    where="{path}",
    cause="a copy that was cut short, or a file of another program",
    remedy="copy it again from its source, or train it again: {command}",
)
UNREADABLE = InputError.declare(
    "E-ROM-005",
    "the surrogate cannot be read",
    where="{path}",
    cause="a misspelt path, or a file from a newer version of Billow",
    remedy="check the path, or train one: {command}",
)

FORMAT, WITH_CLOCK = 1, 2
"""Of a file without and with the clock of designs, which Billow before it would not apply."""

MOST_BYTES = 4 * 2**30
"""Of a file, and of one answer of the model in it: [byte]. Ten times the largest mesh and history in use."""
MOST_LAYERS = 64
LARGEST = 1e15
"""Any number in a file is smaller: larger ones are no lengths, forces, squares of them or weights, and overflow."""
LARGEST_TIME = 1e6
"""[s]"""
LEAST_INTERVAL = 1e-12
"""[s] between two times, and the part of its bounds that a range is at least wide: less is lost to rounding."""


def surrogate_content(surrogate) -> tuple[dict[str, np.ndarray], dict]:
    """A `Surrogate` as named arrays and a record. A file may hold more of both; `surrogate_fields` ignores it."""
    regression = surrogate.regression
    tensors = {name: getattr(surrogate, name) for name in ("times", "reference", "triangles")}
    for name in ("modes", "singular_values", "energy"):
        tensors[name] = np.stack([np.asarray(getattr(basis, name)) for basis in surrogate.bases])
    tensors |= network_content(regression)
    tensors |= {f"outputs.{name}": getattr(regression.outputs, name) for name in ("mean", "deviation")}
    if regression.clock is not None:
        tensors |= {"clock.weights": regression.clock.weights, "outputs.times": regression.outputs.times}
    if surrogate.forces is not None:
        tensors |= {f"forces.{name}": np.asarray(value) for name, value in vars(surrogate.forces).items()}
    if surrogate.designs is not None:
        tensors["designs"] = surrogate.designs
    if surrogate.intervals is not None:
        tensors |= {f"intervals.{name}": array for name, array in vars(surrogate.intervals).items()}
    if surrogate.starts is not None:
        tensors["start_weights"] = surrogate.starts.weights
    if surrogate.parts is not None:
        tensors["part"] = surrogate.parts.part
    for place, obstacle in enumerate(surrogate.obstacles):
        tensors[f"obstacles.{place}"] = obstacle.affine
    record = {
        "format": FORMAT if regression.clock is None else WITH_CLOCK,
        "title": surrogate.title,
        "recipe": surrogate.recipe,
        "parameters": [asdict(parameter) for parameter in surrogate.parameters],
        "training": surrogate.training,
        "judgement": surrogate.judgement and surrogate.judgement.record(),
        "part_names": None if surrogate.parts is None else list(surrogate.parts.names),
        "obstacles": [obstacle.like for obstacle in surrogate.obstacles],
    }
    return tensors, record


def network_content(regression: Regression) -> dict[str, np.ndarray]:
    """Weights and biases as named arrays, which `take_networks` reads."""
    return {f"{name}.{layer}": a for name in ("weights", "biases") for layer, a in enumerate(getattr(regression, name))}


def read_checked(path: str | Path, fields: Callable[[dict, dict], object], command: str):
    """What `fields(tensors, record)` makes of a file; it may raise ValueError, KeyError and the like.

    command: trains such a file again
    Raises InputError E-ROM-005 if there is no such file or it has another format, IntegrityError E-ROM-004 if it is
    damaged or its arrays do not fit together.
    """
    path = Path(path)

    def damaged(why: str) -> IntegrityError:
        return DAMAGED(path=path, why=why, command=command)

    try:
        require_file(path, MOST_BYTES)
        tensors, record = read_tensors(path, damaged)
    except OSError as error:
        raise UNREADABLE(path=path, why=error, command=command) from error
    if record.get("format") not in (FORMAT, WITH_CLOCK):
        raise UNREADABLE(
            what=f"the surrogate has format {record.get('format')!r}",
            path=path,
            why=f"Billow {__version__} reads formats {FORMAT} and {WITH_CLOCK}",
            remedy=f"use the version of Billow that wrote it, or train it again: {command}",
        )
    try:
        return fields(tensors, record)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError, RecursionError) as error:
        kinds = ((KeyError, f"{error} is missing"), (ValueError, str(error)), (Exception, "a value of another kind"))
        told = next(text for kind, text in kinds if isinstance(error, kind))
        raise damaged(f"its parts do not fit together ({told})") from error


def surrogate_fields(tensors: dict[str, np.ndarray], record: dict) -> dict:
    """The fields of a `Surrogate`. KeyError, TypeError, ValueError or IndexError if something does not fit."""
    recipe = record["recipe"]
    if recipe not in ACTIVATIONS:
        raise ValueError(f"recipe {recipe!r}")
    title, training = record["title"], _training(record["training"])
    if not isinstance(title, str) or not title.isprintable():
        raise ValueError("its title is no text in one line")
    parameters = tuple(map(parameter_of, record["parameters"]))
    low, high = bounds(parameters)
    if not len({parameter.name for parameter in parameters}) == len(parameters) > 0:
        raise ValueError("its parameters have no names of their own")
    if not has_range(low, high).all():
        raise ValueError("a parameter has no range")
    times = times_of(tensors, "times")
    reference = take(tensors, "reference", np.float32, None, 3)
    modes = take(tensors, "modes", np.float32, 3, None, len(reference))
    values, energy = take(tensors, "singular_values", np.float64, 3, None), take(tensors, "energy", np.float64, 3)
    triangles = take(tensors, "triangles", np.int64, None, 3)
    if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(reference):
        raise ValueError("a triangle names a node that does not exist")

    require_affordable(len(times) * reference.size)
    forces = _forces(tensors, len(reference))
    further = 0 if forces is None else forces.width
    clock, scaled = _clock(tensors, record, len(parameters), times)
    start, end = (float(times[0]), float(times[-1])) if clock is None else (0.0, clock.end)
    frequencies = FREQUENCIES if clock is None else BY_CLOCK
    inputs = InputScaling(low, high, start, end, recipe, further, frequencies)
    count = 3 * modes.shape[1]  # coefficients of all components
    weights, biases, width = take_networks(tensors, "", None if recipe == "shared" else count, inputs.width)
    require_affordable(len(times) * max(weight.shape[0] * weight.shape[2] for weight in weights))
    if width != (count if recipe == "shared" else 1):
        raise ValueError(f"the last layer has {width} outputs")
    mean, deviation = (take(tensors, f"outputs.{n}", np.float32, len(scaled), count) for n in ("mean", "deviation"))
    return {
        "title": title,
        "parameters": parameters,
        "times": times,
        "reference": reference,
        "triangles": triangles,
        "bases": tuple(map(Basis, modes, values, energy.tolist())),
        "regression": Regression(recipe, weights, biases, inputs, OutputScaling(scaled, mean, deviation), clock),
        "training": training,
        "forces": forces,
        "designs": take(tensors, "designs", np.float64, None, len(parameters)) if "designs" in tensors else None,
        "intervals": _intervals(tensors, len(times), len(reference)),
        "parts": _parts(tensors, record.get("part_names"), len(triangles)),
        "starts": _starts(tensors, len(parameters), len(reference)),
        "obstacles": _obstacles(tensors, record.get("obstacles", []), 0.5 * (low + high)),
        "judgement": judgement_of(record.get("judgement")),  # none in files of Billow before it judged
    }


def _clock(tensors, record: dict, parameters: int, times: np.ndarray) -> tuple[Clock | None, np.ndarray]:
    """The clock, and the times of the output scaling: [s]."""
    if (record["format"] == WITH_CLOCK) != ("clock.weights" in tensors):
        raise ValueError("its format does not say whether it has a clock")
    if "clock.weights" not in tensors:
        return None, times
    weights = take(tensors, "clock.weights", np.float64, terms_of(parameters, True), None)
    if record["recipe"] != "shared" or not times[-1] > 0.0:
        raise ValueError("its clock does not fit")
    scaled = times_of(tensors, "outputs.times")
    if not np.allclose(scaled, scaled[1] * np.arange(len(scaled)), atol=1e-9 * scaled[-1]):
        raise ValueError("times of its output scaling are not even")
    return Clock(weights, float(times[-1]), float(scaled[-1])), scaled


def _starts(tensors: dict[str, np.ndarray], parameters: int, nodes: int) -> StartShapes | None:
    if "start_weights" not in tensors:
        return None
    weights = take(tensors, "start_weights", np.float32, None, nodes, 3)
    if not StartShapes.fits(weights, parameters):
        raise ValueError("its start shapes have other parameters")
    return StartShapes(weights)


def _obstacles(tensors: dict[str, np.ndarray], told: list, design: np.ndarray) -> tuple[LockedObstacle, ...]:
    """design: in the middle of all."""
    if len(told) > MOST_OBSTACLES:
        raise ValueError("it has too many obstacles")
    found = []
    for place, like in enumerate(told):
        affine = take(tensors, f"obstacles.{place}", np.float64, len(numbers_of(like)), 1 + len(design))
        found.append(LockedObstacle(like, affine))
        found[-1].require_whole(design)
    return tuple(found)


def _training(told: object) -> dict:
    """How a surrogate was made, with every entry of the kind that evaluation expects."""
    runs, mesh = told["runs"], told["mesh_sha256"]
    if not all(isinstance(name, str) for name in (*runs, mesh)) or not runs or not isinstance(runs, list):
        raise ValueError("its training runs are missing")
    for name, value in told.items():
        if name in ("seed", "epochs") and not (type(value) is int and 0 <= value < 2**63):
            raise ValueError(f"{name} of its training is no count")
        if name.endswith("_seconds") and not (isinstance(value, int | float) and 0.0 <= value < LARGEST):
            raise ValueError(f"{name} of its training is no time")
    return told


def require_affordable(values: int) -> None:
    """ValueError if an answer, or a layer of its networks, has so many float32 values that it takes `MOST_BYTES`."""
    if 4 * values > MOST_BYTES:
        raise ValueError(f"an answer would take {4 * values / 2**30:.0f} GiB, more than {MOST_BYTES / 2**30:.0f}")


def _intervals(tensors, times, nodes) -> Intervals | None:
    if "intervals.levels" not in tensors:
        return None
    levels = take(tensors, "intervals.levels", np.float64, None)
    parts = [
        take(tensors, f"intervals.{name}", np.float64, *shape)
        for name, shape in (("factors", (len(levels), 3)), ("lost_by_time", (3, times)), ("lost_by_node", (3, nodes)))
    ]
    if not all((part >= 0.0).all() for part in parts):
        raise ValueError("an interval has a negative width")
    return Intervals(levels, *parts)


def _parts(tensors, names: object, triangles: int) -> MeshParts | None:
    if "part" not in tensors:  # a file of Billow before it kept them
        return None
    part = take(tensors, "part", np.int64, triangles)
    if not isinstance(names, list) or not all(isinstance(name, str) and name.isprintable() for name in names):
        raise ValueError("the names of its parts are no texts in one line")
    if not 0 <= part.min() <= part.max() < len(names):
        raise ValueError("a triangle belongs to a part that does not exist")
    return MeshParts(part, tuple(names))


def _forces(tensors, nodes) -> ForceInputs | None:
    if "forces.components" not in tensors:
        return None
    components = tuple(take(tensors, "forces.components", np.int64, None).tolist())
    if not components or len(set(components)) != len(components) or not set(components) <= {0, 1, 2}:
        raise ValueError(f"force components {components}")
    modes = take(tensors, "forces.modes", np.float32, len(components), None, nodes)
    mean, deviation = (take(tensors, f"forces.{n}", np.float64, *modes.shape[:2]) for n in ("mean", "deviation"))
    if not (deviation > 0.0).all():
        raise ValueError("a force mode has no deviation")
    return ForceInputs(components, modes, mean, deviation)


def take_networks(tensors, prefix: str, networks: int | None, width: int):
    """Weights and biases as `Regression` takes them, and the number of outputs. networks: None for any number."""
    weights, biases = [], []
    while f"{prefix}weights.{len(weights)}" in tensors:
        if len(weights) == MOST_LAYERS:
            raise ValueError(f"its networks have more than {MOST_LAYERS} layers")
        weights.append(take(tensors, f"{prefix}weights.{len(weights)}", np.float32, networks, width, None))
        networks, _, width = weights[-1].shape
        biases.append(take(tensors, f"{prefix}biases.{len(biases)}", np.float32, networks, 1, width))
    return tuple(weights), tuple(biases), width


def times_of(tensors, name: str) -> np.ndarray:
    """[s], (times,) float64. ValueError unless at least two rise."""
    times = take(tensors, name, np.float64, None)
    if not np.abs(times).max() <= LARGEST_TIME:
        raise ValueError(f"a time lies beyond {LARGEST_TIME:.0e} s")
    if len(times) < 2 or not (np.diff(times) > LEAST_INTERVAL).all():
        raise ValueError("times do not rise")
    return times


def take(tensors, name, dtype, *shape) -> np.ndarray:
    """An array of the given type and shape; None stands for any length but 0. ValueError if it is not, or if a value is
    not finite or beyond `LARGEST`."""
    array = tensors[name]
    if not array.size:
        raise ValueError(f"{name} is empty")
    fits = array.ndim == len(shape) and all(s in (None, n) for s, n in zip(shape, array.shape, strict=True))
    if array.dtype != dtype or not fits:
        raise ValueError(f"{name} is {array.dtype} {array.shape}, not {np.dtype(dtype)} {shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite")
    if array.dtype.kind == "f" and not np.abs(array).max() <= LARGEST:
        raise ValueError(f"{name} holds a value beyond {LARGEST:.0e}")
    return array
