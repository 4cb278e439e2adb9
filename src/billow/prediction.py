"""Answers of a surrogate as text and as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.errors import InputError
from billow.results.vtkhdf import FabricWriter
from billow.rom.surrogate import Surrogate


def describe_surrogate(surrogate: Surrogate) -> str:
    """Parameters with their trained ranges, and a command to try."""
    lines = [repr(surrogate), f"times {surrogate.times[0]:g} to {surrogate.times[-1]:g} s; parameters:"]
    lines += [f"  {p.name:<24} {p.low:g} to {p.high:g} {p.unit}   {p.label}" for p in surrogate.parameters]
    middle = " ".join(f"--set {p.name}={0.5 * (p.low + p.high):g}" for p in surrogate.parameters)
    return "\n".join([*lines, f"try: billow predict SURROGATE {middle} --out deployment.vtkhdf"])


def write_prediction(surrogate: Surrogate, design: dict, out: Path | None, extrapolate: bool) -> str:
    """Predict one deployment; write it to `out` (.vtkhdf) if given; returns a line for the user.

    Raises InputError of `Surrogate.predict`, E-CLI-004 if `out` exists.
    """
    displacement = surrogate.predict(design, extrapolate=extrapolate)
    top = displacement[..., 2].max(axis=1)
    summary = f"largest height {top.max():.4f} m at {1e3 * surrogate.times[top.argmax()]:.1f} ms"
    if out is None:
        return summary
    if out.exists():
        raise InputError(
            "E-CLI-004",
            "the file exists already",
            where=str(out),
            why="a prediction never overwrites a file",
            remedy="choose another name with --out, or delete this one",
        )
    start = np.asarray(surrogate.reference, dtype=float)
    partial = out.with_name(out.name + ".partial")
    part = np.zeros(len(surrogate.triangles), dtype=np.int32)
    with FabricWriter(partial, start, surrogate.triangles, part, ["fabric"]) as frames:
        for time, moved in zip(surrogate.times, displacement, strict=True):
            frames.append(float(time), start + moved, {"displacement": moved}, {})
    partial.replace(out)
    return f"{out}: {len(displacement)} frames, {summary}"
