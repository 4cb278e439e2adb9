"""Write docs/errors.md from the catalogue of codes, so that the page cannot drift from the code.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

from pathlib import Path

from billow.base.errors import BillowError, InputError, IntegrityError, NumericalStop, ResourceError
from billow.error_catalogue import CATALOGUE, GROUPS

TARGET = Path(__file__).with_name("errors.md")

EXIT_CODES = (
    (0, "done"),
    (1, "done, and something failed: a run of a study, a verification case"),
    (InputError.exit_code, "input: what was written cannot be used"),
    (NumericalStop.exit_code, "stop: a run became meaningless; its results so far are kept"),
    (ResourceError.exit_code, "resource: disk, memory, worker processes"),
    (IntegrityError.exit_code, "integrity: a file is damaged or does not belong to its manifest"),
    (BillowError.exit_code, "a mistake in Billow itself"),
    (130, "interrupted with Ctrl-C"),
)
KINDS = {
    InputError: "input",
    NumericalStop: "stop",
    ResourceError: "resource",
    IntegrityError: "integrity",
    BillowError: "mistake in Billow",
}

INTRODUCTION = f"""# Errors and warnings

Every message answers four questions, and begins with a code that never changes its meaning:

```
E-CASE-005 error: fabric.thickness = 0.3 cannot be used
  where: bag.toml, key fabric.thickness
  why:   0.3 m is outside the plausible range 1e-05 to 0.005 m
  try:   write "0.3 mm" or "0.3 cm" if that is meant
```

Commands end with one of these exit codes:

| exit code | meaning |
|---|---|
{chr(10).join(f"| {code} | {meaning} |" for code, meaning in EXIT_CODES)}

Codes that begin with W are warnings: the run goes on, keeps them in its record, and its verdict is at best REVIEW.
"""


def render() -> str:
    """The whole page: one section for each code."""
    parts, group = [INTRODUCTION], ""
    for code, entry in sorted(CATALOGUE.items()):
        letter, middle, _ = code.split("-")
        if group != letter + middle:
            group = letter + middle
            parts.append(f"## {GROUPS[middle]}{' (warnings)' if letter == 'W' else ''}\n")
        kind = "warning" if entry.kind is None else f"{KINDS[entry.kind]}, exit code {entry.kind.exit_code}"
        parts.append(
            f"### {code}\n\n{entry.meaning} *{kind}*\n\n- usual cause: {entry.cause}\n- what helps: {entry.remedy}\n"
        )
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
