"""How far a side is from the reference: peaks and ends of curves with their ISO/TS 18571 rating, shapes and injury
metrics.

Differences are the side minus the reference, ratings take the reference as the test.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from billow.apps.compare.side import Side
from billow.base.errors import InputError
from billow.injury.criteria import Injury, assess, assess_acceleration
from billow.injury.filters import SAMPLED_TOO_SLOWLY, UNUSABLE_CURVE
from billow.injury.rating import UNUSABLE_REFERENCE, Rating, rate
from billow.pictures.curves import ACCELERATION, AXES, VELOCITY, Curve, curve_of, quantities
from billow.results.histories import History

NOTHING_IN_COMMON = InputError.declare(
    "E-CMP-003",
    "the two have nothing in common to compare",
    where="{first} and {second}",
    why="no quantity is in both, and they are not both bags",
    cause="a table of a test whose columns have other names than those of a run",
    remedy="name the columns of the table as docs/histories.md names those of runs, for example "
    "impactor_acceleration_z [g]",
)

MOST_SAMPLES = 100_000
"""Of curves that are rated."""
SAME_TIME = 1e-6
"""[s] by which frames may differ and still be of one time."""


@dataclass(frozen=True)
class CurveDifference:
    """One quantity on both sides. rating: of the first against the second; None without one, and why_not."""

    name: str
    first: Curve
    second: Curve
    rating: Rating | None
    why_not: str = ""

    def record(self) -> dict:
        """Plain JSON, in SI."""
        found = {"quantity": self.name, "unit": self.first.unit}
        for side, curve in (("first", self.first), ("second", self.second)):
            value, time = curve.peak
            found[side] = {"peak": plain(value), "peak_time": plain(time), "end": plain(curve.end)}
        rated = self.rating and asdict(self.rating) | {"overall": self.rating.overall, "grade": self.rating.grade}
        return found | {"iso_18571": rated}


@dataclass(frozen=True)
class ShapeDifference:
    """Of one time [s]: distances between the same nodes [m], root mean square and largest."""

    time: float
    rms: float
    largest: float


@dataclass(frozen=True)
class Comparison:
    """A side against the reference."""

    side: Side
    reference: Side
    curves: Sequence[CurveDifference]
    shapes: Sequence[ShapeDifference]


def compare_sides(first: Side, second: Side, names: Sequence[str], channel_class: int | None) -> Comparison:
    """A side against the reference. InputError E-CMP-003 if there is neither a curve that both have nor a bag on both
    sides; errors as `curve_of`."""
    curves = compare_curves(first, second, names, channel_class)
    if not curves and (first.fabric is None or second.fabric is None):
        raise NOTHING_IN_COMMON(first=first.source.path, second=second.source.path)
    return Comparison(first, second, curves, compare_shapes(first, second))


def compare_curves(first: Side, second: Side, names: Sequence[str], channel_class: int | None) -> list[CurveDifference]:
    """Differences of the quantities that both have. Errors as `curve_of`."""
    found = []
    for name in names if first.curves is not None and second.curves is not None else ():
        one, other = (curve_of(side.curves, name, channel_class) for side in (first, second))
        if one is not None and other is not None:
            found.append(CurveDifference(name, one, other, *rated(one, other)))
    return found


def rated(one: Curve, other: Curve) -> tuple[Rating | None, str]:
    """Rating of a curve against another over the time both have; None and why if it cannot be rated."""
    start, end = max(one.times[0], other.times[0]), min(one.times[-1], other.times[-1])
    interval = min(float(np.median(np.diff(curve.times))) for curve in (one, other))
    if not end > start or not interval > 0.0 or (end - start) / interval > MOST_SAMPLES:
        return None, "they have no time in common"
    times = start + (end - start) * np.arange(count := round((end - start) / interval) + 1) / (count - 1)
    try:
        return rate(times, *(np.interp(times, curve.times, curve.values) for curve in (one, other))), ""
    except InputError as error:
        if error.code not in (UNUSABLE_CURVE.code, UNUSABLE_REFERENCE.code):
            raise
        return None, error.why


def frames_in_common(*bags: Side) -> list[tuple[int, ...]]:
    """Frames of some sides, all of which have a bag, that belong to one time: one of each side."""
    found = []
    for frame, time in enumerate(bags[0].fabric.times):
        there = [int(np.abs(bag.fabric.times - time).argmin()) for bag in bags[1:]]
        if all(abs(bag.fabric.times[k] - time) <= SAME_TIME for bag, k in zip(bags[1:], there, strict=True)):
            found.append((frame, *there))
    return found


def same_mesh(first: Side, second: Side) -> bool:
    """Whether both bags have the same triangles, so that nodes can be compared one by one."""
    return (
        first.fabric is not None
        and second.fabric is not None
        and len(first.fabric.reference) == len(second.fabric.reference)
        and np.array_equal(first.fabric.triangles, second.fabric.triangles)
    )


def compare_shapes(first: Side, second: Side) -> list[ShapeDifference]:
    """Distances between nodes at each time that both have; none unless both have the same mesh."""
    if not same_mesh(first, second):
        return []
    found = []
    for one, other in frames_in_common(first, second):
        away = distances(first, second, one, other)
        rms = float(np.sqrt(np.mean(away**2)))
        found.append(ShapeDifference(float(first.fabric.times[one]), rms, float(away.max())))
    return found


def distances(first: Side, second: Side, one: int, other: int) -> np.ndarray:
    """Distance of each node of a frame from the same node of the other side [m], (nodes,)."""
    return np.linalg.norm(first.fabric.points(one).astype(float) - second.fabric.points(other), axis=1)


def injuries(history: History | None) -> dict[str, Injury]:
    """Injury metrics of every body, by name, whose motion is recorded densely enough for CFC 1000: from its velocity,
    as `billow injury` does, or from those components of its acceleration that a test measured."""
    known = {} if history is None else quantities(history)
    bodies = [name.partition(f"_{ACCELERATION}")[0] for name in known if f"_{ACCELERATION}" in name]
    found = {}
    for body in dict.fromkeys(bodies):
        velocity = history.find(body, VELOCITY)
        names = [f"{body}_{ACCELERATION}_{axis}" for axis in AXES]
        parts = [history.find("", name) for name in names if name in known]
        try:
            if velocity is not None and velocity.ndim == 2:
                found[body] = assess(history.time, velocity)
            elif parts:
                found[body] = assess_acceleration(history.time, np.stack(parts, axis=1))
        except InputError as error:
            if error.code not in (UNUSABLE_CURVE.code, SAMPLED_TOO_SLOWLY.code):
                raise
    return found


def plain(value: float) -> float | None:
    """A number for JSON."""
    return value if math.isfinite(value) else None
