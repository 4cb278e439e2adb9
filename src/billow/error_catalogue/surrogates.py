"""Codes of surrogates."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-ROM-022": Entry(
        InputError,
        "Two studies cannot be compared for what they say about the jet direction.",
        "Their parameters, meshes, times or designs differ, or they have too few runs in common.",
        "Make both from one study file, around two cases that differ in the gas model alone.",
    ),
}
