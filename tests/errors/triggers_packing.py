"""What is wrong with tear seams and straps."""

from __future__ import annotations

from collections.abc import Callable

from here import Here
from triggers_geometry import bag

FLAT = {"shape": "square", "element_size": 0.02}
LOST = {"begin": [1.0, 1.0], "end": [2.0, 1.0], "strength": 1000.0}

TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GEO-060": bag(**FLAT, tear_seams=[LOST]),
    "E-GEO-061": bag(**FLAT, straps=[{"front": [0.5, 0.0], "rear": [0.0, 0.1]}]),
}
