"""Answers of a surrogate as text and as files, with how far they can be trusted."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.results.atomic import write_atomically
from billow.results.dataset_files import MeshParts
from billow.results.vtkhdf import FabricWriter
from billow.rom.surrogate.basis import by_axis
from billow.rom.surrogate.design_space import Standing, from_unit, levelled
from billow.rom.surrogate.judgement import Judgement, judgement_of
from billow.rom.surrogate.surrogate import Surrogate

FILE_EXISTS = InputError.declare(
    "E-CLI-004",
    "the file exists already",
    where="{path}",
    why="a prediction never overwrites a file",
    cause="a second prediction with the same --out",
    remedy="choose another name with --out, or delete this one",
)

LEVEL = 0.9
"""Of the intervals that are printed and written."""


def describe_surrogate(surrogate: Surrogate) -> str:
    """Parameters with their trained ranges, and a command to try."""
    lines = [repr(surrogate), f"times {surrogate.times[0]:g} to {surrogate.times[-1]:g} s; parameters:"]
    lines += [f"  {p.name:<24} {p.low:g} to {p.high:g} {p.unit}   {p.label}" for p in surrogate.parameters]
    half = levelled(np.full((1, len(surrogate.parameters)), 0.5), surrogate.parameters)
    middle = " ".join(
        f"--set {p.name}={value:g}"
        for p, value in zip(surrogate.parameters, from_unit(half, surrogate.parameters)[0], strict=True)
    )
    return "\n".join([*lines, f"try: billow predict SURROGATE {middle} --out deployment.vtkhdf"])


def write_prediction(surrogate: Surrogate, design: dict, out: Path | None, extrapolate: bool) -> str:
    """Predict one deployment with its trust; returns lines for the user.

    With `out` (.vtkhdf) it is written there, with the half width of its interval at every node if there is one, and its
    trust next to it, as OUT.json.
    Raises InputError of `Surrogate.predict`, E-CLI-004 if `out` or OUT.json exists.
    """
    for path in (out, out.parent / f"{out.name}.json") if out else ():
        if os.path.lexists(path):
            raise FILE_EXISTS(path=path)
    displacement = surrogate.predict(design, extrapolate=extrapolate)
    widths = surrogate.half_width(design, level=LEVEL, extrapolate=extrapolate) if surrogate.intervals else None
    top = displacement[..., 2].max(axis=1)
    summary = f"largest height {top.max():.4f} m at {1e3 * surrogate.times[top.argmax()]:.1f} ms"
    trust = trust_of(surrogate, design, widths)
    if out is not None:
        _write(surrogate, surrogate.start(design), displacement, widths, out)
        told = {"design": design, "largest_height_m": float(top.max()), **trust}
        write_atomically(out.parent / f"{out.name}.json", json.dumps(told, indent=1, allow_nan=False) + "\n")
        summary = f"{out}: {len(displacement)} frames, {summary}"
    return "\n".join([summary, *describe_trust(trust)])


def trust_of(surrogate: Surrogate, design: dict, widths: np.ndarray | None) -> dict:
    """Where a design stands, in range, distance and time, how far its answer may be off, and the verdict on unseen
    runs, as plain JSON. widths: [m], (times, nodes, 3), half widths of its intervals, None without."""
    interval = None
    if widths is not None:
        interval = {
            "level": LEVEL,
            "mean_half_width_m": by_axis(widths.mean(axis=(0, 1), dtype=float)),
            "largest_half_width_m": by_axis(widths.max(axis=(0, 1)).astype(float)),
        }
    return {
        "standing": standing_record(surrogate.standing(design)),
        "trained_times_s": surrogate.times[[0, -1]].tolist(),
        "stands_still_from_s": surrogate.stands_still(design),
        "interval": interval,
        "judgement": surrogate.judgement and surrogate.judgement.record(),
    }


def standing_record(found: Standing | None) -> dict | None:
    """Plain JSON."""
    if found is None:
        return None
    return {
        "outside_trained_range": list(found.outside),
        "distance_to_nearest_training_design": found.nearest,
        "usual_distance_between_training_designs": found.usual,
        "largest_distance_between_training_designs": found.largest,
        "warnings": found.warnings(),
    }


def describe_standing(standing: dict | None) -> list[str]:
    """Lines for people of what `standing_record` found."""
    if standing is None:
        return ["where the design lies among the trained ones is not known: the file does not hold them"]
    inside = "outside" if standing["outside_trained_range"] else "inside"
    nearest = standing["distance_to_nearest_training_design"]
    usual, largest = (standing[f"{what}_distance_between_training_designs"] for what in ("usual", "largest"))
    return [
        f"{inside} the trained ranges; nearest training design {nearest:.2f} away (they are {usual:.2f} "
        f"from each other on average, {largest:.2f} at most; every range counts as 1)",
        *(f"warning: {sentence}" for sentence in standing["warnings"]),
    ]


def describe_trust(trust: dict) -> list[str]:
    """Lines for people of what `trust_of` found."""
    start, end = (1e3 * time for time in trust["trained_times_s"])
    still = trust["stands_still_from_s"]
    beyond = [] if still is None else [f"warning: from {1e3 * still:g} ms on it stands still, for no run was as far"]
    lines = [
        *describe_standing(trust["standing"]),
        f"times {start:g} to {end:g} ms, all trained",
        *beyond,
        describe_judgement(judgement_of(trust["judgement"]), "billow evaluate STUDY"),
    ]
    interval = trust["interval"]
    if interval is None:
        return [*lines, "no interval: the surrogate was not calibrated"]
    widths = ", ".join(f"{axis} ± {1e3 * width:.2g} mm" for axis, width in interval["mean_half_width_m"].items())
    return [*lines, f"{100 * interval['level']:.0f} % of the solver's values expected within {widths} on average"]


def describe_judgement(judgement: Judgement | None, command: str) -> str:
    """A line for people. command: makes a judgement."""
    if judgement is None:
        return f"not judged: nobody knows whether it beats ignoring the design; find out: {command}"
    return f"warning: {judgement}" if judgement.lost else str(judgement)


def _write(surrogate, start, displacement, widths, out: Path) -> None:
    start = start.astype(float)
    parts = surrogate.parts or MeshParts(np.zeros(len(surrogate.triangles), np.int64), ("fabric",))
    with FabricWriter(out, start, surrogate.triangles, parts.part, parts.names) as frames:
        for step, (time, moved) in enumerate(zip(surrogate.times, displacement, strict=True)):
            half_width = {} if widths is None else {"half_width": widths[step]}
            frames.append(float(time), start + moved, {"displacement": moved, **half_width}, {})
