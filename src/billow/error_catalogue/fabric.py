"""Codes of the fabric."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-FAB-001": Entry(
        InputError,
        "A file with a curve of the fabric cannot be read.",
        "A misspelt path, or one that counts from another folder than that of the case file.",
        "Check the path in fabric.curves.",
    ),
    "E-FAB-002": Entry(
        InputError,
        "A file that should hold a curve of the fabric does not.",
        "No line that names the columns, a unit that does not fit, a decimal comma, or a file of another kind.",
        'Begin with a line such as "strain [%], stress [MPa]", then one point a line.',
    ),
    "E-FAB-003": Entry(
        InputError,
        "Points of the fabric do not make a curve.",
        "Fewer than two points, strains that do not grow, or no point at zero.",
        "Begin the curve at 0, 0 and sort its points by strain.",
    ),
    "E-FAB-004": Entry(
        InputError,
        "Stress in the fabric falls or vanishes while strain grows.",
        "Noise of the test, or points beyond the tearing of the sample.",
        "Smooth the curve, and end it before the fabric tears.",
    ),
    "E-FAB-005": Entry(
        InputError,
        "An unloading curve of the fabric does not fit its loading curve.",
        "The two exchanged, or taken from different tests.",
        "End both curves at the point where the test turned round, unloading below loading.",
    ),
    "E-FAB-006": Entry(
        InputError,
        "Loading and unloading curve of the fabric together would create energy.",
        "Unloading that gives back much, with loading that stiffens strongly.",
        "Make the unloading curve more hollow, or smooth the kink of the loading curve.",
    ),
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
