"""Codes of convergence studies."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-CONV-001": Entry(
        InputError,
        "There is nothing to compare.",
        "One number of particles, or one seed.",
        "Give at least two of each, for example --particles 5e3,1e4,2e4 --seeds 3.",
    ),
    "E-CONV-002": Entry(
        InputError,
        "The gas of the case has no particles.",
        'A case with another gas.model than "corpuscular".',
        "Give --set gas.model=corpuscular.",
    ),
    "E-CONV-003": Entry(
        InputError,
        "The folder of a convergence study holds something else.",
        "The case was changed since its first runs, or the folder is another's.",
        "Choose another folder with --out, or delete this one.",
    ),
}
