"""The `[[nodes]]` tables: nodes of the bag that are held or moved, or that move at the start."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator, model_validator

from billow.case.bag.quantities import Node
from billow.case.obstacles import motion
from billow.case.quantity import Name, Strict, chosen_by, quantity, refused

Coordinate = quantity("m", -10.0, 10.0)
Speed = quantity("m/s", -100.0, 100.0)
Spin = quantity("rad/s", -1e3, 1e3)
Axis = Literal["x", "y", "z"]


class Free(motion.MotionTable):
    """Nothing holds the nodes but the bag."""

    kind: Literal["none"] = "none"
    """none"""


class Fixed(motion.MotionTable):
    """They stay where they are in some directions."""

    kind: Literal["fixed"]
    """fixed"""
    directions: tuple[Axis, ...] = ("x", "y", "z")
    """Directions in which they stay; along the others they yield."""

    @field_validator("directions")
    @classmethod
    def _some(cls, value):
        if not value or len(set(value)) < len(value):
            raise refused("it names no direction, or one twice", 'write directions = ["z"]')
        return value


class NodesTravel(motion.Travel):
    """Their way from the start is given."""

    across: Literal["held", "free"] = "held"
    """Whether they are held across the direction, or yield there."""


class NodesSpeed(motion.Speed):
    """Their speed is given."""

    across: Literal["held", "free"] = "held"
    """Whether they are held across the direction, or yield there."""


HOLDS = {"none": Free, "fixed": Fixed, "travel": NodesTravel, "speed": NodesSpeed}
"""Table of each kind."""
Hold = chosen_by("kind", HOLDS, default="none")


class NodeGroup(Strict):
    """Nodes of the bag that are held or moved, or that move at the start: those that meet all of its conditions;
    without any, all nodes. What the bag itself holds (mouth, fixed_nodes, fixed parts) stays held, unless the group
    moves it; obstacles do not touch nodes that are held in some directions only."""

    name: Name
    """Name in results."""
    parts: tuple[Name, ...] = ()
    """Nodes of these parts of the bag."""
    between: tuple[Name, ...] = ()
    """Nodes that all of these parts share: a seam, the rim of a vent or of the mouth."""
    low: tuple[Coordinate, Coordinate, Coordinate] = (-10.0, -10.0, -10.0)
    """Lowest coordinates of the box in which they lie at the start."""
    high: tuple[Coordinate, Coordinate, Coordinate] = (10.0, 10.0, 10.0)
    """Highest coordinates of that box."""
    numbers: tuple[Node, ...] = ()
    """Nodes by number, counted from 0."""
    velocity: tuple[Speed, Speed, Speed] = (0.0, 0.0, 0.0)
    """Velocity at the start."""
    spin: tuple[Spin, Spin, Spin] = (0.0, 0.0, 0.0)
    """Angular velocity at the start, about the axes of space, added to it."""
    about: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Point about which they spin."""
    motion: Hold = Free()

    @property
    def starts(self) -> bool:
        """Whether it says how its nodes move at the start."""
        return any(self.velocity) or any(self.spin)

    @model_validator(mode="after")
    def _says_something(self):
        if not self.starts and self.motion.kind == "none":
            raise refused("it says nothing of its nodes", "give it velocity, spin or motion, or remove it")
        if self.starts and self.motion.kind != "none" and getattr(self.motion, "across", "free") == "held":
            raise refused("nodes whose place is given have no velocity of their own", "remove velocity and spin")
        return self
