"""A measured tank test from a CSV file: pressure and, if measured, gas temperature against time.

    time [ms],pressure [kPa],gas temperature [K]
    0.0,101.3,295.0
    0.1,101.4,296.1

Columns are found by name and unit, in any order; others are ignored. Time 0 is ignition; rows before it give the
pressure at rest.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.plausible import require_possible
from billow.base.table_file import Table, read_table
from billow.base.units import CONVERSIONS

NOT_A_TRACE = InputError.declare(
    "E-TANK-005",
    "{name} is not a trace",
    where="{path}",
    cause="a misspelt path, text among the numbers, rows of unequal length, or too few rows after ignition",
    remedy="give a CSV file: a header such as time [ms],pressure [kPa], then one row of numbers for each instant",
)
NO_COLUMN = InputError.declare(
    "E-TANK-006",
    "there is no column of {quantity}",
    where="{path}, line {line}",
    why="its columns are {columns}; expected '{quantity} [unit]' with one of {units}",
    cause="a header without a unit, or with one that is not known",
    remedy="head the columns with quantity and unit, for example: time [ms],pressure [kPa]",
)
TIMES_DO_NOT_INCREASE = InputError.declare(
    "E-TANK-007",
    "the times of the trace do not increase",
    where="{path}, line {line}",
    why="{later:g} s follows {earlier:g} s",
    cause="two tests in one file, or times written with too few digits",
    remedy="give one test in the order of time, each instant once",
)
BELOW_ZERO = InputError.declare(
    "E-TANK-008",
    "the absolute pressure is negative",
    why="the smallest is {smallest:g} {unit}",
    cause="gauge pressure stated as absolute, or gas temperatures in degrees Celsius",
    remedy='state pressure = "gauge" if the file holds gauge pressure; check its zero',
)
OTHER_START = InputError.declare(
    "E-TANK-009",
    "the trace does not begin at the pressure of the tank",
    why="it begins at {start:.5g} Pa, absolute; the case says that the tank holds {said:.5g} Pa",
    cause="gauge and absolute pressure confused, or another ambient pressure",
    remedy='correct the pressure of [tank], or pressure = "absolute" or "gauge" of [measurement]',
)
PRESSURE_FALLS = InputError.declare(
    "E-TANK-010",
    "the pressure falls although the tank loses no heat",
    why="it falls by {fall:.3g} Pa from its highest level, {share:.1%} of the rise",
    cause="gas that cools at the wall, water that condenses, or a leak",
    remedy="give wall_area and heat_transfer of [tank], or end_time of [measurement] to stop at the peak",
)
NO_RISE = InputError.declare(
    "E-TANK-011",
    "the pressure does not rise",
    why="its peak is {rise:.3g} Pa above the start, in noise of {noise:.3g} Pa",
    cause="an inflator that did not fire, another channel, or a wrong unit",
    remedy="give the trace of a deployment; check the unit of the pressure",
)

FEWEST_ROWS = 20
MOST_ROWS = 2000
"""Longer traces are averaged over blocks of equal length; the detail lost is finer than any flow that can be
resolved."""

_QUANTITIES = {"time": "s", "pressure": "Pa", "gas temperature": "K"}
_HEADER = re.compile(r"\s*(.*\S)\s*\[\s*(\S+)\s*\]\s*")


@dataclass(frozen=True)
class Trace:
    """times [s], increasing, none negative; pressure [Pa, absolute]; gas_temperature [K] or None; all (n,). rest [Pa]:
    pressure before ignition, if it was recorded."""

    times: np.ndarray
    pressure: np.ndarray
    gas_temperature: np.ndarray | None = None
    rest: float | None = None


def load_trace(path: str | Path, gauge: float = 0.0, end: float | None = None) -> Trace:
    """Trace from a CSV file, at most `MOST_ROWS` rows long.

    gauge: pressure [Pa] that the file's zero stands for: 0 for absolute readings, that of the surroundings for gauge;
    end: time [s] after which the file is ignored. Raises InputError E-TANK-005 (no such table), E-TANK-006 (columns),
    E-TANK-007 (times), E-UNIT-001 (duration or pressure in another unit).
    """
    path = Path(path)
    try:
        table = read_table(path)
        columns, lines = _columns(path, table)
    except (OSError, ValueError) as error:
        raise NOT_A_TRACE(name=path.name, path=path, why=error) from None
    times = columns["time"]
    wrong = np.flatnonzero(np.diff(times) <= 0.0)
    if len(wrong):
        k = wrong[0]
        raise TIMES_DO_NOT_INCREASE(path=path, line=lines[k + 1], later=times[k + 1], earlier=times[k])
    used = (times >= 0.0) & (times <= (np.inf if end is None else end))
    if used.sum() < FEWEST_ROWS:
        why = f"{used.sum()} rows from ignition to the end; at least {FEWEST_ROWS} are needed"
        raise NOT_A_TRACE(name=path.name, path=path, why=why)
    columns["pressure"] = columns["pressure"] + gauge
    rest = columns["pressure"][times < 0.0]
    kept = {name: _block_means(values[used]) for name, values in columns.items()}
    return Trace(kept["time"], kept["pressure"], kept.get("gas temperature"), float(rest.mean()) if len(rest) else None)


def check_trace(trace: Trace, start_pressure: float, loses_heat: bool, where: str) -> None:
    """Check that a trace can be that of a closed tank that begins at start_pressure [Pa].

    Raises InputError: E-TANK-008 negative pressure or temperature, E-TANK-009 another start, E-TANK-010 a fall without
    loss, E-TANK-011 no rise.
    """
    noise, peak = noise_of(trace.pressure), float(trace.pressure.max())
    gas = trace.gas_temperature
    if trace.pressure.min() < -max(6.0 * noise, 1e-3 * abs(peak)):
        raise BELOW_ZERO(where=where, smallest=trace.pressure.min(), unit="Pa")
    if gas is not None and gas.min() <= 0.0:
        what, remedy = "the gas temperature is not above 0 K", "give it in kelvin"
        raise BELOW_ZERO(what=what, where=where, smallest=gas.min(), unit="K", remedy=remedy)
    # Pressure at ignition, and the factor by which its noise is smaller than that of one row.
    start, share = (trace.pressure[0], 1.0) if trace.rest is None else (trace.rest, 0.5)
    recorded = trace.rest is not None or trace.times[0] <= 0.005 * trace.times[-1]
    allowed = max(6.0 * noise * share, 0.02 * abs(peak - start), 0.01 * start_pressure)
    if recorded and abs(start - start_pressure) > allowed:
        raise OTHER_START(where=where, start=start, said=start_pressure)
    rise = peak - start_pressure
    if rise < 10.0 * noise:
        raise NO_RISE(where=where, rise=rise, noise=noise)
    span = max(len(trace.pressure) // 20, 1)
    level = np.convolve(trace.pressure, np.full(span, 1.0 / span), "valid")
    fall = level.max() - level[-1]
    if not loses_heat and fall > max(6.0 * noise / np.sqrt(span), 0.005 * rise):
        raise PRESSURE_FALLS(where=where, fall=fall, share=fall / rise)


def noise_of(values: np.ndarray) -> float:
    """Standard deviation of white noise on a smooth curve, from second differences (Gasser, Sroka and Jennen-Steinmetz
    1986), with a floor of rounding."""
    rough = np.diff(values, 2)
    return float(max(np.sqrt(np.mean(rough**2) / 6.0), 1e-12 * np.abs(values).max()))


def _columns(path: Path, table: Table) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Columns in SI units by quantity, and the number of each row's line. ValueError if a value is no number."""
    found: dict[str, tuple[str, str]] = {}
    for text in table.names:
        match = _HEADER.fullmatch(text)
        name = match.group(1).lower() if match else ""
        factors = CONVERSIONS[_QUANTITIES[name]] if name in _QUANTITIES else {}
        if match and match.group(2) in factors:
            if name in found:
                raise ValueError(f"{found[name][0]!r} and {text!r} are both columns of {name}")
            found[name] = text, match.group(2)
    for name in ("time", "pressure"):
        if name not in found:
            units, columns = ", ".join(CONVERSIONS[_QUANTITIES[name]]), ", ".join(map(repr, table.names))
            raise NO_COLUMN(path=path, line=table.line, quantity=name, columns=columns, units=units)
    values, lines = table.numbers([text for text, _ in found.values()])
    columns = {
        name: values[:, k] * CONVERSIONS[_QUANTITIES[name]][unit] for k, (name, (_, unit)) in enumerate(found.items())
    }
    asked = ("duration of a trace", "time", np.ptp), ("peak pressure of a trace", "pressure", np.max)
    for kind, name, of in asked:
        change = f"head the column {name} [{{unit}}]"
        require_possible(kind, float(of(columns[name])), f"the {kind}", str(path), change, found[name][1])
    return columns, lines


def _block_means(values: np.ndarray) -> np.ndarray:
    size = -(-len(values) // MOST_ROWS)
    whole = len(values) // size * size
    return values[:whole].reshape(-1, size).mean(axis=1)
