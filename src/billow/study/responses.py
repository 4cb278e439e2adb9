"""`[[responses]]`: numbers read off each run of a study, from a closed list of measures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from billow.study.variables import StrictTable, Text, Unit, VariableName

OF_HISTORY = ("peak", "least", "final", "mean", "at", "time_of_peak", "time_to", "integral")
"""Measures of a curve over time, which need a quantity."""
INJURIES = ("hic15", "hic36", "clip3ms")
OF_OBSTACLE = (*INJURIES, "penetration", "first_contact", "contact_duration")
OF_BOOKS = ("energy_share", "vented_mass", "fill_time")
OF_FRAMES = ("height", "width", "distance", "section_area", "contact_area")
OF_REFERENCE = ("rating",)
WITHOUT_MODEL = {
    "nij": "it is made of the force and the moment in a neck, and no obstacle has one",
    "vc": "it is made of how fast and how far a chest is pressed in, and obstacles are rigid",
    "rib": "it is how far a rib is pressed in, and obstacles are rigid",
}
"""Measures of the neck and the chest of a dummy, and why they cannot be read off a run of a bag and rigid obstacles."""
MEASURES = (*OF_HISTORY, *OF_OBSTACLE, *OF_BOOKS, *OF_FRAMES, *OF_REFERENCE)

Point = Annotated[tuple[float, float, float], Field(strict=False)]


class Limit(StrictTable):
    """The side of a response that is wanted, in its unit."""

    below: float | None = None
    """Values below it are wanted."""
    above: float | None = None
    """Values above it are wanted."""


class StudyResponse(StrictTable):
    """A number read off each run."""

    name: VariableName
    """What it is called in tables and by commands: letters, digits and _."""
    measure: Literal[MEASURES]
    """What is read off: of a curve, of an obstacle, of the books, of the shape, or against a reference curve."""
    of: str = ""
    """Obstacle, chamber, strap or sensor it belongs to, part of the mesh for shapes; empty for the whole model."""
    quantity: Text | None = None
    """Curve that is measured, such as "acceleration", "velocity.z", "volume", "gauge_pressure" or "absolute_pressure";
    of a vector without an axis its length. For energy_share the account."""
    filter: Literal["CFC60", "CFC180", "CFC600", "CFC1000"] | None = None
    """Channel class that the curve goes through first (SAE J211)."""
    unit: Unit | None = None
    """Unit of the response, level and limit, such as "kPa"; default: that of the curve, SI."""
    time: Annotated[float, Field(ge=0)] | None = None
    """[s] For measure at; of the frame for measures of the shape, default: the last, for contact_area the largest."""
    level: float | None = None
    """For measure time_to: the value that is reached, in `unit`; the response itself is in s."""
    point: Point | None = None
    """[m] For measure distance: of the nearest node from it, or of the plane; for section_area: of the plane."""
    normal: Point | None = None
    """For distance and section_area: normal of a plane through `point`; distances on its side count positive."""
    reference: Text | None = None
    """For measure rating: CSV of two columns, time [s] and the curve in `unit`; relative to the study file."""
    scale: Literal["auto", "identity", "log", "root"] = "auto"
    """What the response surface is made of; auto: what has the least errors on runs held out."""
    limit: Limit = Limit()
    """What is wanted of it, for robustness and figures; limits of an optimum stand in its goals.toml."""

    @property
    def channel_class(self) -> int | None:
        """Channel frequency class of its filter."""
        return None if self.filter is None else int(self.filter.removeprefix("CFC"))

    @field_validator("measure", mode="before")
    @classmethod
    def _has_a_model(cls, measure: object) -> object:
        if isinstance(measure, str) and (why := WITHOUT_MODEL.get(measure.lower())):
            raise PydanticCustomError("without_model", "{why}; hic15, hic36, clip3ms are of the head", {"why": why})
        return measure

    def contradictions(self) -> Iterator[tuple[str, str, str]]:
        """What is wrong, why, and what to do, of each contradiction."""
        needs = {
            "quantity": self.measure in (*OF_HISTORY, "energy_share", "rating"),
            "of": self.measure in OF_OBSTACLE,
            "time": self.measure == "at",
            "level": self.measure == "time_to",
            "point": self.measure in ("distance", "section_area"),
            "normal": self.measure == "section_area",
            "reference": self.measure == "rating",
        }
        for key, needed in needs.items():
            if needed and getattr(self, key) in (None, ""):
                yield f"measure = {self.measure!r} without {key}", "it would not say what is measured", f"give {key}"
        fits = {
            "level": needs["level"],
            "point": needs["point"],
            "normal": needs["point"],
            "reference": needs["reference"],
            "time": self.measure == "at" or self.measure in OF_FRAMES,
            "filter": self.measure in (*OF_HISTORY, "rating"),
        }
        for key, may in fits.items():
            if not may and getattr(self, key) is not None:
                yield f"{key} with measure = {self.measure!r}", "it would have no meaning there", f"leave {key} out"
        if self.quantity is not None and self.quantity.split(".")[0] == "pressure":
            why = "a pressure is absolute or above the ambient one, and both are in use"
            yield f"quantity = {self.quantity!r}", why, 'write "absolute_pressure" or "gauge_pressure"'
        below, above = self.limit.below, self.limit.above
        if below is not None and above is not None and not above < below:
            yield f"limit below {below:g} and above {above:g}", "nothing lies between", "give above less than below"
        if self.normal is not None and not any(self.normal):
            yield "normal = [0, 0, 0]", "it has no direction", "write for example [0, 0, 1]"
