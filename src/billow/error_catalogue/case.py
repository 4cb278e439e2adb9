"""Codes of the case file."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-CASE-001": Entry(
        InputError,
        "The case file cannot be read.",
        "A misspelt path, or no permission.",
        "Check the path; `billow check --example` prints a case to start from.",
    ),
    "E-CASE-002": Entry(
        InputError,
        "The case file is not valid TOML.",
        "A missing quote or bracket, a key written twice, or a file of another kind.",
        "Correct the line that the message names; docs/case.md has an example.",
    ),
    "E-CASE-003": Entry(
        InputError,
        "A key of the case is not known.",
        "A misspelt key, or one in the wrong table.",
        "Take the suggested key, or one of those listed.",
    ),
    "E-CASE-004": Entry(
        InputError,
        "A key that has no default is missing.",
        "A curve with times and no values.",
        "Add the key; docs/case.md describes it.",
    ),
    "E-CASE-005": Entry(
        InputError,
        "A value of the case cannot be used.",
        "A number in another unit, outside its plausible range; a text where a number belongs; quantities that "
        "contradict each other.",
        'Write the unit, for example thickness = "0.3 mm"; docs/case.md gives units and ranges.',
    ),
    "E-CASE-006": Entry(
        InputError,
        "A dotted key does not lead to a setting of the case.",
        "A misspelt key after --set or among the keys of a study; an obstacle addressed by another name than its own.",
        "Take one of the names that the message lists.",
    ),
}
