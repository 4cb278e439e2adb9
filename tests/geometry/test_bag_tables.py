"""The `[bag]` table: the shape chooses the keys, and what is wrong is told for the shape that was meant."""

from __future__ import annotations

import pytest

from billow.base.errors import InputError
from billow.case.schema import Case

MESH = {"shape": "mesh", "start": "a.vtk", "parts": [{"name": "front"}]}


def test_a_bag_without_a_shape_is_a_driver_bag():
    assert (
        Case.from_dict({"bag": {"diameter": 0.6}}).bag
        == Case.from_dict({"bag": {"shape": "driver", "diameter": 0.6}}).bag
    )
    assert Case().bag.shape == "driver"


@pytest.mark.parametrize("bag", [{}, {"shape": "square"}, {"shape": "rectangular", "chambers": 3}, MESH])
def test_every_shape_goes_through_its_file(bag):
    case = Case.from_dict({"bag": bag})
    assert Case.from_dict(case.to_dict()) == case
    assert case.to_toml()


@pytest.mark.parametrize(
    ("bag", "code", "key", "words"),
    [
        ({"shape": "sqare"}, "E-CASE-005", "bag", "shape = 'square'"),
        ({"shape": 3}, "E-CASE-005", "bag", "shape = 'square'"),
        ({"shape": "square", "sde": 0.5}, "E-CASE-003", "bag.sde", "did you mean 'side'"),
        ({"shape": "square", "diameter": 0.5}, "E-CASE-003", "bag.diameter", "known keys here"),
        ({"diametre": 0.7}, "E-CASE-003", "bag.diametre", "did you mean 'diameter'"),
        ({"shape": "mesh", "parts": []}, "E-CASE-004", "bag.start", "add start"),
        ({**MESH, "parts": []}, "E-CASE-005", "bag.parts", "[[bag.parts]]"),
        ({**MESH, "parts": {"name": "front"}}, "E-CASE-005", "bag.parts", "[[bag.parts]] with two brackets"),
        ({**MESH, "parts": MESH["parts"] * 2}, "E-CASE-005", "bag.parts", "two parts are called front"),
        ({**MESH, "parts": [{"name": "a", "kind": "hole"}]}, "E-CASE-005", "bag.parts.0.kind", "'mouth'"),
        ({**MESH, "unit": "km"}, "E-CASE-005", "bag.unit", "mm"),
        ({**MESH, "straps": [{"nodes": [[1, 1]]}]}, "E-CASE-005", "bag.straps.0.nodes", "[[12, 340]"),
        ({"shape": "square", "straps": [{"front": [0, 0]}]}, "E-CASE-004", "bag.straps.0.rear", "add rear"),
        ({"straps": {"length": 50}}, "E-CASE-005", "bag.straps.length", "50 mm"),
        ({"coated": ["top"]}, "E-CASE-005", "bag.coated.0", "'front' or 'rear'"),
        ({"shape": "rectangular", "chambers": 0}, "E-CASE-005", "bag.chambers", "1 to 64"),
    ],
)
def test_refused_with_key_and_remedy(bag, code, key, words):
    with pytest.raises(InputError, match=code) as caught:
        Case.from_dict({"bag": bag})
    assert caught.value.where.endswith(f"key {key}")
    assert words in caught.value.why + caught.value.remedy
