"""Heat that a chamber's gas loses through its fabric: m cv dT/dt = -h A (T - T_ambient)."""

from __future__ import annotations

import math

from billow.base.compiled import scalar


@scalar
def heat_lost(capacity, warmer, conductance, span):
    """Heat [J] lost in `span` [s]: the exact exponential solution, stable for any coefficient.

    capacity: m cv [J/K]. warmer: T - T_ambient at the start [K]. conductance: h A [W/K].
    """
    return -capacity * warmer * math.expm1(-span * conductance / capacity)
