"""The case: what a user writes, one strict schema with units, ranges and defaults.

The defaults describe a 60-litre driver bag; where they come from: docs/theory.md, Default driver bag. The reference in
docs/case.md is generated from this file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import field_validator, model_validator

from billow.base.markup import table_of
from billow.case.bag.schema_bag import Bag, DriverBag
from billow.case.case_file import load_case, validate
from billow.case.fabric.schema_fabric import Fabric
from billow.case.gas.schema_gas import NO_INFLATOR, Ambient, Gas, Inflator, Inflators, Leakage
from billow.case.named_files import files_digest
from billow.case.nodes.schema_nodes import NodeGroup
from billow.case.obstacles.obstacles import Obstacle, Plate
from billow.case.quantity import Name, Strict, Text, distinct, quantity, refused, whole
from billow.case.vary import vary

Acceleration = quantity("m/s^2", -100.0, 100.0)
Coordinate = quantity("m", -10.0, 10.0)
MOST_ROWS = 100_000  # of histories; a run that needs 50 ms has 500


class Sensor(Strict):
    """A point where a corpuscular or mesh gas is measured: columns of histories.csv for pressure, temperature, density
    and velocity. Values are means over the nearest 400 particles, or those of the cell."""

    name: Name
    """Name, for the histories."""
    position: tuple[Coordinate, Coordinate, Coordinate]
    """Position in the coordinates of the bag; it does not move with the fabric."""


class Run(Strict):
    """Times and output."""

    end_time: quantity("s", 1e-6, 1.0) = 0.050
    """Simulated time."""
    frames: whole(1, 10_000) = 50
    """Number of output frames after the start, evenly spaced."""
    histories_per_frame: whole(1, 10_000) = 10
    """Rows of histories.csv per frame."""
    dt_scale: quantity("-", 0.01, 1.0) = 1.0
    """Fraction of the stable step to use."""
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, 0.0)
    """Acceleration of gravity; negligible during a deployment."""
    guard_crossings: bool = False
    """Whether to count at every frame where fabric passes through fabric, and to write the places to fabric.vtkhdf; at
    start and end it is always counted."""
    gas_frames: bool = True
    """Whether to write gas.vtkhdf at every frame: the corpuscular gas in boxes of about 100 particles, the mesh gas in
    its cells."""
    particle_times: tuple[quantity("s", 0.0, 1.0), ...] = ()
    """Times at which the particles themselves are written to particles.vtkhdf, at the next row of the histories."""
    sensors: tuple[Sensor, ...] = ()

    _distinct = field_validator("sensors")(distinct("sensors"))

    @model_validator(mode="after")
    def _fits(self):
        late = [time for time in self.particle_times if time > self.end_time]
        if late:
            raise refused(
                f"particle_times has {late[0]:g} s, after end_time, {self.end_time:g} s",
                "remove that time, or raise run.end_time",
                kind="range",
            )
        rows = self.frames * self.histories_per_frame
        if rows > MOST_ROWS:
            raise refused(
                f"frames times histories_per_frame makes {rows} rows of histories; at most {MOST_ROWS}",
                "reduce frames or histories_per_frame",
            )
        return self


class Case(Strict):
    """A whole simulation."""

    title: Text = "Airbag"
    """Free text."""
    bag: Bag = DriverBag()
    fabric: Fabric = Fabric()
    gas: Gas = Gas()
    leakage: Leakage = Leakage()
    inflator: Inflators = Inflator()
    ambient: Ambient = Ambient()
    obstacles: tuple[Obstacle, ...] = (Plate(shape="plate"),)
    nodes: tuple[NodeGroup, ...] = ()
    run: Run = Run()

    _obstacles = field_validator("obstacles")(distinct("obstacles"))
    _nodes = field_validator("nodes")(distinct("groups of nodes"))
    _inflators = field_validator("inflator")(distinct("inflators"))

    @field_validator("inflator")
    @classmethod
    def _at_least_one(cls, value):
        if value == ():
            raise refused("the list is empty", NO_INFLATOR)
        return value

    @property
    def inflators(self) -> tuple[Inflator, ...]:
        """All inflators, even if there is only one."""
        return self.inflator if isinstance(self.inflator, tuple) else (self.inflator,)

    def _repr_html_(self) -> str:
        """For notebooks: what differs from the defaults, as TOML."""
        own, usual = self.to_dict(), Case().to_dict()
        rows = [(key, tomli_w.dumps({key: own[key]})) for key in own if key != "title" and own[key] != usual.get(key)]
        return table_of(self.title, rows or [("", "every default")])

    @classmethod
    def load(cls, path: str | Path) -> Case:
        """Case from a TOML file; raises InputError with file, key, value and remedy."""
        return load_case(cls, path)

    @classmethod
    def from_dict(cls, data: dict[str, Any], where: str = "case") -> Case:
        """Case from nested dictionaries; raises InputError."""
        return validate(cls, data, where)

    def to_dict(self) -> dict[str, Any]:
        """Every key with its effective value, defaults filled in."""
        return self.model_dump(mode="python")

    def to_toml(self) -> str:
        """The effective case as TOML."""
        return tomli_w.dumps(self.to_dict())

    @property
    def files(self) -> dict[str, Path]:
        """Mesh files that the case needs, by the key that names them: bag.start, obstacles.head."""
        named = {f"bag.{key}": getattr(self.bag, key, "") for key in ("start", "reference")}
        named |= {f"obstacles.{one.name}": getattr(one, "file", "") for one in self.obstacles}
        return {key: Path(path) for key, path in named.items() if path}

    def with_files(self, paths: Mapping[str, str]) -> Case:
        """The case with the same mesh files at other paths, by their key in `files`; their digests are noted."""
        bag, changed = self.bag, []
        of_bag = {key.removeprefix("bag."): path for key, path in paths.items() if key.startswith("bag.")}
        if of_bag:
            bag = bag.model_copy(update={**of_bag, "digest": bag.digest or files_digest(bag.start, bag.reference)})
        for one in self.obstacles:
            if path := paths.get(f"obstacles.{one.name}"):
                one = one.model_copy(update={"file": path, "digest": one.digest or files_digest(one.file)})
            changed.append(one)
        return self.model_copy(update={"bag": bag, "obstacles": tuple(changed)})

    def digest(self) -> str:
        """SHA-256 of the effective case: equal for equal physics and settings, wherever its files lie."""
        data = self.to_dict()
        tables = {"bag": data["bag"], **{f"obstacles.{one['name']}": one for one in data["obstacles"]}}
        for key, keys in {"bag": ("start", "reference"), **dict.fromkeys(tables.keys() - {"bag"}, ("file",))}.items():
            named = [name for name in keys if tables[key].get(name)]
            if named and (content := tables[key]["digest"] or files_digest(*(tables[key][name] for name in named))):
                tables[key] |= {**dict.fromkeys(named, ""), "digest": content}
        return hashlib.sha256(tomli_w.dumps(data).encode()).hexdigest()

    def vary(self, changes: dict[str, Any]) -> Case:
        """The case with dotted keys replaced, for example {"fabric.permeability": 0.03, "obstacles.impactor.degree":
        3.0}.

        Obstacles are addressed by name. Raises InputError for unknown keys or bad values.
        """
        return validate(type(self), vary(self.to_dict(), changes), "design parameters")
