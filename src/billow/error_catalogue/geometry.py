"""Codes of geometry and mesh."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-GEO-020": Entry(
        InputError,
        "An obstacle penetrates the bag at the start.",
        "A clearance that is too small for the start shape, or a plate above z = 0.",
        "Raise the clearance of the obstacle, or lower the height of the plate.",
    ),
    "E-GEO-021": Entry(
        InputError,
        "An obstacle lies inside the bag at the start.",
        "A small obstacle within a start shape that is high.",
        "Raise its clearance, or move it aside with offset.",
    ),
    "W-MESH-001": Entry(
        None,
        "The bag, or one of its chambers, has fewer than ten elements across.",
        "An element size for a quick look.",
        "Use at least twenty elements across.",
    ),
    "W-MESH-002": Entry(
        None,
        "The fabric starts stretched.",
        "A start shape that is too high, or reference coordinates that belong to other nodes.",
        "Use a bag.initial_gap of a few millimetres; for a mesh that is meant to start distorted, bag.birth_time.",
    ),
    "W-MESH-003": Entry(
        None,
        "A strap starts stretched.",
        "A strap shorter than the distance of its ends.",
        "Lengthen it, or give it slack, in bag.straps.",
    ),
    "W-MESH-004": Entry(
        None,
        "The fabric starts compressed.",
        "A start shape in another unit than the reference, or one that was shortened by folding.",
        "Check bag.unit and bag.reference.",
    ),
    "W-MESH-005": Entry(
        None,
        "Triangles of fabric have no area at the start.",
        "Nodes in the same place, from a mesh that was folded or merged carelessly.",
        "Move the nodes of the start shape apart.",
    ),
}
