"""histories.csv: curves over time, one column each, the unit in the header.

    time [s],pressure [Pa],vent mass flow [kg/s]
    0.0,0.0,0.0
    1e-05,12.25,0.0

Numbers are written with as many digits as it takes to read back the same bits.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from billow.base.errors import IntegrityError
from billow.results.atomic import write_atomically

UNREADABLE_HISTORIES = IntegrityError.declare(
    "E-RES-008",
    "histories cannot be read",
    where="{path}",
    cause="an edit by hand or with a spreadsheet",
    remedy="run the case again: billow run CASE.toml --out RUN",
)

TIME = "time [s]"
_HEADER = re.compile(r"[^\[\]]*\S \[[^\[\]]+\]")


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
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(names)
    table.writerows(zip(*(curve.tolist() for curve in curves), strict=True))  # Python floats: shortest exact text
    write_atomically(path, text.getvalue())


def read_histories(path: str | Path) -> dict[str, np.ndarray]:
    """Curves of a histories.csv: "name [unit]" -> (n,) float64. IntegrityError E-RES-008 if it is not one."""
    path = Path(path)
    try:
        with open(path, newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        values = np.array(rows, dtype=np.float64).reshape(len(rows), len(header))
        if header[0] != TIME or len(set(header)) != len(header):
            raise ValueError(f"header {header}")
    except (OSError, ValueError, IndexError) as error:
        raise UNREADABLE_HISTORIES(path=path, why=error) from error
    return {name: values[:, column] for column, name in enumerate(header)}
