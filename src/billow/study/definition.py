"""study.toml: the case of a study, its parameters, and the numbers of runs (docs/rom.md, The study file)."""

from __future__ import annotations

import difflib
import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from billow.base.attribute_docstrings import described
from billow.base.errors import InputError, shown
from billow.base.plausible import require_possible
from billow.base.toml_file import read_toml
from billow.case.quantity import listed, missing_beside, reason_of
from billow.results.dataset_files import Parameter

UNREADABLE = InputError.declare(
    "E-STU-001",
    "the study file cannot be read",
    where="{path}",
    cause="a misspelt path, or no permission",
    remedy="check the path; `billow demo` writes an example, study.toml",
)
NOT_TOML = InputError.declare(
    "E-STU-002",
    "the study file is not valid TOML",
    where="{path}",
    cause="a missing quote or bracket, or a file of another kind",
    remedy='write texts in quotes and numbers without, such as title = "Driver bag", train = 48',
)
UNKNOWN_KEY = InputError.declare(
    "E-STU-003",
    "{key!r} is not a known key",
    why="known here are {known}",
    cause="a misspelt key",
    remedy="remove it, or correct its spelling",
)
UNUSABLE_VALUE = InputError.declare(
    "E-STU-004",
    "{name} = {value} cannot be used",
    cause="a range that is empty, a name given twice, or a value of another kind",
    remedy="correct the value; `billow demo` writes an example, study.toml",
)
MISSING_KEY = InputError.declare(
    "E-STU-005",
    "{keys} missing",
    why="there is no default",
    remedy="add {first}; `billow demo` writes an example, study.toml",
)
NO_CASE = InputError.declare(
    "E-STU-006",
    "the case file {case} does not exist",
    where="{path}: case",
    why="it was looked for at {place}",
    remedy="give its path relative to the study file",
)

MOST_RUNS = 10_000


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise ValueError("a line break or a control character does not belong here")
    return value


_Text = Annotated[str, Field(min_length=1), AfterValidator(_one_line)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: Any) -> dict[str, Any]:
        return described(cls, handler(core_schema), handler)


class StudyParameter(_Strict):
    """One axis of the design space; low and high are in `unit`, which is the unit of the case's entries `keys`."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
    """What it is called in design.csv and by `billow predict --set NAME=VALUE`: letters, digits and _."""
    label: _Text
    """What it is called in reports."""
    unit: Annotated[str, Field(pattern=r"^[^\[\]]+$"), AfterValidator(_one_line)]
    """Unit of low and high, that of the case's entries; "-" for none."""
    low: float
    """Smallest value."""
    high: float
    """Largest value."""
    keys: Annotated[tuple[_Text, ...], Field(strict=False, min_length=1, max_length=100)]
    """Entries of the case that take the value, such as "fabric.permeability" or "obstacles.impactor.degree"."""
    scale: Literal["linear", "log"] = "linear"
    """Whether designs are spread evenly over the values or over their logarithms."""


