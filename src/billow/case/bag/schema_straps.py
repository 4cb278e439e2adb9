"""Straps (tethers) of a bag."""

from __future__ import annotations

from typing import Literal

from billow.case.bag.quantities import Offset
from billow.case.quantity import Strict, quantity, whole


class StrapCloth(Strict):
    """Material of straps, and when they pull."""

    length: quantity("m", 0.01, 2.0) | Literal["start"] = "start"
    """Unstretched length; start: the distance of its ends at the start."""
    slack: quantity("m", 0.0, 1.0) = 0.0
    """Added to the length: the strap pulls only beyond it."""
    width: quantity("m", 1e-3, 0.5) = 0.06
    """Width of each strap."""
    stiffness: quantity("N", 0.0, 1e7) = 0.0
    """Tension per strain of the whole strap; 0 to use the bag's fabric along the warp."""
    failure: quantity("N", 0.0, 1e6) = 0.0
    """Tension of the whole strap at which it tears; 0 for never."""


class Straps(StrapCloth):
    """Straps (tethers) from the retainer ring to a stitch line on the front panel, by default cut from the bag's
    fabric."""

    count: whole(0, 24, "straps") = 4
    """Number of straps."""
    length: quantity("m", 0.01, 2.0) | Literal["start"] = 0.28
    """Unstretched length; start: the distance of its ends at the start."""
    stitch_radius: quantity("m", 1e-3, 2.0) = 0.08
    """Radius of the stitch line on the front panel."""


class PanelStrap(StrapCloth):
    """A strap from a point of the front panel to a point of the rear panel."""

    front: tuple[Offset, Offset]
    """Its end on the front panel (x, y), relative to the middle of the bag; the nearest node is used, at most an
    element away."""
    rear: tuple[Offset, Offset]
    """Its end on the rear panel."""
