"""Codes of results, datasets and interrupted runs."""

from billow.base.errors import InputError, IntegrityError, ResourceError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-RES-020": Entry(
        ResourceError,
        "Results could not be written.",
        "A full disk, or a folder without permission to write.",
        "Free space and go on: billow resume RUN",
    ),
    "E-RES-021": Entry(
        InputError,
        "There is no interrupted run to resume.",
        "The run has finished, or the path is another than its --out.",
        "Give the --out folder of the interrupted run.",
    ),
    "E-RES-022": Entry(
        InputError,
        "An interrupted run is waiting where a new one was to begin.",
        "The same command was given again after an interruption.",
        "Go on with it: billow resume RUN",
    ),
    "E-RES-031": Entry(
        IntegrityError,
        "No checkpoint of a run can be used.",
        "It is damaged, of another version of Billow, or its case.toml was changed.",
        "Run the case again from the start.",
    ),
    "E-RES-032": Entry(
        IntegrityError,
        "There is no checkpoint to resume from.",
        "The run ended before its first checkpoint, 30 s after its start.",
        "Run the case again.",
    ),
    "E-RES-033": Entry(
        IntegrityError,
        "The case of an interrupted run cannot be used.",
        "Its case.toml was changed or damaged.",
        "Run the case again from the start.",
    ),
}
