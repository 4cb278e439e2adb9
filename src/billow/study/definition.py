"""study.toml: the case of a study, its parameters, and the numbers of runs (docs/rom.md, The study file)."""

from __future__ import annotations

import difflib
import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tomli_w
from pydantic import Field, ValidationError

from billow.base.errors import InputError, shown
from billow.base.plausible import require_possible
from billow.base.toml_file import read_toml
from billow.case.quantity import listed, missing_beside, reason_of
from billow.results.dataset_files import Parameter
from billow.study.responses import StudyResponse
from billow.study.variables import StrictTable, StudyConstraint, StudyFactor, StudyLevel, StudyParameter, Text, Variable

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


class StudyDefinition(StrictTable):
    """The content of a study.toml. reference_length: [m]."""

    title: Text
    """Title of the study and of what is learned from it."""
    case: Text
    """Path of the case file that is varied, from the folder of the study file."""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """Chooses the designs; the same seed gives the same ones."""
    train: Annotated[int, Field(ge=2, le=MOST_RUNS)]
    """Number of training runs, drawn as `sampling` says."""
    test: Annotated[int, Field(ge=1, le=MOST_RUNS)]
    """Number of unseen runs, to measure accuracy with: another Latin hypercube."""
    nested: Annotated[tuple[Annotated[int, Field(ge=2)], ...], Field(strict=False, max_length=100)] = ()
    """Smaller numbers of training runs, ascending, that are to be Latin hypercubes, too."""
    added_designs: Text | None = None
    """Path of a table of further training designs (CSV), as `billow suggest` writes it."""
    sampling: Literal["lhs", "sobol", "maximin"] = "lhs"
    """Design of the training runs: a random Latin hypercube, a scrambled Sobol' sequence, which may be continued by any
    number of runs, or the Latin hypercube of many whose nearest points lie farthest apart."""
    same_mesh: bool = True
    """Whether all runs must have one mesh and the same times, as a surrogate of the moving bag needs; false if only
    responses are of interest, for parameters such as the number of folds."""
    reference_length: Annotated[float, Field(gt=0)]
    """Length [m] to which errors are compared, such as the diameter of the bag."""
    parameters: Annotated[tuple[StudyParameter, ...], Field(strict=False, min_length=1, max_length=100)]
    """The axes of the design space."""
    factors: Annotated[tuple[StudyFactor, ...], Field(strict=False, max_length=20)] = ()
    """Choices between levels, further axes."""
    constraints: Annotated[tuple[StudyConstraint, ...], Field(strict=False, max_length=100)] = ()
    """Linear conditions that every design fulfils; with sampling = "lhs" or "maximin" the study cannot grow then."""
    responses: Annotated[tuple[StudyResponse, ...], Field(strict=False, max_length=100)] = ()
    """Numbers that are read off each run; without any, a set that fits the case."""

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
    def variables(self) -> tuple[Variable, ...]:
        """Parameters and factors: every axis of the design space, in the order of a design's values."""
        return (*self.parameters, *self.factors)

    @property
    def axes(self) -> tuple[Parameter, ...]:
        """The variables in the form that a dataset uses."""
        return tuple(variable.axis for variable in self.variables)

    def allows(self, values: np.ndarray) -> np.ndarray:
        """Whether designs (designs, variables) fulfil every constraint: (designs,) bool."""
        names = [variable.name for variable in self.variables]
        allowed = np.ones(len(values), bool)
        for constraint in self.constraints:
            allowed &= constraint.holds(values, names)
        return allowed

    @property
    def steps(self) -> dict[str, float]:
        """Step of each parameter that has one, counted from its low end."""
        return {p.name: p.step for p in self.parameters if p.step is not None}

    def drawable(self, values: np.ndarray) -> np.ndarray:
        """Designs (designs, variables) brought to the steps of their parameters, without those that break a
        constraint."""
        values = np.array(values, float)
        for k, variable in enumerate(self.variables):
            if variable.name in self.steps:
                values[:, k] = [variable.stepped(value) for value in values[:, k].tolist()]
        return values[self.allows(values)]

    @property
    def own_starts(self) -> bool:
        """Whether each run may have a start shape of its own: a size of the bag is among the variables."""
        return any(key.startswith("bag.") for variable in self.variables for key in variable.keys)

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
    "middle": ("values are drawn about it", "give a middle between low and high"),
    "spread": ("the logarithms of values are spread by its logarithm", "give a factor above 1, such as 1.2"),
    "shape": ("uniform values have no middle", "give distribution = 'normal' or 'triangular', or leave it out"),
    "step": ("there would be one value", "give a step that fits into the range"),
    "term": ("a constraint is on parameters of the study", "use the names of [[parameters]]"),
    "bound": ("nothing would be asked", "give at_least or at_most"),
    "logarithm": ("only positive values have a logarithm", "give a low above 0, or scale = 'linear'"),
}  # fmt: skip
"""What several entries do not agree on -> why that cannot be, and what to do."""


