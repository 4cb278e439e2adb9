"""What is compared: runs, predictions, tests, or what a surrogate says of the design of another side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from billow.apps.compare.side import Side
from billow.base.errors import InputError
from billow.pictures.source import open_source

TWO_SURROGATES = InputError.declare(
    "E-CMP-002",
    "two surrogates need design values",
    where="billow compare",
    why="there is no run whose design they could answer for",
    remedy="give the design: --set NAME=VALUE for each parameter",
)

SURROGATE = ".safetensors"


def open_sides(paths: Sequence[Path], labels: Sequence[str], design: Mapping[str, float] | None) -> list[Side]:
    """The sides. design: values of a surrogate's parameters; by default those of the last side that is no surrogate.

    InputError E-CMP-001, E-CMP-002, and the errors of `open_source`, `Surrogate.load` and `Surrogate.predict`.
    """
    sides: dict[int, Side] = {}
    models = [k for k, path in enumerate(paths) if path.suffix.lower() == SURROGATE and path.is_file()]
    if len(models) == len(paths) and design is None:
        raise TWO_SURROGATES()
    for k, path in enumerate(paths):
        if k not in models:
            source = open_source(path, "compare", labels[k])
            sides[k] = Side(source, source.histories, source.fabric)
    asked = max(sides, default=None)
    for k in models:
        from billow.apps.compare.model_side import answer  # runs alone need nothing of reduced-order models

        there = None if asked is None else sides[asked]
        sides[k] = answer(paths[k], labels[k], there, design)
    return [sides[k] for k in range(len(paths))]
