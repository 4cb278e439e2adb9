"""What is wrong with tear seams, straps and obstacles from files."""

from __future__ import annotations

from collections.abc import Callable

from here import Here
from triggers_geometry import bag

from billow.case.obstacles.obstacles import OBSTACLES, build_body

FLAT = {"shape": "square", "element_size": 0.02}
LOST = {"begin": [1.0, 1.0], "end": [2.0, 1.0], "strength": 1000.0}

TETRAHEDRON = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def surface(text: str = TETRAHEDRON, **table) -> Callable[[Here], object]:
    """Build an obstacle from a file of this text."""

    def trigger(here: Here):
        file = {"shape": "mesh", "file": str(here.write("body.obj", text)), **table}
        return build_body(OBSTACLES["mesh"].model_validate(file))

    return trigger


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GEO-060": bag(**FLAT, tear_seams=[LOST]),
    "E-GEO-150": surface(TETRAHEDRON.replace("0.1", "100")),
    "E-GEO-151": surface(digest="0" * 64),
    "E-GEO-152": surface(inertia=[1.0, 1.0, 3.0, 0.0, 0.0, 0.0]),
    "E-GEO-061": bag(**FLAT, straps=[{"front": [0.5, 0.0], "rear": [0.0, 0.1]}]),
}