def _contradictions(definition: StudyDefinition) -> Iterator[tuple[str, str, str, str]]:
    """What only a look at several entries shows: where, what, why and remedy of each contradiction."""
    owners: dict[str, str] = {}
    names = [variable.name for variable in definition.variables]
    for number, variable in enumerate(definition.variables, start=1):
        kind = "parameters" if isinstance(variable, StudyParameter) else "factors"
        where = f"[[{kind}]] number {number - (kind == 'factors') * len(definition.parameters)} ({variable.name})"
        if variable.name in names[: number - 1]:
            yield where, f"two parameters are called {variable.name!r}", *_REASONS["name"]
        if isinstance(variable, StudyParameter):
            for what, reason in _of_parameter(variable):
                yield where, what, *_REASONS[reason]
        for key in variable.keys:
            if key in owners:
                why = f"it is also among the keys of {owners[key]!r}"
                remedy = "let each case entry belong to one parameter"
                yield where, f"the case entry {key!r} is varied twice", why, remedy
            owners[key] = variable.name
    for number, constraint in enumerate(definition.constraints, start=1):
        where = f"[[constraints]] number {number}"
        unknown = [name for name in constraint.terms if name not in names]
        if unknown:
            yield where, f"there is no parameter {unknown[0]!r}", *_REASONS["term"]
        if constraint.at_least is None and constraint.at_most is None:
            yield where, "it has neither at_least nor at_most", *_REASONS["bound"]
    if definition.nested and (definition.constraints or definition.sampling == "sobol"):
        what = f"nested = {list(definition.nested)} does not go with constraints or sampling = 'sobol'"
        why = "nested Latin hypercubes fill strata of the whole space; the first runs of a sequence are one anyway"
        yield "nested", what, why, "leave nested out"
    shown_names = [response.name for response in definition.responses]
    for number, response in enumerate(definition.responses, start=1):
        where = f"[[responses]] number {number} ({response.name})"
        if response.name in shown_names[: number - 1]:
            yield where, f"two responses are called {response.name!r}", *_REASONS["name"]
        for what, why, remedy in response.contradictions():
            yield where, what, why, remedy
    if definition.sampling == "sobol":
        return
    for smaller, larger in itertools.pairwise(definition.sizes):
        if larger <= smaller or larger % smaller:
            what = f"nested = {list(definition.nested)} with train = {definition.train} cannot be used"
            why = f"{larger} is not a multiple of {smaller}, so that their strata do not fit into each other"
            remedy = "let each size divide the next and the last one divide train, such as nested = [100, 200]"
            yield "nested", what, why, remedy


def _of_parameter(parameter: StudyParameter) -> Iterator[tuple[str, str]]:
    """What contradicts itself in one parameter, and which of `_REASONS` it is."""
    low, high, middle = parameter.low, parameter.high, parameter.middle
    if not low < high:
        yield f"low = {low:g} is not below high = {high:g}", "range"
    if parameter.scale == "log" and low <= 0:
        yield f"low = {low:g} with scale = 'log'", "logarithm"
    if middle is not None and not low <= middle <= high:
        yield f"middle = {middle:g} is not between low and high", "middle"
    if parameter.distribution == "uniform" and (middle is not None or parameter.deviation is not None):
        yield "middle or deviation with distribution = 'uniform'", "shape"
    if parameter.distribution == "triangular" and parameter.deviation is not None:
        yield "deviation with distribution = 'triangular'", "shape"
    if parameter.scale == "log" and parameter.deviation is not None and parameter.deviation <= 1.0:
        yield f"deviation = {parameter.deviation:g} with scale = 'log'", "spread"
    if parameter.step is not None and parameter.step > (high - low) * (1.0 + 1e-12):
        yield f"step = {parameter.step:g} is larger than the range", "step"


_SCHEMAS = {
    "parameters": StudyParameter,
    "factors": StudyFactor,
    "levels": StudyLevel,
    "constraints": StudyConstraint,
    "responses": StudyResponse,
}
"""Table of each list of a study file."""


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
        schema = next((_SCHEMAS[part] for part in reversed(parents) if part in _SCHEMAS), StudyDefinition)
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
    if len(parents) < 2 or parents[0] not in _SCHEMAS:
        return "".join(f"{parent}." for parent in parents)
    entry = content[parents[0]][parents[1]]
    name = f" ({entry['name']})" if isinstance(entry, dict) and isinstance(entry.get("name"), str) else ""
    return f"[[{parents[0]}]] number {parents[1] + 1}{name}, " + "".join(f"{parent} " for parent in parents[2:])
