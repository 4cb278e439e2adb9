"""Codes of the fabric."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "W-FAB-001": Entry(
        None,
        "Sound travels at a speed that no woven fabric has.",
        "A modulus or the density in another unit.",
        'Write units, for example young_warp = "0.4 GPa".',
    ),
    "W-FAB-002": Entry(
        None,
        "The fabric is too light or too heavy.",
        "Density or thickness in another unit.",
        'Write units, for example thickness = "0.3 mm".',
    ),
    "W-FAB-003": Entry(
        None,
        "The moduli of the fabric do not go together.",
        "A power of ten lost in one of them.",
        "Check fabric.young_warp, fabric.young_weft and fabric.shear.",
    ),
    "W-FAB-004": Entry(
        None,
        "One steep curve of the fabric shortens the step of the whole run to less than half.",
        "A kink or noise in a measured curve, or a stress in another unit.",
        "Smooth the steepest piece of the curve that the message names.",
    ),
    "W-FAB-005": Entry(
        None,
        "A curve of the fabric ends before the stresses of a deployment.",
        "A test that was stopped early, or a stress in another unit.",
        "Measure further; beyond its end a curve goes on with its last slope.",
    ),
}
