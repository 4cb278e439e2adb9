"""The gas of a page: its boxes at each time, and what is known in them, for the section."""

from __future__ import annotations

import numpy as np

from billow.pages.packed import MOST_STEPS, in_bytes
from billow.pictures.shown_units import factor_of, shown_unit
from billow.results.gas_frames import GasFrames

FIELDS = ("pressure", "temperature", "density", "velocity")
"""That are shown, of a velocity its length."""
SAME_TIME = 1e-6
"""[s] by which a frame of the gas may lie beside one of the fabric."""
UNUSUAL = 0.01
"""Share of the values at either end that colours do not resolve: boxes that hold next to nothing."""


def packed_gas(gas: GasFrames, times: np.ndarray) -> tuple[dict[str, np.ndarray], list[dict]]:
    """Boxes of the frames at `times` [s] as the scripts of the page read them, and the fields.

    "gas.corners": low and high corner in steps of the box of all, (boxes, 6) uint16; "gas.box": [m], (2, 3);
    "gas.starts": where each frame begins, (times + 1,); "gas.0" and so on, of each field: as `in_bytes`, between the
    ends that the record says, (boxes,) uint8
    """
    frames = [np.abs(gas.times - time).argmin() for time in times]
    each = [gas.boxes(k) if abs(gas.times[k] - t) <= SAME_TIME else None for k, t in zip(frames, times, strict=True)]
    found = [boxes for boxes in each if boxes is not None and len(boxes.low)]
    if not found:
        return {}, []
    corners = np.concatenate([np.hstack([boxes.low, boxes.high]) for boxes in found]).astype(float)
    box = np.stack([corners[:, :3].min(axis=0), corners[:, 3:].max(axis=0)])
    span = np.where(box[1] > box[0], box[1] - box[0], 1.0)
    steps = np.rint((corners - np.tile(box[0], 2)) / np.tile(span, 2) * MOST_STEPS).astype(np.uint16)
    counts = [0 if boxes is None else len(boxes.low) for boxes in each]
    tensors = {"gas.corners": steps, "gas.box": box, "gas.starts": np.cumsum([0, *counts]).astype(np.uint32)}
    told = []
    for place, name in enumerate(field for field in FIELDS if field in gas.fields):
        values = np.concatenate([boxes.values[name] for boxes in found]).astype(float)
        values = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
        known = values[np.isfinite(values)]
        low, high = np.quantile(known, [UNUSUAL, 1.0 - UNUSUAL]).tolist() if len(known) else (0.0, 0.0)
        tensors[f"gas.{place}"] = in_bytes(values[None], low, high)[0]
        unit = shown_unit(gas.unit(name), max(abs(low), abs(high)))
        factor = factor_of(gas.unit(name), unit)
        title = "speed" if name == "velocity" else name
        told.append({"title": f"{title} of the gas", "unit": unit, "low": low / factor, "high": high / factor})
    return tensors, told
