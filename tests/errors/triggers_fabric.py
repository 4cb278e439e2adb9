"""What is wrong with the curves of a fabric."""

from __future__ import annotations

from collections.abc import Callable

from here import Here

from billow.apps.coupon.comparison import read_test_data
from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.fabric.build_fabric import build_fabric
from billow.case.schema import Case

SOUND = {"loading": {"strain": [0.0, 0.1], "stress": [0.0, 2e7]}}
SHEAR = {"loading": {"angle": [0.0, 40.0], "stress": [0.0, 5e6]}}


def curves(loading=(), unloading=(), shear=SHEAR) -> Callable[[Here], object]:
    """Build a fabric with these (strain, stress) points of the warp."""

    def trigger(here: Here):
        warp = {"loading": dict(zip(("strain", "stress"), loading, strict=False))} if loading else dict(SOUND)
        if unloading:
            warp["unloading"] = dict(zip(("strain", "stress"), unloading, strict=True))
        case = Case.from_dict({"fabric": {"curves": {"warp": warp, "weft": SOUND, "shear": shear}}})
        return build_fabric(case.fabric)

    return trigger


def file(name: str, text: str | None) -> Callable[[Here], object]:
    """Load a case that takes the warp's loading curve from a file of this text."""

    def trigger(here: Here):
        if text is not None:
            here.write(name, text)
        lines = f'[fabric]\nlibrary = "nylon66-470dtex"\n[fabric.curves.warp]\nloading = "{name}"\n'
        return Case.load(here.write("case.toml", lines))

    return trigger


def warns(code: str, *warp) -> Callable[[Here], object]:
    """Look at a bag whose warp has these (strain, stress) points."""

    def trigger(here: Here):
        table = {"warp": {"loading": dict(zip(("strain", "stress"), warp, strict=True))}, "weft": SOUND, "shear": SHEAR}
        case = Case.from_dict({"bag": {"element_size": 0.05}, "fabric": {"curves": table}})
        return next(concern for concern in concerns_of(case, build_model(case)) if concern.code == code)

    return trigger


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-FAB-150": lambda here: build_model(Case.from_dict({"fabric": {"parts": {"frnt": {}}}})),
    "E-FAB-001": file("none.csv", None),
    "E-FAB-002": file("warp.csv", "strain [%], stress [mm]\n0, 0\n10, 20\n"),
    "E-FAB-003": curves(([0.01, 0.1], [0.0, 2e7])),
    "E-FAB-004": curves(([0.0, 0.1, 0.2], [0.0, 2e7, 1e7])),
    "E-FAB-005": curves(([0.0, 0.1], [0.0, 2e7]), ([0.0, 0.05, 0.1], [0.0, 1.5e7, 2e7])),
    "E-FAB-006": curves(([0.0, 0.02, 0.1], [0.0, 2e6, 3e7]), ([0.0, 0.05, 0.1], [0.0, 1e7, 3e7])),
    "E-FAB-020": lambda here: read_test_data(here.write("test.csv", "strain, stress\n0, 0\n"), "warp"),
    "W-FAB-004": warns("W-FAB-004", [0.0, 0.099, 0.1], [0.0, 4e7, 8e7]),
    "W-FAB-005": warns("W-FAB-005", [0.0, 0.1], [0.0, 2e6]),
}
