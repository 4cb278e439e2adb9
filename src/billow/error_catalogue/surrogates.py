"""Codes of surrogates."""

from billow.base.errors import InputError, NumericalStop, ResourceError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-ROM-006": Entry(
        ResourceError,
        "PyTorch is not installed.",
        "Training needs it; prediction does not.",
        "Install it with pip install torch.",
    ),
    "E-ROM-007": Entry(
        InputError,
        "There are too few runs for so many modes, or none at all.",
        "The study has not been run, or --modes exceeds the number of snapshots.",
        "Finish the study, or reduce --modes.",
    ),
    "E-ROM-008": Entry(
        InputError,
        "There is no such recipe.",
        "A misspelt name after --recipe.",
        'Use "shared" or "paper".',
    ),
    "E-ROM-009": Entry(
        InputError,
        "A run holds displacements that are not finite.",
        "A run folder that was written by another program.",
        "Delete the run and give the command of the study again, which makes what is missing.",
    ),
    "E-ROM-010": Entry(
        InputError,
        "A parameter or the time has no range to learn from.",
        "A dataset in which a parameter is the same everywhere, or with one recorded time.",
        "Vary the parameter, or leave it out.",
    ),
    "E-ROM-012": Entry(
        InputError,
        "The surrogate was not trained on this dataset.",
        "A surrogate of another study, or of an earlier state of this one.",
        "Evaluate it with its own dataset, or train one on this: billow train FOLDER",
    ),
    "E-ROM-013": Entry(
        NumericalStop,
        "The reduced basis is not orthonormal.",
        "Displacements beyond all bounds, or a faulty library for linear algebra.",
        "Look at the largest displacements of the runs.",
    ),
    "E-ROM-014": Entry(
        NumericalStop,
        "Training diverged.",
        "Outliers among the runs.",
        "Train with another --seed; look at the runs for outliers.",
    ),
    "E-ROM-015": Entry(
        InputError,
        "There are no unseen runs to compare a surrogate with.",
        "The test runs of the study are not made yet, or failed.",
        "Finish the study: billow study STUDY.toml --out FOLDER",
    ),
    "E-ROM-021": Entry(
        InputError,
        "There are no designs to suggest.",
        "A number of designs below one, or a surrogate without an ensemble.",
        'Ask for at least one, with a surrogate of the recipe "shared".',
    ),
    "E-ROM-022": Entry(
        InputError,
        "Two studies cannot be compared for what they say about the jet direction.",
        "Their parameters, meshes, times or designs differ, or they have too few runs in common.",
        "Make both from one study file, around two cases that differ in the gas model alone.",
    ),
}
