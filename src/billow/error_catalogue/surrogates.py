"""Codes of surrogates."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-ROM-012": Entry(
        InputError,
        "The surrogate was not trained on this dataset.",
        "A surrogate of another study, or of an earlier state of this one.",
        "Evaluate it with its own dataset, or train one on this: billow train FOLDER",
    ),
    "E-ROM-015": Entry(
        InputError,
        "There are no unseen runs to compare a surrogate with.",
        "The test runs of the study are not made yet, or failed.",
        "Finish the study: billow study STUDY.toml --out FOLDER",
    ),
    "E-ROM-022": Entry(
        InputError,
        "Two studies cannot be compared for what they say about the jet direction.",
        "Their parameters, meshes, times or designs differ, or they have too few runs in common.",
        "Make both from one study file, around two cases that differ in the gas model alone.",
    ),
}
