"""Fields of the frames by the names that pictures give them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.close_names import did_you_mean
from billow.base.errors import InputError
from billow.results.vtkhdf import FabricFile

NO_FIELD = InputError.declare(
    "E-PIC-002",
    "the frames hold no field {name!r}",
    where="{path}",
    why="its fields are {known}",
    cause="a misspelt name, or a run of an earlier version of Billow",
    remedy="{hint}name one of these with --field",
)

ALIASES = {
    "pressure": ("gauge_pressure", "pressure"),  # frames of format 1 call it pressure
    "speed": ("velocity",),
    "temperature": ("gas_temperature",),
    "force": ("contact_force",),
}
"""What pictures call fields of the frames."""
TITLES = {
    "displacement": "displacement", "velocity": "speed", "gauge_pressure": "gauge pressure",
    "pressure": "gauge pressure", "half_width": "half width of the interval",
}  # fmt: skip


RARE, FAR = 0.002, 0.25
"""Share of the values at either end that may lie off, and how far off, in ranges of the others, is far."""


@dataclass(frozen=True)
class Field:
    """title: for people. unit: of SI. at_nodes: whether it belongs to nodes, else to triangles. values: (times, n)
    float32; of a vector, its length."""

    title: str
    unit: str
    at_nodes: bool
    values: np.ndarray

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest value that is a number."""
        sound = self.values[np.isfinite(self.values)]
        return (float(sound.min()), float(sound.max())) if sound.size else (0.0, 0.0)

    @property
    def usual_limits(self) -> tuple[float, float]:
        """As `limits`, but without what lies far off: a few folded triangles must not take all colours."""
        low, high = self.limits
        sound = self.values[np.isfinite(self.values)]
        if not sound.size:
            return low, high
        usual_low, usual_high = (float(q) for q in np.quantile(sound, [RARE, 1.0 - RARE]))
        far = FAR * (usual_high - usual_low)
        return low if usual_low - low <= far else usual_low, high if high - usual_high <= far else usual_high


def read_field(fabric: FabricFile, name: str) -> Field:
    """A field of the frames. InputError E-PIC-002 if there is none; IntegrityError E-RES-007."""
    held = (*fabric.point_fields, *fabric.cell_fields)
    found = next((field for field in (*ALIASES.get(name, ()), name) if field in held), None)
    if found is None:
        known = sorted({*held, *(alias for alias, fields in ALIASES.items() if set(fields) & set(held))})
        raise NO_FIELD(name=name[:40], path=fabric.path, known=", ".join(known), hint=did_you_mean(name, known))
    at_nodes = found in fabric.point_fields
    values = fabric.point_data(found) if at_nodes else fabric.cell_data(found)
    if values.ndim == 3:
        values = np.linalg.norm(values, axis=2)
    return Field(TITLES.get(found, found.replace("_", " ")), fabric.unit(found), at_nodes, values)
