"""What bags of two sewn panels have in common."""

from __future__ import annotations

from pydantic import field_validator, model_validator

from billow.case.bag.quantities import Angle, Layers, Panel
from billow.case.bag.schema_folds import Fold, Relax
from billow.case.bag.schema_tear_seams import Cover, PanelTearSeam
from billow.case.quantity import Strict, distinct, quantity, refused

MOST_FOLDS = 20


class Seam(Strict):
    """Seams: fabric lies in several layers beside the stitching, at the rim and where panels are sewn together."""

    width: quantity("m", 0.0, 0.1) = 0.008
    """Width of the allowance in each panel."""
    layers: Layers = 2.0
    """Layers of fabric there; 1 means only the panel itself."""


class Reinforcement(Strict):
    """A ring of extra fabric sewn onto a panel, about the bag's axis."""

    panel: Panel = "rear"
    """Panel it is sewn to."""
    inner: quantity("m", 0.0, 5.0) = 0.0
    """Inner radius."""
    outer: quantity("m", 1e-3, 5.0) = 0.10
    """Outer radius."""
    layers: Layers = 2.0
    """Layers of fabric there, including the panel itself."""


class WarpAngle(Strict):
    """Direction of the warp in each panel, from the x axis towards the y axis."""

    front: Angle = 0.0
    """Front panel."""
    rear: Angle = 0.0
    """Rear panel."""


class PanelBag(Strict):
    """Settings common to bags of two sewn panels."""

    element_size: quantity("m", 5e-4, 0.2) = 0.010
    """Approximate edge length of the triangles."""
    mouth_radius: quantity("m", 5e-3, 1.0) = 0.05
    """Radius of the retainer ring; fabric on it and inside is held fixed."""
    initial_gap: quantity("m", 1e-5, 0.2) = 0.002
    """Greatest height of the front panel above the rear panel at the start."""
    coated: tuple[Panel, ...] = ()
    """Panels that let no gas through, whatever fabric.permeability says."""
    seam: Seam = Seam()
    warp_angle: WarpAngle = WarpAngle()
    folds: tuple[Fold, ...] = ()
    tear_seams: tuple[PanelTearSeam, ...] = ()
    covers: tuple[Cover, ...] = ()
    birth_time: quantity("s", 0.0, 0.1) = 0.0
    """Time over which the reference moves from the folded start to the flat cut; for rolls and folds in two
    directions, which stretch the outer layers."""

    _distinct_seams = field_validator("tear_seams")(distinct("tear seams"))
    _distinct_covers = field_validator("covers")(distinct("covers"))

    @field_validator("folds")
    @classmethod
    def _few(cls, value):
        if len(value) > MOST_FOLDS:
            raise refused(f"the bag has {len(value)} folds; at most {MOST_FOLDS} are allowed", "write fewer folds")
        if any(fold.kind == "relax" for fold in value[:-1]) or (value and value[0].kind == "relax"):
            raise refused("relax has to follow all folds", 'write kind = "relax" as the last table, after a fold')
        if any(fold.kind == "tuck" for fold in value[1:]):
            raise refused("a tuck has to come before all other folds", 'write one kind = "tuck", as the first table')
        return value

    @model_validator(mode="after")
    def _one_ramp(self):
        if self.relax is not None and self.birth_time:
            raise refused(
                'the flat cut comes in twice: by a fold of kind "relax" and by birth_time', "remove one of them"
            )
        return self

    @property
    def relax(self) -> Relax | None:
        """How the folded bag comes to rest before it deploys, if it does."""
        return self.folds[-1] if self.folds and self.folds[-1].kind == "relax" else None
