"""From TOML to a `Case`, with one clear message for whatever is wrong."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from billow.base.errors import InputError, shown
from billow.case import schema
from billow.case.bag.bags import BAGS
from billow.case.bag.build_mesh_bag import settle_files
from billow.case.fabric.curve_files import with_curves_inlined
from billow.case.obstacles.obstacles import OBSTACLES

VARIANTS = {**OBSTACLES, **BAGS}
"""Tables that a key `shape` chooses among."""
LARGEST_FILE = 1_000_000  # bytes; a case file is a few kilobytes

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
    "{key} is missing",
    where="{file}, key {key}",
    why="it has no default",
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


def load_case(path: str | Path) -> schema.Case:
    """Case from a TOML file. Raises InputError E-CASE-001 (no such file), E-CASE-002 (not TOML), and those of
    `validate`."""
    path = Path(path)
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_FILE + 1)  # a device such as /dev/zero never ends
        if len(content) > LARGEST_FILE:
            raise NOT_TOML(
                what=f"{path.name} is not a case file: it is too long",
                path=path,
                why=f"case files are text of at most {LARGEST_FILE} bytes",
                remedy="give the path of a TOML case",
            )
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise NOT_TOML(
            what=f"{path.name} is not a text file",
            where=f"{path}, byte {error.start}",
            why="TOML is UTF-8 text",
            remedy="save the file as UTF-8",
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a path that no file can have
        raise UNREADABLE(path=str(path), why=error) from None
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise NOT_TOML(name=path.name, path=path, why=error) from None
    settle_files(data, path.parent)
    return validate(with_curves_inlined(data, path.parent), str(path))


def validate(data: dict[str, Any], where: str) -> schema.Case:
    """Case from nested dictionaries.

    Raises InputError: E-CASE-003 unknown key, E-CASE-004 missing key, E-CASE-005 bad value.
    """
    try:
        return schema.Case.model_validate(data)
    except ValidationError as error:
        raise _explain(error, data, where) from None


def _explain(error: ValidationError, data: dict[str, Any], where: str) -> InputError:
    problems = error.errors(include_url=False)
    # Of a union every branch complains; the branch that got furthest speaks for it.
    # A table is never a misspelt number: there the branch of the curve is meant.
    problem = max(
        problems,
        key=lambda p: (p["type"] in ("range", "unit", "curve") and not isinstance(p["input"], dict), len(p["loc"])),
    )
    *path, last = problem["loc"] or ("case",)
    # A key of the user's may be called like a branch of a union; it stands last.
    named = problem["type"] in ("extra_forbidden", "missing")
    keys = [str(k) for k in path if not _is_branch(str(k))]
    keys += [str(last)] if named or not _is_branch(str(last)) else []
    key = ".".join(keys) or "case"
    more = f" ({len(problems) - 1} more)" if len(problems) > 1 and len({p["loc"][:2] for p in problems}) > 1 else ""
    if problem["type"] == "extra_forbidden":
        known = _known_keys(problem["loc"][:-1])
        close = difflib.get_close_matches(keys[-1], known, n=1)
        remedy = f"did you mean {close[0]!r}?" if close else None
        told = UNKNOWN_KEY(key=key, file=where, known=", ".join(known), remedy=remedy)
    elif problem["type"] == "missing":
        remedy = f"write a list of at least {last + 1} entries" if isinstance(last, int) else None
        told = MISSING_KEY(key=key, file=where, last=keys[-1], remedy=remedy)
    else:
        told = UNUSABLE_VALUE(
            key=key,
            value=shown(problem["input"]),
            file=where,
            why="a list is expected here" if problem["type"] == "tuple_type" else problem["msg"],
            remedy=(problem.get("ctx") or {}).get("try") or _remedy(problem, keys),
        )
    told.what += more
    return told


def _remedy(problem: dict[str, Any], keys: list[str]) -> str:
    if problem["type"] == "tuple_type" and isinstance(problem["input"], dict):
        return f"write [[{'.'.join(keys)}]] with two brackets: there may be several"
    expected = (problem.get("ctx") or {}).get("expected")
    if expected:
        return f"use {expected}"
    named = [key for key in keys if not key.isdigit()]
    meaning = " ".join((getattr(_find(problem["loc"]), "description", None) or "").split())
    meant = f" ({meaning[0].lower()}{meaning[1:].rstrip('.')})" if meaning else ""
    return f"correct {named[-1] if named else 'the file'}{meant}; docs/case.md gives unit and range"


def _is_branch(text: str) -> bool:
    """Whether a location part is pydantic's name of a union branch rather than a key."""
    return "[" in text or text in (*VARIANTS, "float") or text.startswith(("function", "constrained"))


def _known_keys(location: tuple) -> list[str]:
    """Keys of the table at a location."""
    found = _find(location)
    annotation = getattr(found, "annotation", found)
    options = [annotation, *getattr(annotation, "__args__", ())]
    table = next((o for o in options if hasattr(o, "model_fields")), None)
    return sorted(getattr(table, "model_fields", {}))


def _find(location: tuple) -> Any:
    """The table or field of the schema that a location of a problem leads to, as far as it does."""
    place: Any = schema.Case
    for part in map(str, location):
        if part in VARIANTS:
            place = VARIANTS[part]
            continue
        annotation = getattr(place, "annotation", place)
        tables = [o for o in (annotation, *getattr(annotation, "__args__", ())) if hasattr(o, "model_fields")]
        place = next((t.model_fields[part] for t in tables if part in t.model_fields), place)
    return place
