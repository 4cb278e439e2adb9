"""study.toml: what a study varies, how often, and around which case.

title = "Driver bag against a locked obstacle"
case = "driver_locked.toml"       # relative to this file
seed = 1
train = 48
test = 12
reference_length = 0.28           # [m], to which errors are compared

[[parameters]]
name = "permeability"
label = "Airbag permeability"
unit = "-"
low = 0.02
high = 0.035
keys = ["fabric.permeability"]    # entries of the case that take the value
scale = "linear"                  # or "log": drawn evenly in the logarithm
"""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Annotated, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from billow.errors import InputError
from billow.results.dataset_files import Parameter

_STRICT = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)
_Text = Annotated[str, Field(min_length=1)]


class StudyParameter(BaseModel):
    """One axis of the design space; low and high are in `unit`, which is the unit of the case's entries `keys`."""

    model_config = _STRICT

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
    label: _Text
    unit: Annotated[str, Field(pattern=r"^[^\[\]]+$")]
    low: float
    high: float
    keys: Annotated[tuple[_Text, ...], Field(strict=False, min_length=1)]
    scale: Literal["linear", "log"] = "linear"


class StudyDefinition(BaseModel):
    """Everything a study.toml says. reference_length: [m]."""

    model_config = _STRICT

    title: _Text
    case: _Text
    seed: Annotated[int, Field(ge=0)]
    train: Annotated[int, Field(ge=2)]
    test: Annotated[int, Field(ge=1)]
    reference_length: Annotated[float, Field(gt=0)]
    parameters: Annotated[tuple[StudyParameter, ...], Field(strict=False, min_length=1)]

    @classmethod
    def load(cls, path: str | Path) -> StudyDefinition:
        """Read and check a study.toml.

        InputError E-STU-001: no such file; -002: not TOML; -003: unknown key; -004: a value that cannot be used;
        -005: a key is missing; -006: the case file does not exist.
        """
        path = Path(path)
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(
                "E-STU-001",
                "the study file cannot be read",
                where=str(path),
                why=error.strerror or str(error),
                remedy="check the path; an example is in examples/",
            ) from error
        except ValueError as error:  # TOML and UTF-8 alike
            raise InputError(
                "E-STU-002",
                "the study file is not valid TOML",
                where=str(path),
                why=str(error),
                remedy='write texts in quotes and numbers without, such as title = "Driver bag", train = 48',
            ) from error
        try:
            definition = cls.model_validate(content)
        except ValidationError as error:
            raise _told(path, content, error) from error
        _check_parameters(path, definition.parameters)
        case = path.parent / definition.case
        if not case.is_file():
            raise InputError(
                "E-STU-006",
                f"the case file {definition.case} does not exist",
                where=f"{path}: case",
                why=f"it was looked for at {case}",
                remedy="give its path relative to the study file",
            )
        return definition

    @property
    def axes(self) -> tuple[Parameter, ...]:
        """The parameters as a dataset knows them."""
        return tuple(Parameter(p.name, p.label, p.unit, p.low, p.high) for p in self.parameters)

    def to_toml(self) -> str:
        """The text of a study.toml with every default filled in."""
        return tomli_w.dumps(self.model_dump(mode="json"))


def _check_parameters(path: Path, parameters: tuple[StudyParameter, ...]) -> None:
    """What only a look at several entries shows."""
    names: set[str] = set()
    owners: dict[str, str] = {}
    for number, parameter in enumerate(parameters, start=1):
        where = f"{path}: [[parameters]] number {number} ({parameter.name})"

        def refuse(what: str, why: str, remedy: str, where=where) -> InputError:
            return InputError("E-STU-004", what, where=where, why=why, remedy=remedy)

        if parameter.name in names:
            raise refuse(
                f"two parameters are called {parameter.name!r}",
                "results are stored by parameter name",
                "give each parameter its own name",
            )
        names.add(parameter.name)
        if not parameter.low < parameter.high:
            raise refuse(
                f"low = {parameter.low:g} is not below high = {parameter.high:g}",
                "a parameter needs a range to be drawn from",
                "swap low and high, or set the value in the case instead of varying it",
            )
        if parameter.scale == "log" and parameter.low <= 0:
            raise refuse(
                f"low = {parameter.low:g} with scale = 'log'",
                "only positive values have a logarithm",
                "give a low above 0, or scale = 'linear'",
            )
        for key in parameter.keys:
            if key in owners:
                raise refuse(
                    f"the case entry {key!r} is varied twice",
                    f"it is also among the keys of {owners[key]!r}",
                    "let each case entry belong to one parameter",
                )
            owners[key] = parameter.name


def _told(path: Path, content: dict, error: ValidationError) -> InputError:
    """The first problem in full, the others counted."""
    problems = error.errors(include_url=False)
    first = problems[0]
    *parents, key = first["loc"]
    where = f"{path}: {_place(content, parents)}{key}"
    others = f" (and {len(problems) - 1} more after this one)" if len(problems) > 1 else ""
    if first["type"] == "missing":
        return InputError(
            "E-STU-005",
            f"the key {key!r} is missing{others}",
            where=where,
            why="it has no default",
            remedy=f"add {key} = ...; an example is in examples/",
        )
    if first["type"] == "extra_forbidden":
        schema = StudyParameter if "parameters" in parents else StudyDefinition
        known = list(schema.model_fields)
        near = difflib.get_close_matches(str(key), known, 1)
        return InputError(
            "E-STU-003",
            f"{key!r} is not a known key{others}",
            where=where,
            why=f"known here are {', '.join(known)}",
            remedy=f"did you mean {near[0]!r}?" if near else "remove it, or correct its spelling",
        )
    return InputError(
        "E-STU-004",
        f"{key} = {first['input']!r} cannot be used{others}",
        where=where,
        why=first["msg"][0].lower() + first["msg"][1:],
        remedy="correct the value; an example is in examples/",
    )


def _place(content: dict, parents: list) -> str:
    """Text for where a key stands, such as "[[parameters]] number 2 (jet), "."""
    if len(parents) < 2 or parents[0] != "parameters":
        return "".join(f"{parent}." for parent in parents)
    entry = content["parameters"][parents[1]]
    name = f" ({entry['name']})" if isinstance(entry, dict) and isinstance(entry.get("name"), str) else ""
    return f"[[parameters]] number {parents[1] + 1}{name}, " + "".join(f"{parent} " for parent in parents[2:])
