"""Codes of obstacles."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "W-OBS-001": Entry(
        None,
        "An obstacle is too far away for the bag to reach it.",
        "A clearance in another unit.",
        "Reduce the clearance, or remove the obstacle.",
    ),
    "W-OBS-002": Entry(
        None,
        "A free obstacle is lighter than foam or heavier than lead.",
        "Mass or radii in another unit.",
        'Write units, for example mass = "4500 g".',
    ),
    "W-OBS-003": Entry(
        None,
        "An obstacle is softer than the bag.",
        "The slope in N/mm.",
        'Write units, for example slope = "100 N/mm".',
    ),
}
