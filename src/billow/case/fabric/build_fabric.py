"""From the `[fabric]` table to a fabric."""

from __future__ import annotations

from functools import partial

import numpy as np

from billow.base.errors import InputError
from billow.case.fabric import schema_fabric
from billow.parts.fabric.curve import Curve, TestedCurve
from billow.parts.fabric.curve_check import check_curves, check_shape
from billow.parts.fabric.curve_fabric import CurveFabric
from billow.parts.fabric.linear_law import LinearFabric, Liner
from billow.parts.fabric.membrane import FabricLaw

WHERE = "fabric.curves"


def build_fabric(fabric: schema_fabric.Cloth, key: str = "fabric") -> FabricLaw:
    """The law named in the `[fabric]` table, or in that of a part, key. A coating adds its mass to that of the fabric.

    Raises InputError: E-FAB-003..006 curves that describe no fabric.
    """
    coating = fabric.coating.density * fabric.coating.thickness / fabric.thickness
    common = fabric.model_dump(include={"thickness", "compression", "damping"})
    try:
        return BUILDERS[fabric.law](fabric, common | {"density": fabric.density + coating})
    except InputError as error:
        error.where = error.where.replace("fabric.", f"{key}.", 1)
        raise


def _linear(fabric: schema_fabric.Cloth, common: dict) -> LinearFabric:
    own = fabric.model_dump(include={"young_warp", "young_weft", "poisson", "shear"})
    return LinearFabric(**own, liner=Liner(**fabric.liner.model_dump()), **common)


def _curves(fabric: schema_fabric.Cloth, common: dict, *, switches_shear: bool) -> CurveFabric:
    curves = fabric.curves
    law = CurveFabric(
        warp=_tested(curves.warp, "warp"),
        weft=_tested(curves.weft, "weft"),
        shear=_tested(curves.shear, "shear"),
        transverse=curves.transverse,
        yarn_angle=0.5 * np.pi if curves.yarn_angle == 90.0 else float(np.radians(curves.yarn_angle)),
        switches_shear=switches_shear,
        **common,
    )
    check_curves(law, WHERE)
    return law


BUILDERS = {
    "linear": _linear,
    "curves": partial(_curves, switches_shear=True),
    "curves-shear": partial(_curves, switches_shear=False),
}
"""Name of a law in a case -> what builds it from the `[fabric]` table and what all laws share."""


def _tested(curves: schema_fabric.YarnCurves | schema_fabric.ShearCurves, name: str) -> TestedCurve:
    loading = _curve(curves.loading, f"{WHERE}.{name}.loading")
    if not curves.unloading.stress:
        return TestedCurve(loading)
    return TestedCurve(loading, _curve(curves.unloading, f"{WHERE}.{name}.unloading"))


def _curve(curve, where: str) -> Curve:
    is_shear = hasattr(curve, "angle")
    strain = tuple(float(np.radians(angle)) for angle in curve.angle) if is_shear else curve.strain
    check_shape(strain, curve.stress, where)
    return Curve(strain, curve.stress)
