"""Write docs/study.md from the schema of the study, so that the reference cannot drift from the code.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from billow.cli.demo import STUDY
from billow.cli.schema import schema_of

TARGET = Path(__file__).with_name("study.md")

INTRODUCTION = f"""# The study file

A study varies a case: `billow study study.toml --out my_study` draws designs, simulates each, and makes a dataset of
them. A study is one TOML file. Unknown keys are refused. The effective study, with every default, is kept in the study
folder.

The study of `billow demo`:

```toml
{STUDY.format(train=48, test=12).strip()}
```

`billow schema study` prints the JSON schema of this file, and `billow schema case` that of a case: an editor that knows
TOML schemas then completes keys and marks mistakes. With Taplo (Even Better TOML), save it as `study.schema.json` and
begin the study with the line `#:schema ./study.schema.json`.
"""


TABLES = {
    "`[[parameters]]`": "StudyParameter",
    "`[[factors]]`": "StudyFactor",
    "`[[factors.levels]]`": "StudyLevel",
    "`[[constraints]]`": "StudyConstraint",
    "`[[responses]]`": "StudyResponse",
    "`[responses.limit]`": "Limit",
}
"""Title of each table -> its schema."""


def render() -> str:
    """The whole page."""
    schema = schema_of("study")
    tables = [line for title, name in TABLES.items() for line in _table(title, schema["$defs"][name])]
    return "\n".join([INTRODUCTION, *_table("Top level", schema), *tables])


def _table(title: str, table: dict[str, Any]) -> list[str]:
    rows = []
    for key, told in table["properties"].items():
        default = "required" if key in table.get("required", ()) else f"`{json.dumps(told.get('default'))}`"
        default = "none" if default == "`null`" else default
        rows.append(f"| `{key}` | {_kind(told)} | {default} | {' '.join(told['description'].split())} |")
    return [f"## {title}", "", "| key | type, range | default | meaning |", "|---|---|---|---|", *rows, ""]


def _kind(told: dict[str, Any]) -> str:
    if "enum" in told:
        return " or ".join(f"`{word}`" for word in told["enum"])
    if "anyOf" in told:
        return _kind(told["anyOf"][0])
    if told.get("type") == "array":
        if "prefixItems" in told:
            return f"list of {len(told['prefixItems'])} numbers"
        items = told["items"]
        return "tables" if "$ref" in items else f"list of {_kind(items)}"
    if "$ref" in told or told.get("type") == "object":
        return "table"
    word = {"string": "text", "integer": "whole number", "number": "number", "boolean": "true or false"}[told["type"]]
    low, high = told.get("minimum"), told.get("maximum")
    if "exclusiveMinimum" in told:
        return f"{word} above {told['exclusiveMinimum']:g}"
    if low is not None and high is not None:
        return f"{word}, {low} to {high}"
    return word if low is None else f"{word}, from {low}"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
