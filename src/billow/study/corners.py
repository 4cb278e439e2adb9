"""Trying a design space before the hours are spent: the case accepts its values, all runs have one mesh and the same
times."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from billow.base.errors import InputError
from billow.case.bag.schema_bag import MOVABLE
from billow.results.dataset_files import same_times
from billow.study.definition import StudyDefinition
from billow.study.variables import Variable, entries_of, listed_entries

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
    remedy="vary parameters that change neither; or set same_mesh = false, to learn responses and no shapes",
)

MOST_CHECKED, MOST_BUILT = 256, 8
"""Corners of the design space whose values are checked, and those whose models are built, which takes longer."""


def vary(case, variables: Sequence[Variable], values: tuple[float, ...], where: str):
    """The case with a value for each variable. InputError E-STU-007 if it does not accept them."""
    with _told(variables, values, where) as entries:
        return case.vary(entries)


def meshed_once(case, definition: StudyDefinition):
    """The case, with the sizes that its mesh is made for noted where a variable moves them (`MeshOf`)."""
    sizes = {key for variable in definition.variables for key in variable.keys} & set(MOVABLE)
    if not sizes or getattr(case.bag, "shape", None) != "driver":
        return case
    own = case.to_dict()["bag"] | {"vent_diameter": case.bag.vents.diameter, "vent_radius": case.bag.vents.distance,
                                   "stitch_radius": case.bag.straps.stitch_radius}  # fmt: skip
    return case.vary({f"bag.mesh_of.{name}": own[name] for name in map(MOVABLE.get, sorted(sizes))})


def check_values(path: Path, definition: StudyDefinition, case) -> None:
    """Try each end of each range by itself, so that an error names the one parameter that is wrong, and corners.

    InputError E-STU-007: the case does not accept a value.
    """
    for one, value, where in _ends(path, definition):
        vary(case, (one,), (value,), where)
    for corner in _corners(definition, MOST_CHECKED):
        vary(case, definition.variables, corner, f"{path}: a corner of the design space")


def build_corners(path: Path, definition: StudyDefinition, case, outline: Callable[..., Outline]) -> None:
    """Build the models of both ends of each range and of some corners; nothing is run.

    outline: what the model of a case has in common with others. InputError E-STU-007: a model cannot be built; -040:
    mesh or times differ.
    """

    def built(which, values, where) -> tuple[Outline, str]:
        with _told(which, values, where) as entries:
            return outline(case.vary(entries)), listed_entries(entries)

    own = definition.own_starts
    for variable, ends in itertools.groupby(_ends(path, definition), key=lambda end: end[0]):
        tried = [(built((variable,), (value,), where), where) for _, value, where in ends]
        for (one, where), (other, _) in itertools.pairwise(tried):
            if definition.same_mesh:
                _compare(one, other, repr(variable.name), where, own)
    where = f"{path}: corners of the design space"
    corners = [built(definition.variables, corner, where) for corner in _corners(definition, MOST_BUILT)]
    for one, other in itertools.pairwise(corners):
        if definition.same_mesh:
            _compare(one, other, "that changes the mesh with others", where, own)


def _compare(at_one: tuple[Outline, str], at_other: tuple[Outline, str], name: str, where: str, own: bool) -> None:
    """own: whether each run may have its own start shape on the same triangles."""
    (one, entries), (other, other_entries) = at_one, at_other
    if (one.nodes, one.triangles) != (other.nodes, other.triangles):
        what, values = "mesh", (f"{o.triangles} triangles, {o.nodes} nodes" for o in (one, other))
    elif one.mesh != other.mesh and not (own and one.topology == other.topology):
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
def _told(variables: Sequence[Variable], values: tuple[float, ...], where: str) -> Iterator[dict[str, Any]]:
    """The case's entries for values of the variables; what it refuses is told as a refused design, E-STU-007."""
    entries = entries_of(variables, values)
    try:
        yield entries
    except InputError as error:
        what, why, remedy = error.what, error.why, error.remedy
        tried = listed_entries(entries)
        raise CASE_REFUSES(refusal=what, where=where, reason=why, entries=tried, remedy=remedy) from error


def _ends(path: Path, definition: StudyDefinition) -> Iterator[tuple[Variable, float, str]]:
    """Each variable by itself with its low and its high value, or every level, and where it stands."""
    for kind, variables in (("parameters", definition.parameters), ("factors", definition.factors)):
        for number, variable in enumerate(variables, start=1):
            values = range(len(variable.levels)) if kind == "factors" else (variable.low, variable.high)
            for value in values:
                yield variable, float(value), f"{path}: [[{kind}]] number {number} ({variable.name})"


def _corners(definition: StudyDefinition, most: int) -> Iterator[tuple[float, ...]]:
    """Corners of the design space that its constraints allow, at most so many, evenly from all low to all high."""
    variables = definition.variables
    every = 2 ** len(variables)
    for k in range(min(every, most)):
        bits = round(k * (every - 1) / (min(every, most) - 1))
        corner = tuple(v.high if bits >> axis & 1 else v.low for axis, v in enumerate(variables))
        if definition.allows(np.array([corner]))[0]:
            yield corner
