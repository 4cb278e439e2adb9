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
    "W-GAS-001": Entry(
        None,
        "Less than half of the gas comes before the run ends.",
        "Times of the curve in milliseconds, or a run that is too short.",
        "Write times with units, or raise run.end_time.",
    ),
    "W-GAS-002": Entry(
        None,
        "All gas comes within a fiftieth of the run.",
        "Times of the curve in another unit.",
        'Write times with units, for example "50 ms".',
    ),
    "W-GAS-003": Entry(
        None,
        "The gas would fill a small part of the bag, or many bags.",
        "Mass in grams, or a length in millimetres.",
        "Check inflator.mass_flow and bag.diameter.",
    ),
    "W-GAS-004": Entry(
        None,
        "Vents or fabric let out more gas than the inflator gives.",
        "A permeability or a vent in another unit.",
        "Reduce fabric.permeability or bag.vents.diameter.",
    ),
    "W-GAS-005": Entry(
        None,
        "The vents open at a pressure that no bag works at.",
        "A pressure in another unit.",
        'Write units, for example opening_pressure = "20 kPa".',
    ),
    "W-GAS-006": Entry(
        None,
        "The ring of jets is wider than the mouth the inflator is mounted in.",
        "A radius and a diameter exchanged.",
        "Reduce inflator.jets.ring_radius, or enlarge bag.mouth_radius.",
    ),
}
