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
}
