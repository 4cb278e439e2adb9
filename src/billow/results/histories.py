"""histories.csv: curves over time, one column each, the unit in the header (docs/histories.md).

This file alone knows how a column is called: NAME_QUANTITY_AXIS [UNIT], without a name for what belongs to the whole
model, without an axis for what is no vector. Others give quantities to `columns` and ask a `History` for them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.base.errors import IntegrityError
from billow.base.input_file import LARGEST_DATA
from billow.base.table_file import read_table
from billow.results.atomic import write_atomically
from billow.results.csv_files import csv_text

UNREADABLE_HISTORIES = IntegrityError.declare(
    "E-RES-008",
    "histories cannot be read",
    where="{path}",
    cause="an edit by hand or with a spreadsheet",
    remedy="run the case again: billow run CASE.toml --out RUN",
)

TIME = "time [s]"
_HEADER = re.compile(r"[^\[\]]*\S \[[^\[\]]+\]")
_AXES = {3: "xyz", 4: "wxyz"}


def column_names(of: str, quantity: str, unit: str, width: int = 0) -> list[str]:
    """Columns of a quantity, one for each axis; width: 0 for a number, 3 for a vector, 4 for a quaternion."""
    base = f"{of}_{quantity}" if of else quantity
    return [f"{base}_{axis} [{unit}]" for axis in _AXES[width]] if width else [f"{base} [{unit}]"]


def columns(quantities: Iterable[tuple[str, str, str, float | np.ndarray]]) -> dict[str, float]:
    """A row of histories: column -> value, from quantities (of, name, unit, value) as parts give them.

    Raises ValueError if two of them share a column.
    """
    row: dict[str, float] = {}
    for of, name, unit, value in quantities:
        values = np.ravel(value).tolist()
        for column, number in zip(column_names(of, name, unit, np.ndim(value) * len(values)), values, strict=True):
            if column in row:
                raise ValueError(f"two quantities are called {column}")
            row[column] = float(number)
    return row


def values(quantities: Iterable[tuple[str, str, str, float | np.ndarray]]) -> list[float]:
    """The values of `columns`, of a row whose columns are known."""
    row: list[float] = []
    for *_, value in quantities:
        if isinstance(value, np.ndarray) and value.ndim:
            row += value.tolist()
        else:
            row.append(float(value))
    return row


class Curves:
    """The curves of one thing; each quantity is an attribute: (n,), vectors (n, 3), quaternions (n, 4) with w first.

    history.of("impactor").velocity
    """

    def __init__(self, history: History, of: str):
        self._history, self._of = history, of

    def __getattr__(self, quantity: str) -> np.ndarray:
        found = self._history.find(self._of, quantity)
        if found is None:
            what = f"{quantity!r} of {self._of!r}" if self._of else repr(quantity)
            raise AttributeError(f"the histories do not hold {what}")
        return found

    def __contains__(self, quantity: str) -> bool:
        return self._history.find(self._of, quantity) is not None


class History(dict[str, np.ndarray]):
    """Curves over time: a mapping "name [unit]" -> (n,), and by what they belong to."""

    @cached_property
    def _bare(self) -> dict[str, np.ndarray]:
        """The columns without their units."""
        return {column.rpartition(" [")[0]: curve for column, curve in self.items()}

    def find(self, of: str, quantity: str) -> np.ndarray | None:
        """Curve of a quantity, None if there is none."""
        base = f"{of}_{quantity}" if of else quantity
        if base in self._bare:
            return self._bare[base]
        for axes in reversed(_AXES.values()):
            if all(f"{base}_{axis}" in self._bare for axis in axes):
                return np.stack([self._bare[f"{base}_{axis}"] for axis in axes], axis=1)
        return None

    def of(self, name: str) -> Curves:
        """Curves of a body, chamber, passage, sensor or strap by its name; of the whole model by an empty name."""
        return Curves(self, name)

    def energy(self, account: str) -> np.ndarray:
        """Energy of an account of the ledger [J], (n,); zero for one that the run did not have."""
        found = self.find("", account)
        return np.zeros(len(self.time)) if found is None else found

    @property
    def time(self) -> np.ndarray:
        """[s], (n,)."""
        return self[TIME]


def write_histories(path: str | Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write curves, atomically.

    columns: "name [unit]" -> (n,) floats; the first is "time [s]". ValueError if a name has no unit or lengths differ.
    """
    names = list(columns)
    if not names or names[0] != TIME:
        raise ValueError(f"the first history must be {TIME!r}, not {names[:1]}")
    nameless = [name for name in names if not _HEADER.fullmatch(name)]
    if nameless:
        raise ValueError(f"histories without a unit, such as 'pressure [Pa]': {nameless}")
    curves = [np.asarray(columns[name], dtype=np.float64) for name in names]
    if any(curve.shape != (len(curves[0]),) for curve in curves):
        raise ValueError(f"histories differ in length: { {n: c.shape for n, c in zip(names, curves, strict=True)} }")
    write_atomically(path, csv_text([names, *zip(*(curve.tolist() for curve in curves), strict=True)]))


def read_histories(path: str | Path) -> History:
    """Curves of a histories.csv. IntegrityError E-RES-008 if it is not one."""
    try:
        table = read_table(path, LARGEST_DATA)
        values, _ = table.numbers(finite=False)
        if table.names[0] != TIME:
            raise ValueError(f"its first column is {table.names[0]!r}; expected {TIME!r}")
    except (OSError, ValueError) as error:
        raise UNREADABLE_HISTORIES(path=path, why=error) from error
    return History({name: values[:, column] for column, name in enumerate(table.names)})
