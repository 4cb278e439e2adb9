"""What is wrong with the gas of a case: chambers, passages, inflators."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from here import Here
from triggers_cases import case

from billow.case.bag.build_bag import build_shape
from billow.case.gas.build_gas import build_gas
from billow.case.schema import Case

HOLE = {"name": "hole", "between": ["bag", "ambient"], "area": 1e-4}
TWO_CHAMBERS = {"shape": "rectangular", "chambers": 2, "element_size": 0.05}


def without_air(here: Here):
    """A bag whose panels lie on each other."""
    flat = Case.from_dict({"bag": {"element_size": 0.05}})
    shape = build_shape(flat.bag)
    return build_gas(flat, dataclasses.replace(shape, positions=shape.positions * [1.0, 1.0, 0.0]))


def opening_to_itself(here: Here):
    bag = Case.from_dict({"bag": TWO_CHAMBERS, "inflator": {"jets": {"count": 0}}})
    shape = build_shape(bag.bag)
    chambers = shape.surface.chambers
    ahead = chambers.ahead.copy()
    opening = shape.surface.triangles_of_kind("opening")
    ahead[opening] = chambers.behind[opening]
    surface = dataclasses.replace(shape.surface, chambers=dataclasses.replace(chambers, ahead=ahead))
    return build_gas(bag, dataclasses.replace(shape, surface=surface))


def jets_without_a_mouth(here: Here):
    bag = Case.from_dict({"bag": TWO_CHAMBERS, "inflator": {"chamber": "chamber_2"}})
    shape = build_shape(bag.bag)
    assert "chamber_2" in shape.surface.chambers.names
    assert not np.isin(shape.surface.chambers.behind[shape.surface.triangles_of_kind("mouth")], 1).any()
    return build_gas(bag, shape)


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-GAS-001": case(inflator__gas={"xenon": 1.0}),
    "E-GAS-002": case(inflator__chamber="left"),
    "E-GAS-003": case(leakage={"parts": {"side": {}}}),
    "E-GAS-004": without_air,
    "E-GAS-005": opening_to_itself,
    "E-GAS-006": jets_without_a_mouth,
    "E-GAS-007": case(gas={"model": "corpuscular", "orifices": [HOLE]}),
}
