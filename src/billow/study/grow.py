"""A study that grows: more training runs after the existing ones; existing runs, and all test runs, stay as they are.

More runs come from a larger `train`, or from `added_designs`: a table of designs, as `billow suggest` writes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from billow.base.errors import InputError
from billow.base.table_file import read_table
from billow.results.csv_files import csv_text
from billow.results.dataset_files import Parameter, design_columns
from billow.study.definition import StudyDefinition
from billow.study.design import Design, Values, draw, numbered
from billow.study.variables import StudyConstraint

ANOTHER_STUDY = InputError.declare(
    "E-STU-008",
    "the folder holds something other than this study",
    where="{folder}",
    cause="the study or its case was changed after the folder was made",
    remedy="choose another folder, or delete this one; to continue the study in it, give its own study.toml",
)
CANNOT_GROW = InputError.declare(
    "E-STU-025",
    "{train} training runs cannot grow to {wanted}",
    where="{folder}",
    why="{wanted} is not a multiple of {train}, so that the new runs could not fill all empty strata",
    remedy="set train to a multiple, such as {multiple}, or list more designs in added_designs",
)
UNUSABLE_DESIGNS = InputError.declare(
    "E-STU-024",
    "the table of added designs cannot be used",
    where="{path}",
    cause="a misspelt path in added_designs, columns that are not the parameters, or a value outside its range",
    remedy="write one column for each parameter, headed name [unit], and one row for each run",
)

MAY_GROW = ("train", "nested", "added_designs", "responses")
"""Entries of study.toml that may change after runs were made."""


def merged(existing: StudyDefinition, given: StudyDefinition, folder: Path) -> StudyDefinition:
    """The definition of a study in `folder` after `given` was requested.

    Existing sizes stay sizes of nested hypercubes, so that their runs keep their places. InputError E-STU-008 if
    `given` differs in more than `MAY_GROW` allows.
    """
    known = set(existing.sizes)
    fixed = [name for name in StudyDefinition.model_fields if name not in MAY_GROW]
    different = [name for name in fixed if getattr(existing, name) != getattr(given, name)]
    between = [size for size in given.nested if size not in known and size < existing.train]
    if different:
        why = f"{', '.join(different)} in its study.toml differ from the study asked for"
    elif given.train < existing.train:
        why = f"it has {existing.train} training runs already, more than the {given.train} asked"
    else:
        why = between and f"its {existing.train} training runs were not drawn with nested = {between}"
    if why:
        raise ANOTHER_STUDY(folder=folder, why=why)
    if given.sampling == "sobol":
        return given
    later = [size for size in given.sizes if size > existing.train]
    sizes = (*existing.sizes, *later)
    if any(later) and later[0] % existing.train:
        raise CANNOT_GROW(train=existing.train, wanted=later[0], folder=folder, multiple=2 * existing.train)
    return given.model_copy(update={"train": sizes[-1], "nested": sizes[:-1]})


def grown(existing: Design, definition: StudyDefinition, added: list[Values], folder: Path) -> Design:
    """The runs of a study after it has grown to `definition` with the `added` designs.

    InputError E-STU-008 if runs that exist would no longer belong to it, or a design was added that is a test run.
    """
    wanted = draw(definition)
    rows = [*wanted.train.values(), *added]
    lost = set(existing.train.values()) - set(rows)
    if tuple(existing.test.values()) != tuple(wanted.test.values()):
        why = "its test runs are not those of the study asked for"
    elif lost:
        why = f"{len(lost)} of its training runs are not among those of the study asked for"
    else:
        why = set(added) & set(wanted.test.values()) and "a design in added_designs is one of its test runs"
    if why:
        raise ANOTHER_STUDY(folder=folder, why=why)
    there = set(existing.train.values())
    return numbered(existing, [row for row in rows if row not in there], [])


def added_designs_text(parameters: Sequence[Parameter], rows: Sequence[Sequence[float]]) -> str:
    """The table of design values, (rows, parameters) in each parameter's unit."""
    return csv_text([design_columns(parameters), *(map(float, row) for row in rows)])


def read_added_designs(
    path: str | Path, parameters: Sequence[Parameter], constraints: Sequence[StudyConstraint] = ()
) -> list[Values]:
    """Rows of a table of designs, in file order.

    InputError E-STU-024 if it cannot be read, has other columns, a value that is missing, no number or outside its
    parameter's range, a row twice, or one that breaks a constraint.
    """
    try:
        table, columns = read_table(path), design_columns(parameters)
        if table.names != tuple(columns):
            raise ValueError(f"its columns are {', '.join(table.names)}; expected {', '.join(columns)}")
        values, lines = table.numbers()
        rows = list(map(tuple, values.tolist()))
        for line, row in zip(lines, rows, strict=True):
            for value, p in zip(row, parameters, strict=True):
                if not p.low <= value <= p.high:
                    raise ValueError(f"line {line}: {p.name} = {value:g} is not between {p.low:g} and {p.high:g}")
                if p.levels and value != round(value):
                    raise ValueError(f"line {line}: {p.name} = {value:g} is the number of no level")
        if len(set(rows)) != len(rows):
            raise ValueError("a design stands in it twice")
        for number, constraint in enumerate(constraints, start=1):
            holds = constraint.holds(values, [p.name for p in parameters])
            if not holds.all():
                raise ValueError(f"line {lines[int(holds.argmin())]} breaks number {number} of [[constraints]]")
    except (OSError, ValueError) as error:
        raise UNUSABLE_DESIGNS(path=path, why=error) from error
    return rows
