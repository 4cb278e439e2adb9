"""The kinds of bag; a case selects one with `shape`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from billow.case.bag.schema_bag import DriverBag, RectangularBag, SquareBag
from billow.case.bag.schema_mesh_bag import MeshBag
from billow.case.quantity import refused

BAGS = {"driver": DriverBag, "square": SquareBag, "rectangular": RectangularBag, "mesh": MeshBag}
"""Table of each shape."""


def _known_shape(value: Any) -> Any:
    """A bag without a shape is a driver bag."""
    if not isinstance(value, dict):
        return value
    if "shape" not in value:
        return {"shape": "driver", **value}
    if value["shape"] not in tuple(BAGS):
        given = value["shape"]
        reason = f"there is no shape {given[:40]!r}" if isinstance(given, str) else "its shape is no text"
        remedy = f"write {' or '.join(f'shape = {shape!r}' for shape in BAGS)}"
        raise refused(reason, remedy)
    return value


Bag = Annotated[
    DriverBag | SquareBag | RectangularBag | MeshBag, Field(discriminator="shape"), BeforeValidator(_known_shape)
]
