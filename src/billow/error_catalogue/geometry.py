"""Codes of geometry and mesh."""

from billow.error_catalogue.entry import Entry
from billow.errors import InputError

CODES: dict[str, Entry] = {
    "E-GEO-001": Entry(
        InputError,
        "The bag is not closed.",
        "A seam whose nodes are not merged, a hole, or a wall that divides the bag.",
        "Merge the nodes along the seam, or close the opening with a vent or mouth part.",
    ),
    "E-GEO-002": Entry(
        InputError,
        "Neighbouring triangles are oriented in opposite senses.",
        "A triangle whose nodes run the other way round.",
        "Reverse the node order of the flipped triangles.",
    ),
    "E-GEO-003": Entry(
        InputError,
        "All normals point inwards.",
        "A mesh whose triangles all run clockwise seen from outside.",
        "Reverse the node order of every triangle.",
    ),
    "E-GEO-004": Entry(
        InputError,
        "A triangle of the flat reference shape has no area.",
        "Two of its reference corners coincide, or all three lie on a line.",
        "Correct the reference coordinates of its nodes.",
    ),
    "E-GEO-010": Entry(
        InputError,
        "A mouth, vent or strap does not fit into its panel.",
        "A length in another unit, or a vent so close to a rim that no elements fit between.",
        "Change the key that the message names, or reduce bag.element_size.",
    ),
    "E-GEO-011": Entry(
        InputError,
        "The mesh would be too large for memory.",
        "bag.element_size or bag.diameter in another unit.",
        "Raise bag.element_size.",
    ),
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
        "The bag has fewer than ten elements across.",
        "An element size for a quick look.",
        "Use at most a twentieth of bag.diameter.",
    ),
    "W-MESH-002": Entry(
        None,
        "The fabric starts stretched.",
        "A start shape that is too high, or reference coordinates that belong to other nodes.",
        "Use a bag.initial_gap of a few millimetres.",
    ),
    "W-MESH-003": Entry(
        None,
        "A strap starts stretched.",
        "A strap shorter than the way from the retainer ring to its stitch line.",
        "Lengthen bag.straps.length.",
    ),
}
