"""What looks unintended about a mesh: its size, how the start shape fits the flat cut, straps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from billow.base.errors import Concern
from billow.case import schema
from billow.geometry.reference_check import NOTICED, Panel, panels, place
from billow.solver.model import Model

START_STRAIN = 0.05
"""Strain of fabric or straps at the start from which on it cannot be meant."""

MANY = 0.05
"""Share of a panel's triangles from which on compression is no matter of a few odd elements."""

FEWEST = 10
"""Elements across a chamber below which shape and volume mean little."""


def mesh_warnings(case: schema.Case, model: Model) -> Iterator[Concern]:
    """Everything about the mesh of a case that looks unintended."""
    chambers = model.surface.chambers.count
    fabric = model.contact_area.sum()
    across = 2.0 * np.sqrt(fabric / chambers / (2.0 * np.pi))  # two discs of the same area
    edge = np.sqrt(4.0 / np.sqrt(3.0) * fabric / sum(len(m.elements) for m in model.membranes))
    if edge > across / FEWEST:
        yield Concern(
            "W-MESH-001",
            f"only {across / edge:.0f} elements across the {'bag' if chambers == 1 else 'chambers'}",
            f"bag.{'start' if case.bag.shape == 'mesh' else 'element_size'}",
            "shape and volume will be off by several percent",
            "use at least twenty elements across",
        )
    yield from _panels(case, model)
    yield from _straps(case, model)


def _straps(case: schema.Case, model: Model) -> Iterator[Concern]:
    driver = case.bag.shape == "driver"
    ends = model.start[model.straps.bars]
    distance = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    taut = distance / model.straps.length - 1.0
    if len(taut) and taut.max() > START_STRAIN:
        bar = int(taut.argmax())
        yield Concern(
            "W-MESH-003",
            f"a strap of {model.straps.length[bar]:g} m starts {distance[bar]:.3g} m long",
            f"{'bag.straps.length' if driver else 'bag.straps'}, strap {model.straps.strap[bar] + 1}",
            "it would snap back at the first step",
            "lengthen bag.straps.length, or bring bag.straps.stitch_radius closer to bag.mouth_radius"
            if driver
            else "give the strap more length or slack in bag.straps",
        )


def start_panels(model: Model) -> list[Panel]:
    """How every panel's start shape fits its flat cut."""
    found = []
    for membrane in model.membranes:
        d11, d12, d21, d22 = membrane.reference_inverse
        first, second = (np.column_stack(e) / (d11 * d22 - d12 * d21)[:, None] for e in ((d22, -d21), (-d12, d11)))
        flat = np.stack([np.zeros_like(first), first, second], axis=1)
        found += panels(model.surface, model.start, membrane.elements, flat)
    return found


def _panels(case: schema.Case, model: Model) -> Iterator[Concern]:
    read = case.bag.shape == "mesh"
    if read and case.bag.birth_time:
        return  # the user knows, and the reference moves slowly
    key = "bag.start, bag.reference" if read else "bag.initial_gap"
    for panel in start_panels(model):
        if panel.longest > 1.0 + START_STRAIN:
            yield Concern(
                "W-MESH-002",
                f"{100 * panel.stretched:.3g} % of part {panel.name} starts stretched by more than "
                f"{100 * NOTICED:g} %, at most by {100 * (panel.longest - 1.0):.3g} %",
                f"{place(model.surface, model.start, panel.longest_at)}; {key}",
                "it would snap back at the first step: the start shape is not the shape the fabric was cut in",
                "set bag.birth_time to 1 or 2 ms" if read else "use a bag.initial_gap of a few millimetres",
            )
        if panel.collapsed:
            yield Concern(
                "W-MESH-005",
                f"{100 * panel.collapsed:.3g} % of part {panel.name} has collapsed at the start",
                f"{place(model.surface, model.start, panel.collapsed_at)}; {key}",
                "a triangle without area has no side that gas could push on",
                "move the nodes of the start shape apart",
            )
        elif panel.compressed > MANY and panel.shortest < 1.0 - START_STRAIN:
            yield Concern(
                "W-MESH-004",
                f"{100 * panel.compressed:.3g} % of part {panel.name} starts compressed by more than "
                f"{100 * NOTICED:g} %, at most by {100 * (1.0 - panel.shortest):.3g} %",
                f"{place(model.surface, model.start, panel.shortest_at)}; {key}",
                "folds keep lengths: a start shape smaller than the flat cut holds fabric that is nowhere",
                "check bag.unit and bag.reference, or fold the start shape without shortening it",
            )
