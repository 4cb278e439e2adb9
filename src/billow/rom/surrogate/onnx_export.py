"""Export of a whole surrogate, networks and modes, as one ONNX graph: a design in, the moving shape out.

    design        [parameters' units], (designs, parameters) float64
    displacement  [m], (designs, times, nodes, 3) float32, at the trained times

Parameters, times, title and the verdict on unseen runs travel as metadata. The graph does not refuse designs outside
the trained ranges: its user must. A file is written only after ONNX Runtime has given the same answers.
"""

from __future__ import annotations

import importlib
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from billow import __version__
from billow.base.errors import InputError, NumericalStop, ResourceError
from billow.results.atomic import write_atomically
from billow.rom.surrogate.clock import LARGEST, Clock
from billow.rom.surrogate.design_space import from_unit, levelled
from billow.rom.surrogate.regression import InputScaling, Regression
from billow.rom.surrogate.surrogate import Surrogate

OPSET, IR_VERSION = 17, 8
"""Of 2022; every runtime since reads them."""

TOLERANCE = 1e-5
"""Largest difference to NumPy's answer, over the largest displacement: [-]. Both work in float32 (6e-8)."""

NO_ONNX = ResourceError.declare(
    "E-ROM-016",
    "{package} is not installed",
    where="export",
    why="export needs it, and nothing else does",
    remedy="pip install onnx onnxruntime",
)
NEEDS_FORCES = InputError.declare(
    "E-ROM-019",
    "this surrogate cannot be exported",
    where="{title}",
    why="it takes contact forces of the previous time as inputs; the graph has only the design",
    remedy="export a surrogate trained without force modes",
)
EXPORT_DIFFERS = NumericalStop.declare(
    "E-ROM-020",
    "the exported model does not give the answers of the surrogate",
    where="{path}",
    why=f"answers differ by {{difference:.1e}} of the largest displacement, {TOLERANCE:.0e} is the limit",
    cause="a faulty version of ONNX Runtime, or a surrogate far beyond the range of float32",
    remedy="install another version of onnxruntime; no file was written",
)


def export_onnx(surrogate: Surrogate, path: str | Path) -> float:
    """Write `path`, atomically; returns the largest difference over the largest displacement, on eight random designs.

    Raises InputError E-ROM-023 if the surrogate lost against a simple answer, and nobody insisted.
    Raises ResourceError E-ROM-016 without onnx or onnxruntime, InputError E-ROM-019 for a surrogate with force inputs,
    NumericalStop E-ROM-020, and writes nothing, if ONNX Runtime's answers differ by more than `TOLERANCE`.
    """
    content = onnx_bytes(surrogate)
    unit = levelled(np.random.default_rng(0).random((8, len(surrogate.parameters))), surrogate.parameters)
    designs = from_unit(unit, surrogate.parameters)
    difference = largest_difference(content, surrogate, designs)
    if not difference <= TOLERANCE:
        raise EXPORT_DIFFERS(path=path, difference=difference)
    write_atomically(path, content)
    return difference


def largest_difference(content: bytes, surrogate: Surrogate, designs: np.ndarray) -> float:
    """Between ONNX Runtime and NumPy, over the largest displacement: [-]. designs: (designs, parameters)."""
    runtime = import_onnx("onnxruntime")
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = runtime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    worst = 0.0
    for design in designs:
        (answer,) = session.run(["displacement"], {"design": design[None]})
        known = surrogate.predict(design)
        worst = max(worst, float(np.abs(answer[0] - known).max() / max(np.abs(known).max(), 1e-30)))
    return worst


