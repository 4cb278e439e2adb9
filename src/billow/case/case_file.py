"""From TOML to the schema of a case, with one clear message for whatever is wrong.

It knows no schema of its own: `model` is the pydantic class to fill, and its keys are found from its fields.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import ValidationError

from billow.base.attribute_docstrings import attribute_docstrings
from billow.base.errors import InputError, shown
from billow.base.toml_file import read_toml
from billow.case.named_files import curve_files, with_files_settled
from billow.case.quantity import Strict, listed, missing_beside, reason_of

Model = TypeVar("Model", bound=Strict)

UNREADABLE = InputError.declare(
    "E-CASE-001",
    "cannot read the case file {path!r}",
    where="{path!r}",
    cause="a misspelt path, or no permission",
    remedy="check the path; `billow check --example` prints a case to start from",
)
NOT_TOML = InputError.declare(
    "E-CASE-002",
    "{name} is not valid TOML",
    where="{path}",
    cause="a missing quote or bracket, a key written twice, or a file of another kind",
    remedy="correct that line; see docs/case.md for an example",
)
UNKNOWN_KEY = InputError.declare(
    "E-CASE-003",
    "unknown key {key!r}",
    where="{file}, key {key}",
    why="no setting has this name",
    cause="a misspelt key, or one in the wrong table",
    remedy="known keys here: {known}",
)
MISSING_KEY = InputError.declare(
    "E-CASE-004",
    "{keys} missing in {table}",
    where="{file}, key {key}",
    why="there is no default",
    cause="a curve with times and no values",
    remedy="add {last}; docs/case.md describes it",
)
UNUSABLE_VALUE = InputError.declare(
    "E-CASE-005",
    "{key} = {value} cannot be used",
    where="{file}, key {key}",
    cause="a number in another unit, outside its plausible range; a text where a number belongs; quantities that "
    "contradict each other",
    remedy='write the unit, for example thickness = "0.3 mm"; docs/case.md gives units and ranges',
)


def load_case(model: type[Model], path: str | Path) -> Model:
    """Case from a TOML file. Raises InputError E-CASE-001 (no such file), E-CASE-002 (not TOML), and those of
    `validate`."""
    path = Path(path)
    try:
        data = read_toml(path)
    except OSError as error:
        raise UNREADABLE(path=str(path), why=error) from None
    except ValueError as error:
        raise NOT_TOML(name=path.name, path=path, why=error) from None
    settled = with_files_settled(data, path.parent)
    try:
        return validate(model, settled, str(path))
    except InputError as error:
        error.where += "".join(f", from {file}" for key, file in curve_files(data) if f" {key}." in error.where)
        raise


def validate(model: type[Model], data: dict[str, Any], where: str) -> Model:
    """Case from nested dictionaries.

    Raises InputError: E-CASE-003 unknown key, E-CASE-004 missing key, E-CASE-005 bad value.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise _explain(error, model, where) from None


def _explain(error: ValidationError, model: type[Strict], where: str) -> InputError:
    problems = error.errors(include_url=False)
    # Every branch of a union reports a problem; the one that got furthest is shown. A table is never a misspelt number:
    # the branch of the curve is meant.
    problem = max(
        problems,
        key=lambda p: (
            p["type"] in ("range", "unit", "curve") and not isinstance(p["input"], dict),
            len(p["loc"]),
            p["type"] == "extra_forbidden",  # a misspelt key is also missing
        ),
    )
    *path, last = problem["loc"] or ("case",)
    # A user's key may have the name of a union branch; it comes last.
    named = problem["type"] in ("extra_forbidden", "missing")
    variants = set(_variants(model))
    keys = [str(k) for k in path if not _is_branch(str(k), variants)]
    keys += [str(last)] if named or not _is_branch(str(last), variants) else []
    key = ".".join(keys) or "case"
    others = len(problems) - 1 if len({p["loc"][:2] for p in problems}) > 1 else 0
    if problem["type"] == "extra_forbidden":
        tables = _tables(_find(model, problem["loc"][:-1])[0])
        known = sorted({field for table in tables for field in table.model_fields})
        close = difflib.get_close_matches(keys[-1], known, n=1)
        remedy = f"did you mean {close[0]!r}?" if close else None
        told = UNKNOWN_KEY(key=key, file=where, known=", ".join(known), remedy=remedy)
    elif problem["type"] == "missing":
        names, remedy = missing_beside(problem, problems), None
        others = max(others - len(names) + 1, 0)
        if isinstance(last, int):
            names, remedy = [f"entry {last + 1}"], f"write a list of at least {last + 1} entries"
        table, said = ".".join(keys[:-1]) or "the file", f"{listed(names)} {'are' if len(names) > 1 else 'is'}"
        told = MISSING_KEY(keys=said, table=table, key=key, file=where, last=listed(names), remedy=remedy)
    else:
        told = UNUSABLE_VALUE(
            key=key,
            value=shown(problem["input"]),
            file=where,
            why=reason_of(problem),
            remedy=(problem.get("ctx") or {}).get("try") or _remedy(model, problem, keys),
        )
    told.what += f" ({others} more)" if others else ""
    return told


def _remedy(model: type[Strict], problem: dict[str, Any], keys: list[str]) -> str:
    if problem["type"] == "tuple_type" and isinstance(problem["input"], dict):
        return f"write [[{'.'.join(keys)}]] with two brackets: there may be several"
    expected = (problem.get("ctx") or {}).get("expected")
    if expected:
        return f"use {expected}"
    named = [key for key in keys if not key.isdigit()]
    meaning = " ".join(_find(model, problem["loc"])[1].split())
    meant = f" ({meaning[0].lower()}{meaning[1:].rstrip('.')})" if meaning else ""
    return f"correct {named[-1] if named else 'the file'}{meant}; docs/case.md gives unit and range"


def _is_branch(text: str, variants: set[str]) -> bool:
    """Whether a location part is pydantic's name of a union branch rather than a key."""
    return "[" in text or text in ("float", "bool") or text in variants or text.startswith(("function", "constrained"))


def _find(model: type[Strict], location: tuple) -> tuple[Any, str]:
    """The table or field of the schema that a location of a problem leads to, as far as it does, and what the text
    below the field says."""
    place: Any = model
    meaning = ""
    for part in map(str, location):
        tables = list(_tables(place))
        variant = next((t for t in tables if part in _choices(t)), None)
        owner = next((t for t in tables if part in t.model_fields), None)
        if variant:
            place, meaning = variant, ""
        elif owner:
            place, meaning = owner.model_fields[part], attribute_docstrings(owner).get(part, "")
    return place, meaning


def _tables(place: Any) -> Iterator[type[Strict]]:
    """The tables that a model, a field, or the annotation of one allows."""
    annotation = getattr(place, "annotation", place)
    if isinstance(annotation, type) and hasattr(annotation, "model_fields"):
        yield annotation
    for option in get_args(annotation):
        yield from _tables(option)


def _choices(table: type[Strict]) -> tuple[str, ...]:
    """Values of the key `shape` or `kind` that choose this table among others."""
    chooser = table.model_fields.get(table.chooser)
    return get_args(chooser.annotation) if chooser else ()


def _variants(model: type[Strict]) -> Iterator[str]:
    """All values of keys that choose between tables of a schema."""
    yield from _choices(model)
    for field in model.model_fields.values():
        for table in _tables(field):
            yield from _variants(table)
