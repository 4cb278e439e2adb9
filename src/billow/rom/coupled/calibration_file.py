"""A calibration as named arrays, and back again, with every shape checked."""

from __future__ import annotations

import numpy as np

from billow.rom.coupled.calibration import Calibration
from billow.rom.coupled.injury_metrics import METRICS, InjuryModel, LogLinear
from billow.rom.coupled.motion_errors import CURVES
from billow.rom.surrogate.judgement import judgement_of
from billow.rom.surrogate.surrogate_file import take


def calibration_content(calibration: Calibration) -> dict[str, np.ndarray]:
    """Arrays by name, which `calibration_of` reads under "coupled."."""
    injury = calibration.injury
    return {
        "half_widths": np.stack([calibration.half_widths[name] for name in CURVES]),
        "injury.weights": injury.fit.weights,
        "injury.inverse": injury.fit.inverse,
        "injury.smallest": injury.smallest,
        "injury.from_motion": injury.from_motion.astype(np.int64),
        "injury.factors": injury.factors,
    }


def calibration_of(tensors, record, times: int, parameters: int) -> Calibration | None:
    """From the arrays of a file and the judgement of its metrics; None if it holds none. KeyError, TypeError or
    ValueError if something does not fit."""
    if record is None:
        return None
    inputs, metrics = 1 + parameters, len(METRICS)
    widths = take(tensors, "coupled.half_widths", np.float64, len(CURVES), times, 3)
    weights = take(tensors, "coupled.injury.weights", np.float64, inputs, metrics)
    inverse = take(tensors, "coupled.injury.inverse", np.float64, inputs, inputs)
    smallest, factors = (take(tensors, f"coupled.injury.{n}", np.float64, metrics) for n in ("smallest", "factors"))
    if not (widths >= 0.0).all() or not (factors >= 0.0).all() or not (smallest > 0.0).all():
        raise ValueError("an interval has a negative width")
    from_motion = take(tensors, "coupled.injury.from_motion", np.int64, metrics) != 0
    injury = InjuryModel(LogLinear(weights, inverse), smallest, from_motion, factors)
    return Calibration(dict(zip(CURVES, widths, strict=True)), injury, judgement_of(record))
