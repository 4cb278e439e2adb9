"""Editors are told of cases and studies what Billow itself accepts."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from pathlib import Path

import pytest

from billow.cli import demo
from billow.cli.main import main
from billow.cli.schema import schema_of

ROOT = Path(__file__).parents[2]
TYPES = {"string": str, "boolean": bool, "array": list, "object": dict, "integer": int, "number": (int, float)}


def problems(value, schema: dict, whole: dict, place: str = "") -> list[str]:
    """What of JSON schema is used here, and no more."""
    if "$ref" in schema:
        return problems(value, whole["$defs"][schema["$ref"].rpartition("/")[2]], whole, place)
    if "anyOf" in schema:
        tried = [problems(value, choice, whole, place) for choice in schema["anyOf"]]
        return [] if [] in tried else min(tried, key=len)
    if "const" in schema and value != schema["const"]:
        return [f"{place} is {value!r}"]
    if "enum" in schema and value not in schema["enum"]:
        return [f"{place} is {value!r}"]
    kind = schema.get("type")
    if kind == "null":
        return [f"{place} is not null"]
    if kind and (not isinstance(value, TYPES[kind]) or (isinstance(value, bool) and kind != "boolean")):
        return [f"{place} is no {kind}"]
    found = []
    if kind in ("integer", "number") and not schema.get("minimum", value) <= value <= schema.get("maximum", value):
        found.append(f"{place} is out of range")
    if kind == "string" and not re.search(schema.get("pattern", ""), value):
        found.append(f"{place} is another text")
    if kind == "array":
        for k, item in enumerate(value):
            items = schema["prefixItems"][k] if k < len(schema.get("prefixItems", ())) else schema.get("items", {})
            found += problems(item, items, whole, f"{place}[{k}]")
    if kind == "object":
        found += [f"{place}.{key} is missing" for key in schema.get("required", ()) if key not in value]
        for key, item in value.items():
            further = schema.get("additionalProperties", {})
            inner = schema.get("properties", {}).get(key, further)
            found += [f"{place}.{key} is unknown"] if inner is False else problems(item, inner, whole, f"{place}.{key}")
    return found


NO_CASES = ("study", "tank", "goals", "design.toml", "scatter")
CASES = sorted(path for path in (ROOT / "examples").rglob("*.toml") if not any(word in path.name for word in NO_CASES))
STUDIES = sorted((ROOT / "examples").rglob("study*.toml"))


def test_examples_fit_their_schema():
    case, study = schema_of("case"), schema_of("study")
    texts = [demo.CASE, *(path.read_text(encoding="utf-8") for path in CASES)]
    assert [problems(tomllib.loads(text), case, case) for text in texts] == [[]] * len(texts)
    texts = [demo.STUDY.format(train=8, test=2), *(path.read_text(encoding="utf-8") for path in STUDIES)]
    assert [problems(tomllib.loads(text), study, study) for text in texts] == [[]] * len(texts)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("[bag]\ndiametre = 0.7", ".bag.diametre is unknown"),
        ("[fabric]\nthickness = 0.3", ".fabric.thickness is out of range"),
        ("[fabric]\nlaw = 'cotton'", ".fabric.law is 'cotton'"),
        ("[run]\nframes = 1.5", ".run.frames is no integer"),
    ],
)
def test_mistakes_are_marked(text, found):
    case = schema_of("case")
    assert found in problems(tomllib.loads(text), case, case)


def test_the_command_prints_it(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["billow", "schema", "study"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert json.loads(capsys.readouterr().out) == schema_of("study")
