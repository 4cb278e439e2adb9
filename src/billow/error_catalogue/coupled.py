"""Codes of force inputs and of coupled models."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-CPL-003": Entry(
        InputError,
        "The study has no free obstacle.",
        "Its obstacles are locked, or plates.",
        "Set obstacles.impactor.locked to false in the case of the study.",
    ),
    "E-CPL-004": Entry(
        InputError,
        "The obstacle is not a plain function of the design.",
        "A property that is no affine function of the parameters, or fewer training runs than parameters.",
        "Vary each property of the obstacle by a parameter of its own; make more runs.",
    ),
    "E-CPL-005": Entry(
        InputError,
        "A coupled model cannot be learned.",
        "The surrogate was trained with force_modes, or histories of the runs have different times.",
        "Train the surrogate without force_modes, on runs with the same run.histories_per_frame.",
    ),
    "E-CPL-006": Entry(
        InputError,
        "The file holds no coupled model.",
        "The file is a surrogate of the bag alone.",
        "Make a coupled model: billow couple train FOLDER",
    ),
}
