"""What is wrong with a bag that is made of chambers or read from mesh files."""

from __future__ import annotations

import hashlib
from collections.abc import Callable

from here import Here

from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.run.check import describe
from trust.faults import SOUND

TETRAHEDRON = """# vtk DataFile Version 3.0
a bag of four triangles
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0  0.3 0 0  0 0.3 0  0 0 0.3
CELLS 4 16
3 0 2 1  3 0 1 3  3 0 3 2  3 1 2 3
CELL_TYPES 4
5 5 5 5
CELL_DATA 4
SCALARS part int 1
LOOKUP_TABLE default
1 1 1 2
"""
TWO = """# vtk DataFile Version 3.0
two bags of four triangles, one in the other's way
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 8 double
0 0 0  0.3 0 0  0 0.3 0  0 0 0.3
0.05 0.05 0.05  0.35 0.05 0.05  0.05 0.35 0.05  0.05 0.05 0.35
CELLS 8 32
3 0 2 1  3 0 1 3  3 0 3 2  3 1 2 3
3 4 6 5  3 4 5 7  3 4 7 6  3 5 6 7
CELL_TYPES 8
5 5 5 5 5 5 5 5
CELL_DATA 8
SCALARS part int 1
LOOKUP_TABLE default
1 1 1 2 1 1 1 2
"""
SPREAD = "0 0 0  0.3 0 0  0 0.3 0  0 0.3 0.1"
PARTS = [{"name": "low", "number": 1}, {"name": "slope", "number": 2}]


def bag(**settings) -> Callable[[Here], object]:
    """Check the sound case with another bag."""
    return lambda here: describe(Case.from_dict({**SOUND, "bag": settings}))


def mesh(start: str = TETRAHEDRON, reference: str | None = None, **settings) -> Callable[[Here], Case]:
    """The case of a mesh bag."""

    def make(here: Here) -> Case:
        table = {"shape": "mesh", "start": str(here.write("start.vtk", start)), "parts": PARTS, **settings}
        if reference is not None:
            table["reference"] = str(here.write("reference.vtk", reference))
        return Case.from_dict({"bag": table, "gas": {"model": "none"}, "obstacles": []})

    return make


def checked(make: Callable[[Here], Case]) -> Callable[[Here], object]:
    return lambda here: describe(make(here))


def warned(code: str, make: Callable[[Here], Case]) -> Callable[[Here], object]:
    def trigger(here: Here):
        odd = make(here)
        assert f"{code} warning: " in describe(odd)
        return next(warning for warning in concerns_of(odd, build_model(odd)) if warning.code == code)

    return trigger


def with_points(text: str) -> str:
    return TETRAHEDRON.replace("0 0 0  0.3 0 0  0 0.3 0  0 0 0.3", text)


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GEO-012": bag(shape="rectangular", chambers=2, mouth_chamber=3),
    "E-GEO-030": checked(mesh("DATASET")),
    "E-GEO-031": checked(mesh(TETRAHEDRON.replace("5 5 5 5", "5 5 5 3"))),
    "E-GEO-032": checked(mesh(parts=PARTS[:1])),
    "E-GEO-033": checked(mesh(reference=TETRAHEDRON.replace("1 1 1 2", "2 1 1 1"))),
    "E-GEO-034": checked(mesh(fixed_nodes=[4])),
    "E-GEO-035": checked(mesh(digest=hashlib.sha256(b"other").hexdigest())),
    "E-GEO-036": checked(mesh(reference=with_points("0 0 0  0.3 0 0  0 0.3 0  0.1 0.5 0"))),
    "E-GEO-037": checked(mesh(parts=[PARTS[0], {**PARTS[1], "seen_from": "inside", "warp_angle": 30.0}])),
    "E-GEO-038": checked(mesh(reference=TETRAHEDRON.replace("0.3", "300"))),
    "E-GEO-039": checked(mesh(with_points("2000 0 0  2000.3 0 0  2000 0.3 0  2000 0 0.3"))),
    "E-GEO-070": bag(mesh_of={"vent_diameter": 0.1}, vents={"diameter": 0.004}),
    "E-GEO-110": lambda here: describe(mesh(TWO)(here).vary({"fabric.self_contact": "layers"})),
    "E-UNIT-001": checked(mesh(TETRAHEDRON.replace("0.3", "300"))),
    "W-UNIT-001": warned("W-UNIT-001", mesh(TETRAHEDRON.replace("0.3", "20"))),
    "W-MESH-006": warned("W-MESH-006", mesh(with_points("0 0 0  0.3 0 0  0 0.3 0  0.1 0 1e-5"))),
    "W-MESH-007": warned("W-MESH-007", mesh(TWO)),
    "W-MESH-004": warned("W-MESH-004", mesh(reference=TETRAHEDRON.replace("0.3", "0.4"))),
    "W-MESH-005": warned("W-MESH-005", mesh(with_points("0 0 0  0.3 0 0  0 0.3 0  0 0 1e-5"), TETRAHEDRON)),
}
