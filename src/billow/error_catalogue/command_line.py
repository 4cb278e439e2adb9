"""Codes of the command line."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-CLI-004": Entry(
        InputError,
        "The file to be written exists already.",
        "A second prediction with the same --out.",
        "Choose another name with --out, or delete the file.",
    ),
}
