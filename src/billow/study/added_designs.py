"""Designs chosen by the user: a table with a column for each parameter and a row for each run.

    permeability [-],inflator_temperature [K]
    0.0231,655.0

`billow suggest` writes such a file; `added_designs = "next.csv"` in study.toml makes its rows training runs.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

from billow.base.errors import InputError
from billow.results.dataset_files import Parameter

UNUSABLE_DESIGNS = InputError.declare(
    "E-STU-024",
    "the table of added designs cannot be used",
    where="{path}",
    cause="a misspelt path in added_designs, columns that are not the parameters, or a value outside its range",
    remedy="write one column for each parameter, headed name [unit], and one row for each run",
)


def added_designs_text(parameters: Sequence[Parameter], rows: Sequence[Sequence[float]]) -> str:
    """The table of design values, (rows, parameters) in each parameter's unit."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(_columns(parameters))
    table.writerows([list(map(float, row)) for row in rows])
    return text.getvalue()


def read_added_designs(path: str | Path, parameters: Sequence[Parameter]) -> list[tuple[float, ...]]:
    """Rows of a table of designs, in file order.

    InputError E-STU-024 if it cannot be read, has other columns, a value that is missing, no number or outside its
    parameter's range, or a row twice.
    """
    path = Path(path)
    try:
        with open(path, newline="", encoding="utf-8") as file:
            header, *lines = [line for line in csv.reader(file, strict=True) if line]
        if header != _columns(parameters):
            raise ValueError(f"its columns are {', '.join(header)}; expected {', '.join(_columns(parameters))}")
        rows = [tuple(map(float, line)) for line in lines]
        for number, row in enumerate(rows, start=1):
            _check_row(number, row, parameters)
        if len(set(rows)) != len(rows):
            raise ValueError("a design stands in it twice")
    except (OSError, ValueError, csv.Error) as error:
        raise UNUSABLE_DESIGNS(path=path, why=error) from error
    return rows


def _check_row(number: int, row: tuple[float, ...], parameters: Sequence[Parameter]) -> None:
    if len(row) != len(parameters):
        raise ValueError(f"row {number} has {len(row)} values for {len(parameters)} parameters")
    for value, parameter in zip(row, parameters, strict=True):
        if not (math.isfinite(value) and parameter.low <= value <= parameter.high):
            raise ValueError(
                f"row {number}: {parameter.name} = {value:g} is not between {parameter.low:g} and {parameter.high:g}"
            )


def _columns(parameters: Sequence[Parameter]) -> list[str]:
    return [f"{p.name} [{p.unit}]" for p in parameters]
