"""`billow fold`: the folded start of a case, step by step, and whether it is fit to run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from billow.cli.options import CaseFile, Settings, parse_settings


def fold(
    case_file: CaseFile,
    out: Annotated[Path, typer.Option(help="Result folder; must not exist yet.")],
    settings: Settings = None,
) -> None:
    """Fold the bag of a case without running it, and check the start. Exit code 1 if a check fails.

    Writes start.vtkhdf (a time for each fold, opens in ParaView), a picture of each step, and the table of checks as
    fold.md and fold.json.
    """
    from billow.apps.folding.folder import fold_case
    from billow.case.schema import Case

    checks = fold_case(Case.load(case_file).vary(parse_settings(settings)), out)
    record = json.loads((out / "fold.json").read_text(encoding="utf-8"))
    packed = " x ".join(f"{1e3 * extent:.4g}" for extent in record["packed_size"])
    print(f"{record['layers']} layers, {packed} mm")
    for check in checks:
        verdict = "ok" if check.passed else "FAILED"
        print(f"{verdict:<7}{check.name}: {check.measured:.4g} {check.unit}".rstrip())
    print(f"{out}: written")
    raise typer.Exit(0 if all(check.passed for check in checks) else 1)