def import_onnx(name: str = "onnx"):
    """The package `onnx` or `onnxruntime`. ResourceError E-ROM-016 if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise NO_ONNX(package=name) from error


def onnx_bytes(surrogate: Surrogate) -> bytes:
    """The graph as the content of an .onnx file. Raises ResourceError E-ROM-016 without the package onnx, InputError
    E-ROM-019 for a surrogate with force inputs."""
    onnx = import_onnx()
    if surrogate.forces is not None:
        raise NEEDS_FORCES(title=surrogate.title)
    graph, regression, times, modes = _Graph(onnx), surrogate.regression, len(surrogate.times), surrogate.modes
    centred = _centred(graph, regression.inputs)
    if regression.clock is None:
        of_time, outputs = regression.of_trained_times[:, None], regression.outputs
        mean, deviation = outputs.mean, outputs.deviation
    else:
        common = _common_time(graph, regression.clock, len(surrogate.parameters), centred, surrogate.times)
        of_time, (mean, deviation) = _of_common_time(graph, regression, common), _scaling(graph, regression, common)
    hidden = _networks(graph, regression, centred, of_time)
    if surrogate.recipe == "shared":  # (networks, rows, outputs): the answer is their mean
        answer = graph.add("ReduceMean", hidden, axes=[0], keepdims=0)
    else:  # (outputs, rows, 1): one network for each coefficient
        answer = graph.add("Transpose", hidden, perm=[2, 1, 0])
    answer = graph.add("Reshape", answer, np.array([-1, times, 3 * modes]))
    answer = graph.add("Mul", answer, deviation)
    answer = graph.add("Add", answer, mean)
    answer = graph.add("Reshape", answer, np.array([-1, times, 3, modes]))
    answer = graph.add("Transpose", answer, perm=[0, 2, 1, 3])  # (designs, 3, times, modes)
    fields = graph.add("MatMul", answer, np.stack([basis.modes for basis in surrogate.bases]))
    graph.add("Transpose", fields, perm=[0, 2, 3, 1], output="displacement")
    return _model(onnx, graph, surrogate).SerializeToString()


class _Graph:
    """Nodes and constants under names of their own."""

    def __init__(self, onnx):
        self.onnx, self.nodes, self.constants = onnx, [], []

    def add(self, kind: str, *inputs: str | np.ndarray, output: str | None = None, **attributes) -> str:
        """Add a node and return the name of its output. inputs: names of other outputs, or constants."""
        names = [value if isinstance(value, str) else self._constant(value) for value in inputs]
        output = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(self.onnx.helper.make_node(kind, names, [output], **attributes))
        return output

    def _constant(self, array: np.ndarray) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(self.onnx.numpy_helper.from_array(np.asarray(array, order="C"), name))
        return name


def _centred(graph: _Graph, inputs: InputScaling) -> str:
    """The scaled design, (designs, parameters) float64: a slope of 1e6 N/m less its lower end would lose digits in
    float32."""
    zero, one = (inputs.design(bound) for bound in (inputs.low, inputs.high))
    factor = (one - zero) / (inputs.high - inputs.low)
    return graph.add("Add", graph.add("Mul", "design", factor), zero - factor * inputs.low)


def _common_time(graph: _Graph, clock: Clock, parameters: int, centred: str, times: np.ndarray) -> str:
    """As `Clock`: (designs, times) float64."""
    one, other = np.triu_indices(parameters)
    products = graph.add("Mul", *(graph.add("Gather", centred, index, axis=1) for index in (one, other)))
    polynomial = graph.add("MatMul", graph.add("Concat", centred, products, axis=1), clock.weights[1:])
    polynomial = graph.add("Add", polynomial, clock.weights[0])
    logarithms = graph.add("Clip", polynomial, np.array(-LARGEST), np.array(LARGEST))
    common = graph.add("MatMul", graph.add("Exp", logarithms), clock.spent(times))
    return graph.add("Clip", common, np.array(0.0), np.array(clock.latest))


def _of_common_time(graph: _Graph, regression: Regression, common: str) -> str:
    """Share of the time and the bias in the first layer: (networks, designs, times, neurons)."""
    inputs = regression.inputs
    unit = graph.add("Unsqueeze", graph.add("Div", common, np.array(inputs.end)), np.array([2]))
    angle = graph.add("Mul", unit, np.pi * np.array(inputs.frequencies, float))
    # Not every runtime has cosines of double precision, and angles up to 100 need it.
    waves = (graph.add("Sin", angle), graph.add("Sin", graph.add("Add", angle, np.array(0.5 * np.pi))))
    features = graph.add("Concat", unit, *waves, axis=2)
    features = graph.add("Cast", features, to=graph.onnx.TensorProto.FLOAT)  # (designs, times, features)
    share = graph.add("MatMul", features, regression.first_weights[1][:, None])
    return graph.add("Add", share, regression.biases[0][:, None])


def _scaling(graph: _Graph, regression: Regression, common: str) -> tuple[str, str]:
    """Mean and deviation at common times, as `OutputScaling.at`, whose times are even: (designs, times, outputs)."""
    outputs, kind = regression.outputs, graph.onnx.TensorProto
    spacing, last = outputs.times[1] - outputs.times[0], len(outputs.times) - 2
    place = graph.add("Div", common, np.array(spacing))
    before = graph.add("Clip", graph.add("Floor", place), np.array(0.0), np.array(float(last)))
    row = graph.add("Cast", before, to=kind.INT64)
    part = graph.add("Clip", graph.add("Sub", place, before), np.array(0.0), np.array(1.0))
    part = graph.add("Cast", graph.add("Unsqueeze", part, np.array([2])), to=kind.FLOAT)

    def at(values: np.ndarray) -> str:
        step = graph.add("Mul", graph.add("Gather", np.diff(values, axis=0), row, axis=0), part)
        return graph.add("Add", graph.add("Gather", values, row, axis=0), step)

    return at(outputs.mean), at(outputs.deviation)


def _networks(graph: _Graph, regression: Regression, centred: str, of_time: str | np.ndarray) -> str:
    """The networks side by side: (networks, designs * times, outputs). of_time: share of time in the first layer."""
    design = graph.add("Cast", centred, to=graph.onnx.TensorProto.FLOAT)
    # As in `Regression`, the first layer adds the shares of design and time; without a clock, that of the time is a
    # constant.
    of_design = graph.add("MatMul", design, regression.first_weights[0])  # (networks, designs, neurons)
    hidden = graph.add("Add", graph.add("Unsqueeze", of_design, np.array([2])), of_time)
    networks, _, neurons = regression.biases[0].shape
    hidden = graph.add("Reshape", hidden, np.array([networks, -1, neurons]))
    for weight, bias in zip(regression.weights[1:], regression.biases[1:], strict=True):
        if regression.recipe == "shared":
            hidden = graph.add("Mul", hidden, graph.add("Sigmoid", hidden))
        else:
            hidden = graph.add("Tanh", hidden)
        hidden = graph.add("Add", graph.add("MatMul", hidden, weight), bias)
    return hidden


def _model(onnx, graph: _Graph, surrogate: Surrogate):
    helper, kind = onnx.helper, onnx.TensorProto
    question = helper.make_tensor_value_info("design", kind.DOUBLE, ["designs", len(surrogate.parameters)])
    shape = ["designs", len(surrogate.times), surrogate.nodes, 3]
    answer = helper.make_tensor_value_info("displacement", kind.FLOAT, shape)
    made = helper.make_graph(graph.nodes, "surrogate", [question], [answer], graph.constants)
    opset = helper.make_opsetid("", OPSET)
    model = helper.make_model(
        made, opset_imports=[opset], ir_version=IR_VERSION, producer_name="billow", producer_version=__version__
    )
    parameters, times = [asdict(parameter) for parameter in surrogate.parameters], surrogate.times.tolist()
    told = {"title": surrogate.title, "parameters": json.dumps(parameters), "times_s": json.dumps(times)}
    if surrogate.judgement is not None:
        told["judgement"] = str(surrogate.judgement)
    helper.set_model_props(model, told | {"mesh_sha256": surrogate.training["mesh_sha256"]})
    onnx.checker.check_model(model)
    return model
