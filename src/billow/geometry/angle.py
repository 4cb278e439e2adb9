"""The angle of a plane vector, for loops that become vector instructions, which a call to the C library would keep from
it."""

from __future__ import annotations

import math

from billow.base.compiled import spliced

ERROR = 2e-8
"""Largest error [rad]."""


@spliced
def angle(x, y):
    """Angle [rad] of the vector (x, y) from the first axis, from -pi to pi, to ERROR; of one without length any number.

    The arc tangent of the smaller over the larger component: Abramowitz and Stegun, Handbook of Mathematical Functions,
    4.4.49.
    """
    across, along = abs(y), abs(x)
    steep = across > along
    larger = across if steep else along
    t = (along if steep else across) / (larger if larger > 0.0 else 1.0)
    s = t * t
    upper = 0.1065626393 + s * (-0.0752896400 + s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257)))
    found = t * (1.0 + s * (-0.3333314528 + s * (0.1999355085 + s * (-0.1420889944 + s * upper))))
    found = 0.5 * math.pi - found if steep else found
    found = math.pi - found if x < 0.0 else found
    return -found if y < 0.0 else found
