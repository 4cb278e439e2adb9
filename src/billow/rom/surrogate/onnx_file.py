"""Writing a surrogate as an .onnx file, after ONNX Runtime has given the same answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.errors import NumericalStop
from billow.results.atomic import write_atomically
from billow.rom.surrogate.onnx_graph import import_onnx, onnx_bytes
from billow.rom.surrogate.surrogate import Surrogate

TOLERANCE = 1e-5
"""Largest difference to NumPy's answer, over the largest displacement: [-]. Both work in float32 (6e-8)."""


def export_onnx(surrogate: Surrogate, path: str | Path, seed: int = 0) -> float:
    """Write `path`, atomically; returns the largest difference over the largest displacement, on eight random designs.

    Raises ResourceError E-ROM-016 without onnx or onnxruntime, InputError E-ROM-019 for a surrogate with force inputs,
    NumericalStop E-ROM-020, and writes nothing, if ONNX Runtime's answers differ by more than `TOLERANCE`.
    """
    content = onnx_bytes(surrogate)
    low, high = (np.array([getattr(p, side) for p in surrogate.parameters]) for side in ("low", "high"))
    designs = low + np.random.default_rng(seed).random((8, len(low))) * (high - low)
    difference = largest_difference(content, surrogate, designs)
    if not difference <= TOLERANCE:
        raise NumericalStop(
            "E-ROM-020",
            "the exported model does not answer as the surrogate",
            where=str(path),
            why=f"answers differ by {difference:.1e} of the largest displacement, {TOLERANCE:.0e} is the limit",
            remedy="install another version of onnxruntime; no file was written",
        )
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
