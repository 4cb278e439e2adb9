"""Numbers read off one run: each measure of `StudyResponse` is a function of a result."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.table_file import read_table
from billow.injury.criteria import assess, mean_acceleration
from billow.injury.filters import channel_filter
from billow.injury.rating import rate
from billow.results.result import Result
from billow.study.response_units import FIXED_UNITS, UNIT_OF_CURVE, factor, factor_of_curve, natural_unit
from billow.study.responses import INJURIES, OF_FRAMES, OF_HISTORY, StudyResponse

NOT_IN_RUN = InputError.declare(
    "E-DES-001",
    "response {name} cannot be read off the run",
    where="{folder}",
    cause="a misspelt obstacle or quantity, or a run of another solver, which has frames and no histories",
    remedy="correct the entry of [[responses]]; docs/histories.md lists the quantities",
)
UNREADABLE_REFERENCE = InputError.declare(
    "E-DES-003",
    "the reference curve of response {name} cannot be read",
    where="{path}",
    cause="a misspelt path, or a file with more than two columns",
    remedy="give a CSV file of two columns: time in s, and the curve in the response's unit",
)

NEVER = float("nan")
"""Value of what did not happen in a run, such as a contact."""
SHARE_OF_END = 0.9
"""Of the end volume, at which a bag counts as filled."""
AXES = {3: "xyz", 4: "wxyz"}
"""Of vectors and quaternions, by how many components they have."""


def measure(result: Result, response: StudyResponse, folder: Path) -> float:
    """Value of a response in a run, in `unit_of`'s unit; NaN for what did not happen in it.

    folder: from which the path of a reference curve counts. InputError E-DES-001: the run does not hold what is
    measured; -002: its unit does not fit; -003: no reference curve; E-INJ-001 to -004.
    """
    value, natural = _measured(result, response, folder)
    return value / factor(response, natural)


def unit_of(result: Result, response: StudyResponse) -> str:
    """Unit of the response. InputError E-DES-001 and -002 as `measure`."""
    of_curve = "" if response.measure in FIXED_UNITS else _curve(result, response)[2]
    natural = natural_unit(response, of_curve)
    factor(response, natural)
    return natural if response.unit is None or response.measure in UNIT_OF_CURVE else response.unit


def _measured(result: Result, response: StudyResponse, folder: Path) -> tuple[float, str]:
    """Value, and its unit without `response.unit`."""
    kind = response.measure
    if kind in OF_HISTORY:
        return _of_curve(result, response)
    if kind in OF_FRAMES:
        return _of_shape(result, response), FIXED_UNITS[kind]
    if kind == "rating":
        times, values, natural = _curve(result, response)
        return _rating(response, times, values / factor_of_curve(response, natural), folder)
    return _SPECIAL[kind](result, response), FIXED_UNITS[kind]


def _of_curve(result: Result, response: StudyResponse) -> tuple[float, str]:
    times, values, unit = _curve(result, response)
    kind = response.measure
    if kind in ("peak", "least", "final"):
        return float({"peak": values.max(), "least": values.min(), "final": values[-1]}[kind]), unit
    if kind == "mean":
        return float(np.trapezoid(values, times) / (times[-1] - times[0])), unit
    if kind == "integral":
        return float(np.trapezoid(values, times)), f"{unit} s"
    if kind == "time_of_peak":
        return float(times[values.argmax()]), "s"
    if kind == "at":
        if not times[0] <= response.time <= times[-1]:
            raise _lacks(result, response, f"it was recorded from {times[0]:g} to {times[-1]:g} s")
        return float(np.interp(response.time, times, values)), unit
    return _first_time(times, values, response.level * factor_of_curve(response, unit)), "s"


def _first_time(times: np.ndarray, values: np.ndarray, level: float) -> float:
    """Time [s] at which a curve first reaches a level, from the side it starts on."""
    past = values >= level if values[0] < level else values <= level
    if not past.any():
        return NEVER
    k = int(past.argmax())
    if k == 0:
        return float(times[0])
    return float(times[k - 1] + (level - values[k - 1]) / (values[k] - values[k - 1]) * (times[k] - times[k - 1]))


def _curve(result: Result, response: StudyResponse) -> tuple[np.ndarray, np.ndarray, str]:
    """Times [s], values (filtered, of a vector its length or one axis), and the unit."""
    quantity, _, axis = response.quantity.partition(".")
    times, values, unit = _history(result, response, quantity)
    if response.channel_class is not None:
        values = channel_filter(times, values, response.channel_class)
    if values.ndim == 2:
        axes = AXES[values.shape[1]]
        if axis and axis not in tuple(axes):
            raise _lacks(result, response, f"{quantity} has no axis {axis!r}")
        values = values[:, axes.index(axis)] if axis else np.linalg.norm(values, axis=1)
    elif axis:
        raise _lacks(result, response, f"{quantity} is no vector")
    return times, values, unit


def _history(result: Result, response: StudyResponse, quantity: str) -> tuple[np.ndarray, np.ndarray, str]:
    of, histories = response.of, result.histories
    if quantity == "acceleration" and "velocity" in histories.of(of):
        # of a force at an instant the chatter of contact would be part (docs/coupled.md)
        return *mean_acceleration(histories.time, histories.of(of).velocity), "m/s^2"
    if quantity in ("absolute_pressure", "gauge_pressure"):
        pressure = _gas(result, of, response).pressure
        return histories.time, pressure - _ambient(result) * (quantity == "gauge_pressure"), "Pa"
    if quantity == "volume" and not of and "volume" not in histories.of(""):  # runs of other solvers
        return result.times, enclosed_volumes(result), "m^3"
    base = f"{of}_{quantity}" if of else quantity
    units = [column.rpartition(" [")[2].rstrip("]") for column in histories
             if column.rpartition(" [")[0] in (base, f"{base}_x")]  # fmt: skip
    values = histories.find(of, quantity)
    if values is None or not units:
        raise _lacks(result, response, f"its histories hold no {quantity!r}{f' of {of!r}' if of else ''}")
    return histories.time, values, units[0]


def _gas(result: Result, of: str, response: StudyResponse):
    try:
        curves = result.chamber(of) if of else result.gas
        curves.pressure  # noqa: B018  whether there is one
        return curves
    except (KeyError, AttributeError) as error:
        raise _lacks(result, response, f"there is no gas {of!r} in its histories") from error


def _ambient(result: Result) -> float:
    """Pressure [Pa] of the surroundings."""
    return float(result.case_toml.get("ambient", {}).get("pressure", 101325.0))


def enclosed_volumes(result: Result) -> np.ndarray:
    """Volume [m^3] in the closed surface of every frame, (times,): a sixth of the triple products of its triangles."""
    points = result.reference.astype(float) + result.displacement
    a, b, c = (points[:, result.triangles[:, k]] for k in range(3))
    return np.einsum("tni,tni->t", a, np.cross(b, c)) / 6.0


def _body(result: Result, response: StudyResponse):
    if response.of not in result.obstacles:
        raise _lacks(
            result, response, f"it has no obstacle {response.of!r}, but {', '.join(result.obstacles) or 'none'}"
        )
    return result.body(response.of)


def _injury(result: Result, response: StudyResponse) -> float:
    body = _body(result, response)
    if "velocity" not in body:
        raise _lacks(result, response, f"{response.of} is locked, so it has no acceleration")
    found = assess(result.histories.time, body.velocity)
    if response.measure == "clip3ms":
        return found.clip
    return getattr(found, response.measure).value


def _touching(result: Result, response: StudyResponse) -> np.ndarray:
    return np.linalg.norm(_body(result, response).force, axis=1) > 0.0


def _first_contact(result: Result, response: StudyResponse) -> float:
    touching = _touching(result, response)
    return float(result.histories.time[touching.argmax()]) if touching.any() else NEVER


def _contact_duration(result: Result, response: StudyResponse) -> float:
    times, touching = result.histories.time, _touching(result, response)
    return float(np.diff(times)[touching[1:]].sum())


def _energy_share(result: Result, response: StudyResponse) -> float:
    _, account, unit = _history(result, response, response.quantity)
    injected = result.histories.find("", "enthalpy_in")
    if unit != "J" or injected is None or not injected[-1] > 0.0:
        raise _lacks(result, response, f"{response.quantity!r} is no energy, or nothing was blown in")
    return float(np.abs(account).max() / injected[-1])


def _vented_mass(result: Result, response: StudyResponse) -> float:
    vented = result.histories.find(response.of, "vented")
    if vented is None:
        raise _lacks(result, response, "nothing can be vented")
    return float(vented[-1])


def _fill_time(result: Result, response: StudyResponse) -> float:
    times, volume, _ = _curve(result, response.model_copy(update={"quantity": "volume", "filter": None}))
    return _first_time(times, volume, SHARE_OF_END * float(volume[-1]))


def _penetration(result: Result, response: StudyResponse) -> float:
    body = _body(result, response)
    if "penetration" not in body:
        raise _lacks(result, response, "it records no penetration")
    return float(body.penetration.max())


_SPECIAL = {
    **dict.fromkeys(INJURIES, _injury),
    "penetration": _penetration,
    "first_contact": _first_contact,
    "contact_duration": _contact_duration,
    "energy_share": _energy_share,
    "vented_mass": _vented_mass,
    "fill_time": _fill_time,
}


def _of_shape(result: Result, response: StudyResponse) -> float:
    times = result.times
    frame = len(times) - 1 if response.time is None else int(np.abs(times - response.time).argmin())
    if response.time is not None and abs(times[frame] - response.time) > np.ptp(times) / max(len(times) - 1, 1):
        raise _lacks(result, response, f"its frames are from {times[0]:g} to {times[-1]:g} s")
    points, triangles = result.reference.astype(float) + result.displacement[frame], result.triangles
    if response.of:
        if response.of not in result.fabric.part_names:
            raise _lacks(result, response, f"its mesh has no part {response.of!r}")
        part = result.fabric.part == list(result.fabric.part_names).index(response.of)
        triangles = triangles[part]
    if response.measure == "section_area":
        return section_area(points, triangles, np.array(response.point), np.array(response.normal))
    if response.measure == "contact_area":
        return _contact_area(result, triangles, None if response.time is None else frame)
    points = points[np.unique(triangles)] if response.of else points
    if response.measure == "height":
        return float(np.ptp(points[:, 2]))
    if response.measure == "width":
        return float(np.ptp(points[:, :2], axis=0).max())
    away = points - np.array(response.point)
    if response.normal is None:
        return float(np.linalg.norm(away, axis=1).min())
    normal = np.array(response.normal, float)
    return float((away @ (normal / np.linalg.norm(normal))).min())


def section_area(points: np.ndarray, triangles: np.ndarray, point: np.ndarray, normal: np.ndarray) -> float:
    """Area [m^2] that a closed surface encloses in a plane, by Green's theorem over the lines of the cut.

    points: [m], (nodes, 3); triangles: (triangles, 3), counted round from outside; point: [m], of the plane
    """
    normal = normal / np.linalg.norm(normal)
    heights = (points - point) @ normal
    above = heights[triangles] > 0.0
    cut = triangles[above.any(axis=1) & ~above.all(axis=1)]
    corners, height = points[cut], heights[cut]
    # The corner that is alone on its side first: both edges from it are cut.
    above = height > 0.0
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), above.argmin(axis=1))
    order, rows = (alone[:, None] + np.arange(3)) % 3, np.arange(len(cut))[:, None]
    corners, height = corners[rows, order] - point, height[rows, order]
    share = height[:, :1] / (height[:, :1] - height[:, 1:])
    first, second = (corners[:, 0] + share[:, k, None] * (corners[:, k + 1] - corners[:, 0]) for k in range(2))
    turned = np.where(height[:, 0] > 0.0, 1.0, -1.0)  # seen from above the plane, the bag lies on the left
    return abs(float(0.5 * (turned * (np.cross(first, second) @ normal)).sum()))


def _contact_area(result: Result, triangles: np.ndarray, frame: int | None) -> float:
    """Area [m^2] of the fabric whose nodes obstacles press on, in a frame or the largest of all."""
    frames = range(len(result.times)) if frame is None else (frame,)
    found = []
    for k in frames:
        points = result.reference.astype(float) + result.displacement[k]
        a, b, c = (points[triangles[:, corner]] for corner in range(3))
        areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        pressed = np.any(result.contact_force[k] != 0.0, axis=1)
        found.append(float((areas * pressed[triangles].mean(axis=1)).sum()))
    return max(found)


def _rating(response: StudyResponse, times: np.ndarray, values: np.ndarray, folder: Path) -> tuple[float, str]:
    path = folder / response.reference
    try:
        found, _ = read_table(path).numbers()
        if found.shape[1] != 2 or len(found) < 2 or (np.diff(found[:, 0]) <= 0.0).any():
            raise ValueError("it needs two columns, the first a time that rises")
    except (OSError, ValueError) as error:
        raise UNREADABLE_REFERENCE(name=response.name, path=path, why=error) from error
    common = (times >= found[0, 0]) & (times <= found[-1, 0])
    if common.sum() < 2:
        raise UNREADABLE_REFERENCE(name=response.name, path=path, why="it has no time in common with the run")
    times, values = times[common], values[common]
    return rate(times, values, np.interp(times, found[:, 0], found[:, 1])).overall, "-"


def _lacks(result: Result, response: StudyResponse, why: str) -> InputError:
    return NOT_IN_RUN(name=response.name, folder=result.folder, why=why)
