"""A run on disk, read piece by piece as it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from billow.base.errors import IntegrityError, ResourceError
from billow.base.toml_file import read_toml
from billow.results.blocks import STRAPS, StrapsFile
from billow.results.gas_frames import GAS, GasFrames
from billow.results.histories import TIME, Curves, History, read_histories
from billow.results.run_file import COPY_AGAIN, read_run_file
from billow.results.vtkhdf import FabricFile

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure
    from pandas import DataFrame

SINGLE_CHAMBER = "bag"
"""Name of the only chamber of a bag that has no others."""

UNREADABLE_CASE = IntegrityError.declare(
    "E-RES-015",
    "the case of a run cannot be read",
    where="{path}",
    cause="the run folder was written by another program, or case.toml was changed",
    remedy=COPY_AGAIN,
)


NOT_INSTALLED = ResourceError.declare(
    "E-RES-034",
    "{package} is not installed",
    where="Result.to_{package}",
    why="it is an optional package",
    remedy="install it: pip install 'billow[tables]'; or take the arrays of the result as they are",
)


class Result:
    """What one run left behind.

        result = Result.open("runs/driver")
        result.gas.pressure.max()                       # [Pa], over the whole run
        result.body("impactor").velocity                # [m/s], (rows, 3)
        result.reference + result.displacement[-1]      # last shape [m]

    folder: where it is; record: everything in run.json. Arrays are read from disk on first use and kept.
    status: "completed", "stopped" (for `record["reason"]`), or "interrupted" by the user; ledger: mass and energy
    balance at the end of the run, by name; wall_seconds: [s] the run took by the clock, with what came before it was
    resumed; computing_seconds: [s] of all processors together, which other programs beside it do not change much; by
    the clock where a run does not tell.
    """

    def __init__(self, folder: str | Path, record: dict):
        self.folder, self.record = Path(folder), record
        self.status: str = record["status"]
        self.ledger: dict[str, float] = record["ledger"]
        self.wall_seconds: float = record["wall_seconds"]
        self.computing_seconds: float = record.get("processor_seconds", self.wall_seconds)

    @classmethod
    def open(cls, folder: str | Path) -> Result:
        """Open a finished run whose files all verify; errors as `read_run_file`."""
        return cls(folder, read_run_file(folder))

    @classmethod
    def load(cls, folder: str | Path) -> Result:
        """The same as `open`, by the name that cases and surrogates have for it."""
        return cls.open(folder)

    def plot(self, *names: str, cfc: int | None = None, units: Sequence[str] = ()) -> Figure:
        """Curves as `billow plot` draws them, as a matplotlib figure, which notebooks show.

        names: quantities of the histories, such as "pressure" or "impactor_acceleration", by default the usual ones
        cfc: class of the channel filter; units: to show values in, where they fit
        InputError E-PIC-009 (no such quantity), E-PIC-003 (unit), E-INJ-001 to -003 (filter).
        """
        return _drawing().plot(self, names, cfc, units)

    def to_pandas(self) -> DataFrame:
        """Histories as a pandas table indexed by the time [s], a column for each. ResourceError E-RES-034 without
        pandas."""
        table = _optional("pandas").DataFrame(dict(self.histories))
        return table.set_index(TIME)

    def to_xarray(self) -> xarray.Dataset:
        """Frames as an xarray dataset: "position" and each field of fabric.vtkhdf over (time, node or triangle[, axis])
        with its unit, and "triangles", the nodes of each. ResourceError E-RES-034 without xarray."""
        fabric, arrays = self.fabric, {}
        arrays["position"] = (("time", "node", "axis"), np.stack(list(fabric.each_points())), {"units": "m"})
        for of, names, read in (
            ("node", fabric.point_fields, fabric.point_data),
            ("triangle", fabric.cell_fields, fabric.cell_data),
        ):
            for name in names:
                values, units = read(name), {"units": fabric.unit(name)}
                arrays[name] = (("time", of, "axis")[: values.ndim], values, units)
        arrays["triangles"] = (("triangle", "corner"), fabric.triangles)
        parts = np.array(fabric.part_names)[fabric.part]
        axes = {"time": ("time", fabric.times, {"units": "s"}), "axis": list("xyz"), "part": ("triangle", parts)}
        title = self.record.get("title") or self.folder.name
        return _optional("xarray").Dataset(arrays, axes, {"title": title})

    def _repr_html_(self) -> str:
        return _drawing().as_html(self)

    def __repr__(self) -> str:
        return f"Result({str(self.folder)!r}, status={self.status!r})"

    @cached_property
    def fabric(self) -> FabricFile:
        """The moving mesh with all its fields."""
        return FabricFile(self.folder / "fabric.vtkhdf")

    times = property(attrgetter("fabric.times"), doc="[s], (times,) float64: times of the frames.")
    reference = property(attrgetter("fabric.reference"), doc="[m], (nodes, 3) float32: the start shape.")
    triangles = property(attrgetter("fabric.triangles"), doc="(triangles, 3) int64: nodes of each triangle.")

    @cached_property
    def straps(self) -> StrapsFile | None:
        """The bars of the straps in every frame; None if there are none, or the run was made before they were kept."""
        path = self.folder / STRAPS
        return StrapsFile(path) if STRAPS in self.record["files"] else None

    @cached_property
    def gas_frames(self) -> GasFrames | None:
        """The gas place by place, in every frame; None if it is the same everywhere, or was not recorded."""
        return GasFrames(self.folder / GAS) if GAS in self.record["files"] else None

    @cached_property
    def displacement(self) -> np.ndarray:
        """[m], (times, nodes, 3) float32: from the start shape."""
        return self.fabric.point_data("displacement")

    @cached_property
    def contact_force(self) -> np.ndarray:
        """[N], (times, nodes, 3) float32: what obstacles that have an end do to each node; plates: `plate_force`."""
        return self.fabric.point_data("contact_force")

    @cached_property
    def gauge_pressure(self) -> np.ndarray:
        """[Pa], (times, triangles) float32: inside minus outside, on each triangle."""
        fields = self.fabric.cell_fields  # frames of format 1 call it pressure
        return self.fabric.cell_data("gauge_pressure" if "gauge_pressure" in fields else "pressure")

    @cached_property
    def histories(self) -> History:
        """Curves of histories.csv."""
        return read_histories(self.folder / "histories.csv")

    @property
    def gas(self) -> Curves:
        """Curves of the whole gas: pressure, temperature, volume and so on, and of the whole model."""
        return self.histories.of("")

    @cached_property
    def obstacles(self) -> dict[str, bool]:
        """Names of the obstacles, and whether each moves."""
        return {shape["name"]: not shape["locked"] for shape in self.record.get("obstacles", ())}

    @property
    def free_obstacles(self) -> tuple[str, ...]:
        """Names of the obstacles that forces move: free and guided ones, not those whose motion is prescribed."""
        return tuple(name for name, moves in self.obstacles.items() if moves and not self._is_prescribed(name))

    def _is_prescribed(self, name: str) -> bool:
        """Whether an obstacle goes its way whatever it takes; it has no acceleration of its own."""
        curves = self.histories.of(name)
        return "drive_work" in curves and "acceleration" not in curves

    def chamber(self, name: str) -> Curves:
        """Curves of the gas in a chamber: pressure, temperature, volume, mass, energy. KeyError if there is none."""
        curves = self.histories.of(name)
        if "volume" in curves:  # nothing else has one
            return curves
        if name != SINGLE_CHAMBER:
            raise KeyError(f"no chamber {name!r} in the histories of {self.folder}")
        return self.gas

    def body(self, name: str) -> Curves:
        """Curves of an obstacle: force, contact energy, penetration, and of a free one centre, velocity, acceleration,
        spin and quaternion. KeyError if there is none."""
        if name not in self.obstacles:
            raise KeyError(f"no obstacle {name!r} in {self.folder}; there are: {', '.join(self.obstacles) or 'none'}")
        return self.histories.of(name)

    @cached_property
    def case_toml(self) -> dict:
        """The effective case, every default filled in. IntegrityError E-RES-015 if it cannot be read."""
        path = self.folder / "case.toml"
        try:
            return read_toml(path)
        except (OSError, ValueError) as error:
            raise UNREADABLE_CASE(path=path, why=error) from error


Run = Result
"""What people look for beside Case and Study: billow.Run.load(folder)."""


def _optional(package: str):
    """A package that not everybody needs. ResourceError E-RES-034 if it is missing."""
    try:
        return import_module(package)
    except ImportError as error:
        raise NOT_INSTALLED(package=package) from error


def _drawing():
    """How a run is drawn is known in a room above this one, which is loaded when it is asked for."""
    return import_module("billow.pictures.notebook")
