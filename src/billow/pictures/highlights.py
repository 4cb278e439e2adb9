"""What is looked at first in a run: peaks of its curves, and injury metrics of its free bodies."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.injury.criteria import GRAVITY, assess
from billow.injury.filters import SAMPLED_TOO_SLOWLY, UNUSABLE_CURVE
from billow.pictures.curves import curve_of, quantities
from billow.pictures.shown_units import factor_of, shown_unit
from billow.results.result import Result

OF_GAS = ("pressure", "temperature", "volume")
OF_BODIES = ("force", "penetration", "velocity")


def highlights(result: Result) -> list[tuple[str, str]]:
    """Names and values with their units and times, for people: peaks of the gas, of each chamber and of each obstacle,
    then the injury metrics of every free obstacle, or why there are none."""
    known = quantities(result.histories)
    chambers = [name.removesuffix("_volume") for name in known if name.endswith("_volume")]
    names = [*OF_GAS, *(f"{chamber}_{one}" for chamber in chambers for one in OF_GAS)]
    names += [f"{body}_{one}" for body in result.obstacles for one in OF_BODIES]
    found = []
    for name in names:
        curve = curve_of(result.histories, name)
        if curve is None or not np.isfinite(curve.peak[0]):
            continue
        value, time = curve.peak
        unit = shown_unit(curve.unit, abs(value))
        title = name.replace("_", " ")
        found.append((f"largest {title}", f"{value / factor_of(curve.unit, unit):.4g} {unit} at {1e3 * time:.1f} ms"))
    for body in result.free_obstacles:
        found += _injury(result, body)
    return found


def _injury(result: Result, body: str) -> list[tuple[str, str]]:
    try:
        injury = assess(result.histories.time, result.body(body).velocity)
    except InputError as error:
        if error.code not in (UNUSABLE_CURVE.code, SAMPLED_TOO_SLOWLY.code):
            raise
        return [(f"injury metrics of {body}", f"none: {error.why}")]
    except AttributeError:  # a body whose motion nobody recorded
        return []
    return [
        *(
            (f"{title} of {body}", f"{hic.value:.4g}, from {1e3 * hic.start:.1f} to {1e3 * hic.end:.1f} ms")
            for title, hic in (("HIC15", injury.hic15), ("HIC36", injury.hic36))
        ),
        (f"3 ms clip of {body}", f"{injury.clip / GRAVITY:.4g} g"),
        (f"peak of {body}, CFC 1000", f"{injury.peak / GRAVITY:.4g} g at {1e3 * injury.peak_time:.1f} ms"),
    ]