class StudyDefinition(_Strict):
    """The content of a study.toml. reference_length: [m]."""

    title: _Text
    """Title of the study and of what is learned from it."""
    case: _Text
    """Path of the case file that is varied, from the folder of the study file."""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """Chooses the designs; the same seed gives the same ones."""
    train: Annotated[int, Field(ge=2, le=MOST_RUNS)]
    """Number of training runs: a Latin hypercube."""
    test: Annotated[int, Field(ge=1, le=MOST_RUNS)]
    """Number of unseen runs, to measure accuracy with: another Latin hypercube."""
    nested: Annotated[tuple[Annotated[int, Field(ge=2)], ...], Field(strict=False, max_length=100)] = ()
    """Smaller numbers of training runs, ascending, that are to be Latin hypercubes, too."""
    added_designs: _Text | None = None
    """Path of a table of further training designs (CSV), as `billow suggest` writes it."""
    reference_length: Annotated[float, Field(gt=0)]
    """Length [m] to which errors are compared, such as the diameter of the bag."""
    parameters: Annotated[tuple[StudyParameter, ...], Field(strict=False, min_length=1, max_length=100)]
    """The axes of the design space."""

    @classmethod
    def load(cls, path: str | Path) -> StudyDefinition:
        """Read and check a study.toml.

        InputError E-STU-001: no such file; -002: not TOML; -003: unknown key; -004: a value that cannot be used;
        -005: a key is missing; -006: the case file does not exist; E-UNIT-001: reference_length in another unit.
        """
        path = Path(path)
        content = _read_toml(path)
        try:
            definition = cls.model_validate(content)
        except ValidationError as error:
            raise _told(path, content, error) from error
        place, change = f"{path}: reference_length", "it is in m"
        require_possible("bag size", definition.reference_length, "the reference length", place, change)
        for where, what, why, remedy in _contradictions(definition):  # the first is told
            raise UNUSABLE_VALUE(what=f"{what}", where=f"{path}: {where}", why=why, remedy=remedy)
        case = path.parent / definition.case
        if not os.path.isfile(case):  # unlike Path.is_file, no error for a name that is too long
            raise NO_CASE(case=definition.case, path=path, place=case)
        return definition

    @property
    def axes(self) -> tuple[Parameter, ...]:
        """The parameters in the form that a dataset uses."""
        return tuple(Parameter(p.name, p.label, p.unit, p.low, p.high) for p in self.parameters)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of training runs that are Latin hypercubes themselves, ascending; the last is `train`."""
        return (*self.nested, self.train)

    def to_toml(self) -> str:
        """The text of a study.toml with every default filled in."""
        return tomli_w.dumps(self.model_dump(mode="json", exclude_none=True))


def _read_toml(path: Path) -> dict:
    try:
        return read_toml(path)
    except OSError as error:
        raise UNREADABLE(path=path, why=error) from error
    except ValueError as error:
        raise NOT_TOML(path=path, why=error) from error


_REASONS = {
    "name": ("results are stored by parameter name", "give each parameter its own name"),
    "range": ("a parameter needs a range to be drawn from",
              "swap low and high, or set the value in the case instead of varying it"),
    "logarithm": ("only positive values have a logarithm", "give a low above 0, or scale = 'linear'"),
}  # fmt: skip
"""What several entries do not agree on -> why that cannot be, and what to do."""


def _contradictions(definition: StudyDefinition) -> Iterator[tuple[str, str, str, str]]:
    """What only a look at several entries shows: where, what, why and remedy of each contradiction."""
    owners: dict[str, str] = {}
    names = [parameter.name for parameter in definition.parameters]
    for number, parameter in enumerate(definition.parameters, start=1):
        where = f"[[parameters]] number {number} ({parameter.name})"
        if parameter.name in names[: number - 1]:
            yield where, f"two parameters are called {parameter.name!r}", *_REASONS["name"]
        if not parameter.low < parameter.high:
            yield where, f"low = {parameter.low:g} is not below high = {parameter.high:g}", *_REASONS["range"]
        if parameter.scale == "log" and parameter.low <= 0:
            yield where, f"low = {parameter.low:g} with scale = 'log'", *_REASONS["logarithm"]
        for key in parameter.keys:
            if key in owners:
                why = f"it is also among the keys of {owners[key]!r}"
                remedy = "let each case entry belong to one parameter"
                yield where, f"the case entry {key!r} is varied twice", why, remedy
            owners[key] = parameter.name
    for smaller, larger in itertools.pairwise(definition.sizes):
        if larger <= smaller or larger % smaller:
            what = f"nested = {list(definition.nested)} with train = {definition.train} cannot be used"
            why = f"{larger} is not a multiple of {smaller}, so that their strata do not fit into each other"
            remedy = "let each size divide the next and the last one divide train, such as nested = [100, 200]"
            yield "nested", what, why, remedy


def _told(path: Path, content: dict, error: ValidationError) -> InputError:
    """The first problem in full, the others counted."""
    problems = error.errors(include_url=False)
    first, others = problems[0], len(problems) - 1
    *parents, key = first["loc"]
    name = next((part for part in reversed(first["loc"]) if isinstance(part, str)), key)
    where = f"{path}: {_place(content, parents)}{key}"
    if first["type"] == "missing":
        names = missing_beside(first, problems)
        others -= len(names) - 1
        told = MISSING_KEY(
            keys=f"{listed(names)} {'are' if len(names) > 1 else 'is'}", first=listed(names), where=where
        )
    elif first["type"] == "extra_forbidden":
        schema = StudyParameter if "parameters" in parents else StudyDefinition
        known = list(schema.model_fields)
        near = difflib.get_close_matches(str(key), known, 1)
        remedy = f"did you mean {near[0]!r}?" if near else None
        told = UNKNOWN_KEY(key=key, where=where, known=", ".join(known), remedy=remedy)
    else:
        why = reason_of(first)
        why = why[0].lower() + why[1:]
        told = UNUSABLE_VALUE(name=name, value=shown(first["input"]), where=where, why=why)
    told.what += f" (and {others} more after this one)" if others else ""
    return told


def _place(content: dict, parents: list) -> str:
    """Text for where a key stands, such as "[[parameters]] number 2 (jet), "."""
    if len(parents) < 2 or parents[0] != "parameters":
        return "".join(f"{parent}." for parent in parents)
    entry = content["parameters"][parents[1]]
    name = f" ({entry['name']})" if isinstance(entry, dict) and isinstance(entry.get("name"), str) else ""
    return f"[[parameters]] number {parents[1] + 1}{name}, " + "".join(f"{parent} " for parent in parents[2:])
