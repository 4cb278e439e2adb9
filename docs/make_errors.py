"""Write docs/errors.md from the codes that the modules of Billow declare, so that the page cannot drift from the code.

`make docs` runs it; a test compares its output with the file.
"""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path
from string import Formatter

import billow
from billow.base.errors import (
    CODES,
    BillowError,
    Code,
    Concern,
    InputError,
    IntegrityError,
    NumericalStop,
    ResourceError,
)

TARGET = Path(__file__).with_name("errors.md")

GROUPS = {
    "CASE": "The case file",
    "CLI": "The command line",
    "CMP": "Comparisons",
    "CONV": "Convergence studies",
    "CPL": "Force inputs and coupled models",
    "DCK": "Decks of LS-DYNA",
    "DES": "Design tools",
    "FAB": "Fabric",
    "GAS": "Gas",
    "GEO": "Geometry",
    "INJ": "Injury metrics",
    "MESH": "Mesh",
    "NUM": "Runs that are stopped",
    "OBS": "Obstacles",
    "PAG": "Pages for a browser",
    "PIC": "Pictures",
    "RES": "Results, datasets and interrupted runs",
    "ROM": "Surrogates",
    "STU": "Studies",
    "TANK": "Tank tests",
    "UNIT": "Units",
}
"""What the middle of a code stands for."""

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

```text
E-CASE-005 error: fabric.thickness = 0.3 cannot be used
  where: bag.toml, key fabric.thickness
  why:   0.3 m is outside the plausible range 1e-05 to 0.005 m
  try:   write "0.3 mm" or "0.3 cm" if that is meant
```

Commands end with one of these exit codes:

| exit code | meaning |
|---|---|
{chr(10).join(f"| {code} | {meaning} |" for code, meaning in EXIT_CODES)}

Codes that begin with W are warnings: the run continues, its record keeps them, and its verdict is at best REVIEW.
In the texts below, _words like this_ stand for what the message fills in. A message may replace a text by one that fits
its cause more closely.
"""


def codes() -> dict[str, Code]:
    """Every code of the package, in the order of the page; imports all modules, so that all have declared theirs."""
    for module in pkgutil.walk_packages(billow.__path__, "billow."):
        importlib.import_module(module.name)
    return dict(sorted(CODES.items()))


def readable(template: str) -> str:
    """A template with its placeholders as words."""
    parts = Formatter().parse(template)
    return "".join(text + (f"_{name.replace('_', ' ')}_" if name else "") for text, name, _, _ in parts)


def render() -> str:
    """The whole page: one section for each code."""
    parts, group = [INTRODUCTION], ""
    for name, code in codes().items():
        letter, middle, _ = name.split("-")
        if group != letter + middle:
            group = letter + middle
            parts.append(f"## {GROUPS[middle]}{' (warnings)' if letter == 'W' else ''}\n")
        parts.append(_section(code))
    return "\n".join(parts).rstrip() + "\n"


def _says_something(template: str) -> bool:
    """Whether a template is more than one placeholder, such as a path."""
    return any(text for text, *_ in Formatter().parse(template))


def _section(code: Code) -> str:
    kind = "warning" if code.kind is Concern else f"{KINDS[code.kind]}, exit code {code.kind.exit_code}"
    what = readable(code.what).rstrip(".")
    if what.split()[0].isalpha():
        what = what[0].upper() + what[1:]
    lines = {"where": code.where, "why": code.why, "usual cause": code.cause, "what helps": code.remedy}
    listed = "".join(f"- {name}: {readable(text)}\n" for name, text in lines.items() if _says_something(text))
    return f"### {code.code}\n\n{what}. *{kind}*\n\n{listed}"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
