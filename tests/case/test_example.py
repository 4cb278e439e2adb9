"""`billow check --example` prints a case that loads, shows what a first user asks for, and says of it what is true."""

from __future__ import annotations

import tomllib

from billow.case.schema import Case
from billow.cli.example import EXAMPLE

OTHERWISE = {"title", "bag.element_size", "obstacles"}


def leaves(table, path=""):
    for key, value in table.items():
        if isinstance(value, dict) and not {"time", "value"} <= set(value):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


def test_the_example_loads_and_shows_inflator_vents_fabric_and_gas_line_by_line():
    case = Case.from_dict(tomllib.loads(EXAMPLE))
    assert [obstacle.name for obstacle in case.obstacles] == ["plate", "impactor"]
    for table in ("[bag.vents]", "[fabric]", "[gas]", "[inflator]", "[inflator.mass_flow]", "[inflator.jets]"):
        assert f"\n{table}" in EXAMPLE
    assert max(map(len, EXAMPLE.splitlines())) <= 120


def test_what_the_example_calls_a_default_is_one():
    given, default = tomllib.loads(EXAMPLE), Case()
    for key, _ in leaves(given):
        if key not in OTHERWISE and not key.startswith("obstacles"):
            here, there = Case.from_dict(given), default
            for part in key.split("."):
                here, there = (
                    place[part] if isinstance(place, dict) else getattr(place, part) for place in (here, there)
                )
            assert here == there, key
    assert Case.from_dict(given).obstacles[0] == default.obstacles[0]
