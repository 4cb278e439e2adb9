"""Codes of geometry and mesh."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

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
    "E-GEO-012": Entry(
        InputError,
        "The bag has no such chamber.",
        "A chamber counted from 0, or more chambers named than bag.chambers makes.",
        "Count chambers from 1, or raise bag.chambers.",
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
    "E-GEO-030": Entry(
        InputError,
        "A mesh file cannot be read.",
        "A wrong path, another format, or a damaged file.",
        "Save the mesh as .vtkhdf, or as .vtk in ASCII, and check that it opens in ParaView.",
    ),
    "E-GEO-031": Entry(
        InputError,
        "A mesh file holds no usable mesh of triangles and quads.",
        "Other kinds of cells in the file, nodes that do not exist, or a part field of another name.",
        "Save the fabric alone as triangles and quads, and name the cell field of their parts in bag.part_field.",
    ),
    "E-GEO-032": Entry(
        InputError,
        "The parts of the mesh file and those of the case do not match.",
        "A part without a [[bag.parts]] table, or a table without a part.",
        "Add a [[bag.parts]] table for every part of the mesh, with its number.",
    ),
    "E-GEO-033": Entry(
        InputError,
        "The reference does not have the cells of the start mesh.",
        "Two meshes made apart, or one of them in another order.",
        "Give both meshes the same cells in the same order; their nodes may differ.",
    ),
    "E-GEO-034": Entry(
        InputError,
        "The mesh has no such node.",
        "A node counted from 1, or a number of another mesh.",
        "Count nodes from 0, as ParaView does.",
    ),
    "E-GEO-035": Entry(
        InputError,
        "The bag's mesh files have changed since the case was made.",
        "A file that was edited or replaced while a study or an interrupted run still needs it.",
        "Bring the files back, or remove bag.digest to use them as they are now.",
    ),
    "E-GEO-036": Entry(
        InputError,
        "Some triangles of a panel are mirrored in the flat cut.",
        "Start and reference list the corners of a triangle in different orders, or a flat piece overlaps itself.",
        "Check that start and reference list the same triangles with the same order of corners.",
    ),
    "E-GEO-037": Entry(
        InputError,
        "A panel with an aslant warp is mirrored.",
        "Its flat cut is drawn as seen from the other side than seen_from says.",
        "Mirror its flat cut, or change seen_from and count the angle in the drawing.",
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
