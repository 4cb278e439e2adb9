"""`billow schema`: the JSON schema of case and study files, for editors."""

from __future__ import annotations

import json
from enum import StrEnum
from typing import Annotated, Any

import typer


class Kind(StrEnum):
    """Files that have a schema."""

    CASE = "case"
    STUDY = "study"


NAMED_FILES = ("YarnCurve", "ShearCurve")
"""Tables in whose place a case may name a file."""


def schema(kind: Annotated[Kind, typer.Argument(help="case or study.")]) -> None:
    """Print the JSON schema of case or study files: editors then complete keys and mark mistakes.

    Save it as case.schema.json and begin a case with the line #:schema ./case.schema.json
    """
    print(json.dumps(schema_of(kind.value), indent=1))


def schema_of(kind: str) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of "case" or "study" files."""
    from billow.case.schema import Case
    from billow.study.definition import StudyDefinition

    model = Case if kind == "case" else StudyDefinition
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_for_editors(model.model_json_schema())}


def _for_editors(part: Any) -> Any:
    """A file may leave out the key that chooses between tables, and name a file in place of a curve."""
    if isinstance(part, list):
        return [_for_editors(item) for item in part]
    if not isinstance(part, dict):
        return part
    made = {("anyOf" if key == "oneOf" else key): _for_editors(value) for key, value in part.items()}
    if isinstance(made.get("discriminator"), dict):
        del made["discriminator"]
    if str(made.get("$ref", "")).endswith(NAMED_FILES):
        made = {"anyOf": [{"$ref": made.pop("$ref")}, {"type": "string"}], **made}
    return made
