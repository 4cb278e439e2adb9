"""What is wrong with folds."""

from __future__ import annotations

from collections.abc import Callable

from here import Here
from triggers_geometry import bag, warned

from billow.apps.folding.folder import fold_case
from billow.case.schema import Case

LEPORELLO = {"kind": "leporello", "first_line": 0.12, "panel": 0.06}
ROLL = {"kind": "roll", "to": 0.1, "core": 0.03}
TWO_LINES = {**LEPORELLO, "lines": [0.1, 0.2]}
TWO_CHAMBERS = {"chambers": 2, "mouth_chamber": 1}
TUBE = {"shape": "rectangular", "length": 0.8, "width": 0.2, "mouth_radius": 0.02, "element_size": 0.02}


def folded(*folds: dict, **settings) -> Callable[[Here], object]:
    """Check the sound case with a square bag and its folds."""
    return bag(**{"shape": "square", "element_size": 0.02, **settings, "folds": list(folds)})


def case(*folds: dict, fabric: dict | None = None, gas: dict | None = None, **settings) -> Callable[[Here], Case]:
    table = {"shape": "square", "element_size": 0.02, **settings, "folds": list(folds)}
    return lambda here: Case.from_dict(
        {"bag": table, "gas": gas or {"model": "none"}, "obstacles": [], "fabric": fabric or {}}
    )


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GEO-040": folded({**LEPORELLO, "first_line": 0.06}),
    "E-GEO-041": folded({**LEPORELLO, "lines": [0.12, 0.1205]}),
    "E-GEO-042": folded({**LEPORELLO, "first_line": 0.35}),
    "E-GEO-043": folded({"kind": "half", "line": 0.15}, {"kind": "roll", "to": 0.1}),
    "E-GEO-044": folded({"kind": "roll", "core": 0.003}),
    "E-GEO-045": folded(LEPORELLO, {**LEPORELLO, "across": "y"}, {"kind": "half", "line": 0.1}),
    "E-GEO-046": bag(**TUBE, **TWO_CHAMBERS, folds=[{"kind": "half", "line": 0.203}]),
    "E-GEO-047": lambda here: fold_case(case()(here), here.place / "folded"),
    "E-GEO-048": bag(element_size=0.02, folds=[{**LEPORELLO, "lines": [0.16, 0.345]}]),
    "E-GEO-049": bag(element_size=0.02, folds=[TWO_LINES, {**TWO_LINES, "lines": [0.12, 0.2], "across": "y"}]),
    "W-MESH-008": warned(
        "W-MESH-008",
        case(LEPORELLO, vents={"count": 1, "diameter": 0.04, "distance": 0.175}, fabric={"self_contact": False}),
    ),
    "W-GAS-020": warned(
        "W-GAS-020",
        case({"kind": "leporello", "lines": [0.1, 0.16]}, gas={"model": "mesh", "cell": 0.05}, **TUBE, **TWO_CHAMBERS),
    ),
    "W-GAS-140": warned(
        "W-GAS-140",
        case(
            LEPORELLO,
            gas={"model": "mesh", "cell": 0.05},
            fabric={"self_contact": False},
            vents={"count": 1, "diameter": 0.04, "distance": 0.175},
        ),
    ),
    "W-FAB-006": warned("W-FAB-006", case(LEPORELLO, fabric={"self_contact": True})),
    "W-FAB-007": warned("W-FAB-007", case(fabric={"friction": 0.2})),
    "W-MESH-009": warned("W-MESH-009", case({**LEPORELLO, "layer_gap": 0.0005})),
}
