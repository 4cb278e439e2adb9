"""Codes of injury metrics."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-INJ-001": Entry(
        InputError,
        "A curve cannot be used for injury metrics.",
        "Values that are not finite, times that are not evenly spaced, or lengths that differ.",
        "Give one finite value for each of at least two evenly spaced times.",
    ),
    "E-INJ-002": Entry(
        InputError,
        "There is no such channel frequency class.",
        "A cut-off frequency in hertz instead of a class.",
        "Choose 60, 180, 600 or 1000.",
    ),
    "E-INJ-003": Entry(
        InputError,
        "The curve is sampled too slowly for its channel frequency class.",
        "A long run, or few histories per frame: CFC 1000 needs 10,000 samples per second.",
        "Raise run.histories_per_frame and run again, or choose a lower class.",
    ),
    "E-INJ-004": Entry(
        InputError,
        "The reference of a rating is constant or too short.",
        "An obstacle that was never touched.",
        "Rate a curve that changes, over at least 2 ms.",
    ),
    "E-INJ-005": Entry(
        InputError,
        "The run has no free obstacle.",
        "A locked obstacle has no acceleration.",
        "Set obstacles.impactor.locked to false and run again.",
    ),
}
