"""The `[fabric]` table."""

from __future__ import annotations

from functools import cache
from typing import Any, Literal

from pydantic import Field, model_validator

from billow.case.quantity import Name, Strict, quantity, refused
from billow.parts.fabric.curve_file import LIBRARY, library_curves

Modulus = quantity("Pa", 1e4, 1e12)
Strain = quantity("-", -10.0, 10.0)
Stress = quantity("Pa", -1e12, 1e12)
DIRECTIONS = ("warp", "weft", "shear")
LAWS = {"linear": "moduli", "curves": "curves", "curves-shear": "curves"}
"""Name of a law -> what describes it. `billow.case.fabric.build_fabric.BUILDERS` builds each. A new law is a line here,
with the keys it needs in `Cloth`, and a line there."""


class YarnCurve(Strict):
    """True (logarithmic) strain against true stress. In a case file the path of a CSV file may replace the table."""

    strain: tuple[Strain, ...] = ()
    """True strain, from 0 on."""
    stress: tuple[Stress, ...] = ()
    """True stress."""


class ShearCurve(Strict):
    """Angle against shear stress. In a case file the path of a CSV file may replace the table."""

    angle: tuple[quantity("deg", -180.0, 180.0), ...] = ()
    """Change of the angle between warp and weft, from 0 on."""
    stress: tuple[Stress, ...] = ()
    """Shear stress: in a picture frame of side L under F along its diagonal, F sin(45 deg - angle/2)/(L thickness)."""


class YarnCurves(Strict):
    """Curves of one family of yarns."""

    loading: YarnCurve = YarnCurve()
    unloading: YarnCurve = YarnCurve()


class ShearCurves(Strict):
    """Curves of the angle between warp and weft."""

    loading: ShearCurve = ShearCurve()
    unloading: ShearCurve = ShearCurve()


class FabricCurves(Strict):
    """Tests of the fabric, for the laws "curves" and "curves-shear". Without an unloading curve, unloading is
    elastic."""

    transverse: quantity("-", -1.0, 2.0) = 1.0
    """Transverse over axial true strain in the tests of warp and weft: 1 equal-biaxial, 0 strip held in its width."""
    yarn_angle: quantity("deg", 30.0, 150.0) = 90.0
    """Angle between warp and weft in the flat cut."""
    warp: YarnCurves = YarnCurves()
    weft: YarnCurves = YarnCurves()
    shear: ShearCurves = ShearCurves()


class Liner(Strict):
    """Isotropic layer that also carries compression, for the linear law; 1 to 5 % keep crushed folds apart."""

    ratio: quantity("-", 0.0, 1.0) = 0.0
    """Its thickness relative to the fabric's; 0 for none."""
    young: Modulus = 0.05e9
    """Young's modulus."""
    poisson: quantity("-", 0.0, 0.49) = 0.3
    """Poisson's ratio."""


class Coating(Strict):
    """Coating (silicone): it adds mass and makes the fabric airtight. Its stiffness is negligible; otherwise add a
    liner."""

    thickness: quantity("m", 0.0, 1e-3) = 0.0
    """Thickness; 0 for none."""
    density: quantity("kg/m^3", 100.0, 5000.0) = 1100.0
    """Density."""


