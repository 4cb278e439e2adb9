"""Field types that the tables of several bags have in common."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator

from billow.case.quantity import quantity, refused, whole

Length = quantity("m", 1e-4, 10.0)
Offset = quantity("m", -10.0, 10.0)
Fraction = quantity("-", 0.0, 1.0)
Angle = quantity("deg", -180.0, 180.0)
Layers = quantity("-", 1.0, 20.0)
Panel = Literal["front", "rear"]
Node = whole(-(10**7), 10**7)


def _pairs(value):
    """A validator of pairs of nodes."""
    if not value or any(a == b for a, b in value):
        raise refused("two different nodes are joined", "write pairs: nodes = [[12, 340], [13, 341]]")
    return value


NodePairs = Annotated[tuple[tuple[Node, Node], ...], AfterValidator(_pairs)]
