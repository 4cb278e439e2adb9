"""Codes of runs that are stopped."""

from billow.base.errors import NumericalStop
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-NUM-002": Entry(
        NumericalStop,
        "The gas left its temperature range, 150 to 3,000 K.",
        "Mass flow or temperature of the inflator in another unit.",
        "Check inflator.mass_flow and inflator.temperature.",
    ),
    "E-NUM-005": Entry(
        NumericalStop,
        "Fabric is stretched to three times its length; real fabric tears at 1.3.",
        "Too much gas, or fabric that is too soft or too thin.",
        "Check inflator.mass_flow, fabric.young_warp, fabric.young_weft and fabric.thickness.",
    ),
    "E-NUM-006": Entry(
        NumericalStop,
        "Fabric went deeper into an obstacle than half its smallest radius.",
        "The obstacle is too soft for the load.",
        "Raise the slope of the obstacle.",
    ),
    "E-NUM-008": Entry(
        NumericalStop,
        "A particle of the corpuscular gas is nowhere: its place is no longer a finite number.",
        "Gas that became meaninglessly hot or fast, for example in a bag that collapsed.",
        "Reduce run.dt_scale; look at the last frames; compare with uniform pressure.",
    ),
    "E-NUM-009": Entry(
        NumericalStop,
        "A chamber has less than a thousandth of its first volume, or less than a tenth and gas too hot to be true.",
        "Panels that passed through each other, or an obstacle that squeezes all gas out of a chamber.",
        "Look at the last frames; reduce run.dt_scale, or raise bag.initial_gap.",
    ),
}
