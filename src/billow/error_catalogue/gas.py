"""Codes of the gas."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-GAS-002": Entry(
        InputError,
        "A chamber is not known.",
        "A misspelt name, or a bag with fewer chambers.",
        "Use one of the chambers that the message lists.",
    ),
    "E-GAS-003": Entry(
        InputError,
        "A law of leakage is given for something that is no part of fabric.",
        "A misspelt part, or a vent.",
        "Use one of the parts that the message lists.",
    ),
    "E-GAS-004": Entry(
        InputError,
        "A chamber encloses no air at the start.",
        "Layers of the start shape that lie on each other.",
        "Raise bag.initial_gap, or move the layers apart.",
    ),
    "E-GAS-005": Entry(
        InputError,
        "An opening joins a chamber with itself.",
        "The chambers on its two sides were given the same name.",
        "Give its two sides different chambers.",
    ),
    "E-GAS-006": Entry(
        InputError,
        "An inflator has jets but no mouth to blow from.",
        "Its chamber is another than the one with the mouth.",
        "Set inflator.jets.count = 0, or name a chamber with a mouth.",
    ),
    "E-GAS-007": Entry(
        InputError,
        "The corpuscular gas cannot use an orifice that the mesh does not show.",
        "An orifice of [gas] in a case that was written for uniform pressure.",
        "Draw it into the mesh as an opening, remove it, or use uniform pressure.",
    ),
}
