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
from billow.rom.surrogate.design_space import from_unit
from billow.rom.surrogate.regression import Regression
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
    designs = from_unit(np.random.default_rng(0).random((8, len(surrogate.parameters))), surrogate.parameters)
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
    hidden = _networks(graph, regression)
    if surrogate.recipe == "shared":  # (networks, rows, outputs): the answer is their mean
        answer = graph.add("ReduceMean", hidden, axes=[0], keepdims=0)
    else:  # (outputs, rows, 1): one network for each coefficient
        answer = graph.add("Transpose", hidden, perm=[2, 1, 0])
    answer = graph.add("Reshape", answer, np.array([-1, times, 3 * modes]))
    answer = graph.add("Mul", answer, regression.outputs.deviation)
    answer = graph.add("Add", answer, regression.outputs.mean)
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
        self.constants.append(self.onnx.numpy_helper.from_array(np.ascontiguousarray(array), name))
        return name


def _networks(graph: _Graph, regression: Regression) -> str:
    """The networks side by side: (networks, designs * times, outputs)."""
    inputs = regression.inputs
    # Scaled in float64: a slope of 1e6 N/m less its lower end would lose digits in float32.
    zero, one = (inputs.design(bound) for bound in (inputs.low, inputs.high))
    factor = (one - zero) / (inputs.high - inputs.low)
    design = graph.add("Add", graph.add("Mul", "design", factor), zero - factor * inputs.low)
    design = graph.add("Cast", design, to=graph.onnx.TensorProto.FLOAT)
    # As in `Regression`, the first layer adds the shares of design and time, and that of the time is a constant.
    of_design = graph.add("MatMul", design, regression.first_weights[0])  # (networks, designs, neurons)
    hidden = graph.add("Add", graph.add("Unsqueeze", of_design, np.array([2])), regression.of_trained_times[:, None])
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
