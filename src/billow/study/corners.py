"""Trying a design space before the hours are spent: the case accepts its values, all runs have one mesh and the same
times."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from billow.base.errors import InputError
from billow.results.dataset_files import same_times
from billow.study.definition import StudyDefinition

if TYPE_CHECKING:
    from billow.run.check import Outline

CASE_REFUSES = InputError.declare(
    "E-STU-007",
    "the case does not accept a design: {refusal}",
    why="{reason}; tried: {entries}",
    cause="a misspelt key, or a range that goes beyond what is plausible",
    remedy="correct the parameter; docs/case.md gives keys and ranges",
)
NOT_COMPARABLE = InputError.declare(
    "E-STU-040",
    "the parameter {name} changes the {field}",
    why="{difference}; a surrogate needs all runs on one mesh at the same times",
    remedy="vary parameters that change neither, and make a study for each value of this one",
)

MOST_CHECKED, MOST_BUILT = 256, 8
"""Corners of the design space whose values are checked, and those whose models are built, which takes longer."""


def vary(case, definition: StudyDefinition, values: tuple[float, ...], where: str):
    """The case with a value for each parameter. InputError E-STU-007 if it does not accept them."""
    with _told(definition, values, where) as entries:
        return case.vary(entries)


def check_values(path: Path, definition: StudyDefinition, case) -> None:
    """Try each end of each range by itself, so that an error names the one parameter that is wrong, and corners.

    InputError E-STU-007: the case does not accept a value.
    """
    for one, value, where in _ends(path, definition):
        vary(case, one, (value,), where)
    for corner in _corners(definition, MOST_CHECKED):
        vary(case, definition, corner, f"{path}: a corner of the design space")


def build_corners(path: Path, definition: StudyDefinition, case, outline: Callable[..., Outline]) -> None:
    """Build the models of both ends of each range and of some corners; nothing is run.

    outline: what the model of a case has in common with others. InputError E-STU-007: a model cannot be built; -040:
    mesh or times differ.
    """

    def built(which, values, where) -> tuple[Outline, str]:
        with _told(which, values, where) as entries:
            return outline(case.vary(entries)), _listed(entries)

    ends = list(_ends(path, definition))
    for (one, *low), (_, *high) in zip(ends[::2], ends[1::2], strict=True):
        name, where = repr(one.parameters[0].name), low[1]
        _compare(built(one, (low[0],), where), built(one, (high[0],), where), name, where)
    where = f"{path}: corners of the design space"
    corners = [built(definition, corner, where) for corner in _corners(definition, MOST_BUILT)]
    for one, other in itertools.pairwise(corners):
        _compare(one, other, "that changes the mesh with others", where)


def _compare(at_one: tuple[Outline, str], at_other: tuple[Outline, str], name: str, where: str) -> None:
    (one, entries), (other, other_entries) = at_one, at_other
    if (one.nodes, one.triangles) != (other.nodes, other.triangles):
        what, values = "mesh", (f"{o.triangles} triangles, {o.nodes} nodes" for o in (one, other))
    elif one.mesh != other.mesh:
        what, values = "start shape", ("one shape", "another of the same triangles")
    elif not same_times(one.times, other.times):
        what, values = "recorded times", (f"{len(o.times)} frames to {o.times[-1]:g} s" for o in (one, other))
    else:
        return
    first, second = values
    raise NOT_COMPARABLE(
        name=name, field=what, difference=f"{entries}: {first}; {other_entries}: {second}", where=where
    )


@contextlib.contextmanager
def _told(definition: StudyDefinition, values: tuple[float, ...], where: str) -> Iterator[dict[str, float]]:
    """The case's entries for values of the parameters; what it refuses is told as a refused design, E-STU-007."""
    entries = {key: v for p, v in zip(definition.parameters, values, strict=True) for key in p.keys}
    try:
        yield entries
    except InputError as error:
        what, why, remedy = error.what, error.why, error.remedy
        raise CASE_REFUSES(refusal=what, where=where, reason=why, entries=_listed(entries), remedy=remedy) from error


def _listed(entries: dict[str, float]) -> str:
    return ", ".join(f"{key} = {value:g}" for key, value in entries.items())


def _ends(path: Path, definition: StudyDefinition) -> Iterator[tuple[StudyDefinition, float, str]]:
    """Each parameter by itself with its low and its high value, and where it stands."""
    for number, parameter in enumerate(definition.parameters, start=1):
        one = definition.model_copy(update={"parameters": (parameter,)})
        for value in (parameter.low, parameter.high):
            yield one, value, f"{path}: [[parameters]] number {number} ({parameter.name})"


def _corners(definition: StudyDefinition, most: int) -> Iterator[tuple[float, ...]]:
    """Corners of the design space, at most so many, evenly from all low to all high."""
    parameters = definition.parameters
    every = 2 ** len(parameters)
    for k in range(min(every, most)):
        bits = round(k * (every - 1) / (min(every, most) - 1))
        yield tuple(p.high if bits >> axis & 1 else p.low for axis, p in enumerate(parameters))
