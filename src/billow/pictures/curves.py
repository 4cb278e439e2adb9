"""Curves of histories by the names people give them: components, resultants, and both through a channel filter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from billow.base.close_names import did_you_mean
from billow.base.errors import InputError
from billow.injury.criteria import mean_acceleration
from billow.injury.filters import channel_filter
from billow.results.histories import TIME, History

NO_QUANTITY = InputError.declare(
    "E-PIC-009",
    "no histories hold {name!r}",
    where="{path}",
    why="they hold {known}",
    cause="a misspelt name, or a run without that obstacle, strap or sensor",
    remedy="{hint}docs/histories.md lists what runs write",
)

MOST_NAMED = 40
"""Quantities that a message lists."""
AXES = "xyz"
ACCELERATION, VELOCITY = "acceleration", "velocity"
FIRST = ("pressure", "volume")
MOST_BY_DEFAULT = 6


@dataclass(frozen=True)
class Curve:
    """title: for people. unit: of SI. times [s] and values: (n,)."""

    title: str
    unit: str
    times: np.ndarray
    values: np.ndarray

    @property
    def peak(self) -> tuple[float, float]:
        """The value that is farthest from zero, and its time [s]; of values that are no numbers, none."""
        sound = np.flatnonzero(np.isfinite(self.values))
        if not len(sound):
            return float("nan"), float("nan")
        k = sound[np.abs(self.values[sound]).argmax()]
        return float(self.values[k]), float(self.times[k])

    @property
    def end(self) -> float:
        return float(self.values[-1])


def quantities(history: History) -> dict[str, str]:
    """Names that `curve_of` knows, with their units: columns but for the time, and vectors, which mean resultants."""
    columns = dict(column.removesuffix("]").rpartition(" [")[::2] for column in history if column != TIME)
    vectors = {
        name[:-2]: unit for name, unit in columns.items()
        if name.endswith("_x") and all(f"{name[:-2]}_{axis}" in columns for axis in AXES)
    }  # fmt: skip
    return columns | vectors


def curve_of(history: History, name: str, channel_class: int | None = None) -> Curve | None:
    """A quantity by its name, such as "pressure", "impactor_velocity_z", or "impactor_velocity" for the resultant; None
    if there is none.

    channel_class: of the filter that each component goes through first. The acceleration of a body whose velocity is
    recorded is then its mean over each interval, as for injury metrics: its peak is the one that `billow injury` tells.
    InputError E-INJ-001 to -003 if the curve cannot be filtered.
    """
    unit = quantities(history).get(name)
    if unit is None:
        return None
    values, axis = history.find("", name), name[-1:]
    title = name.replace("_", " ")
    times = history.time
    if channel_class is not None:
        of_whole = name.removesuffix(f"_{axis}") if axis in AXES else name
        velocity = history.find("", f"{of_whole.removesuffix(ACCELERATION)}{VELOCITY}")
        if of_whole.endswith(f"_{ACCELERATION}") and velocity is not None and velocity.ndim == 2:
            times, mean = mean_acceleration(times, velocity)
            values = mean if of_whole == name else mean[:, AXES.index(axis)]
        values = channel_filter(times, values, channel_class)
        title += f", CFC {channel_class}"
    if values.ndim == 2:
        values = np.linalg.norm(values, axis=1)
        title = f"{title.partition(',')[0]}, resultant{''.join(title.partition(',')[1:])}"
    return Curve(title, unit, np.asarray(times, float), np.asarray(values, float))


def usual_quantities(histories: Sequence[History]) -> list[str]:
    """What is drawn if nobody asks for anything: pressure and volume, accelerations of free bodies and forces on the
    others; of other tables their first quantities."""
    known = list(dict.fromkeys(name for history in histories for name in quantities(history)))
    found = [name for name in FIRST if name in known]
    vectors = [name for name in known if f"{name}_x" in known]
    free = [name.removesuffix(f"_{ACCELERATION}") for name in vectors if name.endswith(f"_{ACCELERATION}")]
    found += [f"{body}_{quantity}" for body in free for quantity in (ACCELERATION, VELOCITY)]
    others = [name.removesuffix("_force") for name in vectors if name.endswith("_force")]
    found += [f"{body}_force" for body in others if not body.endswith("_obstacle") and body not in (*free, "plate")]
    return (found or known)[:MOST_BY_DEFAULT]


def require_quantities(names: Iterable[str], histories: Sequence[History], path: object) -> None:
    """InputError E-PIC-009 for a name that no history has."""
    known = list(dict.fromkeys(name for history in histories for name in quantities(history)))
    for name in names:
        if name not in known:
            listed = ", ".join(known[:MOST_NAMED]) + (", ..." if len(known) > MOST_NAMED else "")
            raise NO_QUANTITY(name=name[:60], path=path, known=listed or "nothing", hint=did_you_mean(name, known))
