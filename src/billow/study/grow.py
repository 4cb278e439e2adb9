"""A study that grows: more training runs after the existing ones; existing runs, and all test runs, stay as they
are."""

from __future__ import annotations

from pathlib import Path

from billow.base.errors import InputError
from billow.study.definition import StudyDefinition
from billow.study.design import Design, Values, draw, numbered

ANOTHER_STUDY = InputError.declare(
    "E-STU-008",
    "the folder holds something other than this study",
    where="{folder}",
    cause="the study or its case was changed after the folder was made",
    remedy="choose another folder, or delete this one; to continue the study in it, give its own study.toml",
)
CANNOT_GROW = InputError.declare(
    "E-STU-025",
    "{train} training runs cannot grow to {wanted}",
    where="{folder}",
    why="{wanted} is not a multiple of {train}, so that the new runs could not fill all empty strata",
    remedy="set train to a multiple, such as {multiple}, or list more designs in added_designs",
)

MAY_GROW = ("train", "nested", "added_designs")
"""Entries of study.toml that may change after runs were made."""


def merged(existing: StudyDefinition, given: StudyDefinition, folder: Path) -> StudyDefinition:
    """The definition of a study in `folder` after `given` was requested.

    Existing sizes stay sizes of nested hypercubes, so that their runs keep their places. InputError E-STU-008 if
    `given` differs in more than `MAY_GROW` allows.
    """
    different = [
        name
        for name in StudyDefinition.model_fields
        if name not in MAY_GROW and getattr(existing, name) != getattr(given, name)
    ]
    if different:
        raise ANOTHER_STUDY(
            folder=folder, why=f"{', '.join(different)} in its study.toml differ from the study asked for"
        )
    if given.train < existing.train:
        raise ANOTHER_STUDY(
            folder=folder, why=f"it has {existing.train} training runs already, more than the {given.train} asked"
        )
    known = set(existing.sizes)
    between = [size for size in given.nested if size not in known and size < existing.train]
    if between:
        raise ANOTHER_STUDY(
            folder=folder, why=f"its {existing.train} training runs were not drawn with nested = {between}"
        )
    later = [size for size in given.sizes if size > existing.train]
    sizes = (*existing.sizes, *later)
    if any(later) and later[0] % existing.train:
        raise CANNOT_GROW(train=existing.train, wanted=later[0], folder=folder, multiple=2 * existing.train)
    return given.model_copy(update={"train": sizes[-1], "nested": sizes[:-1]})


def grown(existing: Design, definition: StudyDefinition, added: list[Values], folder: Path) -> Design:
    """The runs of a study after it has grown to `definition` with the `added` designs.

    InputError E-STU-008 if runs that exist would no longer belong to it, or a design was added that is a test run.
    """
    wanted = draw(definition)
    rows = [*wanted.train.values(), *added]
    if tuple(existing.test.values()) != tuple(wanted.test.values()):
        raise ANOTHER_STUDY(folder=folder, why="its test runs are not those of the study asked for")
    lost = set(existing.train.values()) - set(rows)
    if lost:
        raise ANOTHER_STUDY(
            folder=folder, why=f"{len(lost)} of its training runs are not among those of the study asked for"
        )
    if set(added) & set(wanted.test.values()):
        raise ANOTHER_STUDY(folder=folder, why="a design in added_designs is one of its test runs")
    there = set(existing.train.values())
    return numbered(existing, [row for row in rows if row not in there], [])
