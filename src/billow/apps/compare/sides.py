"""What is compared: a run, a prediction, a test, or what a surrogate says of the design of the other side."""

from __future__ import annotations

from collections.abc import Mapping
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


def open_sides(
    paths: tuple[Path, Path], labels: tuple[str, str], design: Mapping[str, float] | None
) -> tuple[Side, Side]:
    """Both sides. design: values of a surrogate's parameters; by default those of the run on the other side.

    InputError E-CMP-001, E-CMP-002, and the errors of `open_source`, `Surrogate.load` and `Surrogate.predict`.
    """
    sides: list[Side | None] = [None, None]
    is_model = [path.suffix.lower() == SURROGATE and path.is_file() for path in paths]
    if all(is_model) and design is None:
        raise TWO_SURROGATES()
    for k, path in enumerate(paths):
        if not is_model[k]:
            source = open_source(path, "compare", labels[k])
            sides[k] = Side(source, source.histories, source.fabric)
    for k, path in enumerate(paths):
        if is_model[k]:
            from billow.apps.compare.model_side import answer  # runs alone need nothing of reduced-order models

            sides[k] = answer(path, labels[k], paths[1 - k], sides[1 - k], design)
    return sides[0], sides[1]