class Cloth(Strict):
    """Woven fabric of a part of the bag. Defaults: nylon 6.6, 470 dtex, uncoated."""

    law: Literal[tuple(LAWS)] = "linear"
    """linear: orthotropic, linear in Green strain (FORM 0); curves-shear: loading and unloading curves with history
    (FORM 14); curves: the same, but shear switches curves by the sign of its rate, which oscillates (FORM 4)."""
    density: quantity("kg/m^3", 50.0, 5000.0) = 800.0
    """Mass per volume of the uncoated fabric."""
    thickness: quantity("m", 1e-5, 5e-3) = 0.30e-3
    """Thickness of the fabric without coating."""
    young_warp: Modulus = 0.40e9
    """Young's modulus along the warp (linear)."""
    young_weft: Modulus = 0.35e9
    """Young's modulus along the weft (linear)."""
    poisson: quantity("-", 0.0, 0.49) = 0.2
    """Poisson's ratio: contraction along the weft under load along the warp (linear)."""
    shear: Modulus = 10e6
    """Shear modulus between warp and weft; woven fabric is soft in shear (linear)."""
    compression: bool = False
    """Whether the fabric carries compression; real fabric wrinkles instead."""
    damping: quantity("-", 0.0, 0.5) = 0.05
    """Stiffness-proportional damping, as a fraction of critical in an element's highest mode."""
    permeability: quantity("-", 0.0, 10.0) = 0.0
    """Leak speed in units of 1 m/s at 500 Pa; grows with the root of the pressure difference. 0 for coated fabric."""
    library: Literal["own", "nylon66-470dtex"] = "own"
    """Source of the curves that are not given; without it, and without any curve, nylon66-470dtex, which is typical,
    not measured. The effective case contains the curves themselves, and still says where they come from."""
    curves: FabricCurves = FabricCurves()
    liner: Liner = Liner()
    coating: Coating = Coating()

    @model_validator(mode="before")
    @classmethod
    def _inline(cls, data: Any) -> Any:
        """Fill in the curves of the library, so that the effective case is complete in itself."""
        if not isinstance(data, dict) or not isinstance(data.get("curves", {}), dict):
            return data
        if "law" not in data and (data.get("curves") or data.get("library", "own") != "own"):
            data = {**data, "law": "curves-shear"}
        given = [name for name in DIRECTIONS if _is_given(data.get("curves", {}).get(name))]
        library = data.get("library", "own")
        if LAWS.get(str(data.get("law"))) == "curves" and library == "own" and not given:
            library = next(iter(LIBRARY))
        if not isinstance(library, str) or library not in LIBRARY:
            return data
        if len(given) == len(DIRECTIONS):
            return data  # an effective case, or `_fits` says what is wrong
        if data.get("law") == "linear":
            raise _without_effect(library, "the law is linear")
        filled = {name: table for name, table in library_curves(library).items() if name not in given}
        return {**data, "library": library, "curves": {**data.get("curves", {}), **filled}}

    @model_validator(mode="after")
    def _resists(self):
        largest = (self.young_warp / self.young_weft) ** 0.5
        if self.poisson >= largest:
            raise refused(
                f"with young_warp = {self.young_warp:g} Pa, young_weft = {self.young_weft:g} Pa and "
                f"poisson = {self.poisson:g} a stretched fabric gains energy; poisson must stay below the root of "
                f"young_warp / young_weft, {largest:.3g}",
                "check the units of both moduli, reduce poisson, or exchange young_warp and young_weft",
            )
        return self

    @property
    def from_library(self) -> list[str]:
        """Directions whose curves are those of the library."""
        if self.library == "own":
            return []
        library = _curves_of(self.library)
        return [name for name in DIRECTIONS if getattr(self.curves, name) == getattr(library, name)]

    @model_validator(mode="after")
    def _fits(self):
        from_curves = LAWS[self.law] == "curves"
        missing = [name for name in DIRECTIONS if not _has_points(getattr(self.curves, name))]
        if self.library != "own" and not self.from_library:
            raise _without_effect(self.library, "all three curves are given")
        if self.coating.thickness > 0.0 and self.permeability > 0.0:
            raise refused("coated fabric does not leak", "set permeability = 0, or coating.thickness = 0")
        if from_curves and self.liner.ratio > 0.0:
            raise refused(f'the law "{self.law}" has no liner', 'set liner.ratio = 0, or law = "linear"')
        if from_curves and missing:
            raise refused(
                f"the curve {missing[0]}.loading is missing",
                f'give it, or library = "{next(iter(LIBRARY))}" for what is not given',
            )
        return self


class Fabric(Cloth):
    """Woven fabric. Defaults: nylon 6.6, 470 dtex, uncoated."""

    self_contact: bool | Literal["auto", "layers"] = "auto"
    """Whether layers of fabric are kept apart: true by springs, for bags that start flat; "layers" by impulses, for
    folded stacks, through which nothing passes. auto: "layers" for a bag with folds, springs with the corpuscular gas;
    uniform pressure blows the layers of an unfolded bag apart by itself."""
    friction: quantity("-", 0.0, 2.0) = 0.0
    """Coefficient of friction between layers of fabric, with self_contact = "layers"."""
    parts: dict[Name, Cloth] = Field(default_factory=dict)
    """Fabrics of single parts by name, for example [fabric.parts.front]; each replaces the general fabric completely.
    Straps and seams are of the general one."""

    def of(self, part: str) -> Cloth:
        """The fabric of a part."""
        return self.parts.get(part, self)


@cache
def _curves_of(library: str) -> FabricCurves:
    return FabricCurves(**library_curves(library))


def _without_effect(library: str, reason: str) -> Exception:
    return refused(
        f"library = {library!r} would have no effect: {reason}",
        'write law = "curves-shear", and leave out the curves that the library should give',
    )


def _is_given(curves: Any) -> bool:
    """Whether a user wrote anything of a direction: the library must not take the place of what is half written."""
    branches = curves.values() if isinstance(curves, dict) else [curves]
    return any(any(branch.values()) if isinstance(branch, dict) else bool(branch) for branch in branches)


def _has_points(curves: Any) -> bool:
    """Whether a direction is described, as users write it or as the schema keeps it."""
    loading = curves.get("loading") if isinstance(curves, dict) else getattr(curves, "loading", None)
    if isinstance(loading, YarnCurve | ShearCurve):
        return bool(loading.stress)
    return bool(loading.get("stress")) if isinstance(loading, dict) else bool(loading)
