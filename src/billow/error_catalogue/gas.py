"""Codes of the gas."""

from billow.error_catalogue.entry import Entry
from billow.errors import InputError

CODES: dict[str, Entry] = {
    "E-GAS-001": Entry(
        InputError,
        "A gas is not known.",
        "A misspelt formula, or a gas without data.",
        "Use one of the gases that the message lists.",
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
