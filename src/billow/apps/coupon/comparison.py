"""A comparison on the bench: a fabric file, a test, one or more laws; curves, ratings and a picture in a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import tomli_w
from matplotlib.figure import Figure

from billow.apps.coupon.bench import Measured, run_test
from billow.apps.coupon.rating import match, ripple
from billow.apps.coupon.specimen import Biaxial, PictureFrame, Specimen, Strip
from billow.base.errors import InputError
from billow.base.plot_style import png, styled
from billow.case.fabric import schema_fabric
from billow.case.fabric.build_fabric import build_fabric
from billow.case.schema import Case
from billow.parts.fabric.curve import Curve
from billow.parts.fabric.curve_file import read_curve_file
from billow.results.atomic import new_folder, write_atomically
from billow.results.histories import write_histories

NO_TEST_DATA = InputError.declare(
    "E-FAB-020",
    "{name} holds no test to compare with",
    where="{path}",
    why="it needs two points or more, finite numbers, and a stress that is not zero throughout",
    remedy="give strain (or angle) and stress, loading first, then unloading, one point a line",
)

TESTS = ("biaxial", "strip", "picture-frame")
LAWS = tuple(schema_fabric.LAWS)
USUAL_PEAK = {"biaxial": 0.10, "strip": 0.10, "picture-frame": float(np.radians(35.0))}
"""How far each test goes by default: true strain [-], shear angle [rad]."""
ENERGIES = ("work", "stored", "lost", "created", "kinetic_share")
COLOURS = {"linear": "#b0722a", "curves": "#2a6fb0", "curves-shear": "#2a9050"}

Points = tuple[np.ndarray, np.ndarray]
"""Strain [-] or angle [rad], and stress [Pa], of a measured test, loading first."""


def make_specimen(test: str, element_size: float, direction: str = "warp") -> Specimen:
    """The usual specimen of a test: 100 mm square, 200 x 50 mm strip, 200 mm frame."""
    if test == "biaxial":
        return Biaxial(0.1, element_size)
    if test == "strip":
        return Strip(0.2, 0.05, element_size, direction)
    return PictureFrame(0.2, element_size)


def with_law(fabric: schema_fabric.Fabric, law: str) -> schema_fabric.Fabric:
    """The same fabric under another law. Raises InputError if it lacks what that law needs."""
    written = fabric.model_dump()
    if schema_fabric.LAWS[law] == "curves" and fabric.liner.ratio > 0.0:
        written["liner"] = {"ratio": 0.0}
    return Case.from_dict({"fabric": written | {"law": law}}, "the fabric").fabric


def read_test_data(path: Path, curve: str) -> Points:
    """Measured strain and stress. Raises InputError E-FAB-001, -002 (see billow.parts.fabric.curve_file), E-FAB-020."""
    x = "angle" if curve == "shear" else "strain"
    columns = read_curve_file(path, x)
    strain, stress = np.array(columns[x]), np.array(columns["stress"])
    if len(strain) < 2 or not (np.isfinite(strain).all() and np.isfinite(stress).all()) or not stress.any():
        raise NO_TEST_DATA(name=path.name, path=path)
    return (np.radians(strain) if curve == "shear" else strain), stress


def given_curves(test: str, fabric: schema_fabric.Fabric, peak: float) -> dict[str, Points]:
    """The curves the fabric was described by, as far as this test measures the same: loading to the peak, and
    unloading if that begins there. Empty where it does not."""
    measured = {"biaxial": ("warp", "weft"), "picture-frame": ("shear",), "strip": ()}[test]
    if not fabric.curves.warp.loading.stress or (test == "biaxial" and fabric.curves.transverse != 1.0):
        return {}
    points = {}
    for name in measured:
        curves = getattr(fabric.curves, name)
        loading = _curve(curves.loading)
        if loading is None:
            continue  # the law says what it misses
        unloading = _curve(curves.unloading) or loading
        up = np.linspace(0.0, peak, 41)
        points[name] = up, loading.at(up)
        if abs(unloading.end - peak) < 0.01 * peak:
            points[name] = np.concatenate([up, up[::-1]]), np.concatenate([loading.at(up), unloading.at(up[::-1])])
    return points


def _curve(written: schema_fabric.YarnCurve | schema_fabric.ShearCurve) -> Curve | None:
    """None for a curve of less than two points, or whose points do not rise: what the law refuses."""
    sheared = isinstance(written, schema_fabric.ShearCurve)
    x = np.radians(written.angle) if sheared else np.array(written.strain)
    if len(x) < 2 or len(x) != len(written.stress) or np.diff(x).min() <= 0.0:
        return None
    return Curve(tuple(x.tolist()), written.stress)


def run_laws(
    test: str,
    fabric: schema_fabric.Fabric,
    laws: Sequence[str],
    peak: float,
    element_size: float,
    direction: str = "warp",
    progress: Callable[[str, float], None] | None = None,
) -> dict[str, Measured]:
    """Law -> what the test gives. progress: called with law and share done. Raises InputError, NumericalStop."""
    specimen = make_specimen(test, element_size, direction)
    found = {}
    for law in laws:
        tell = (lambda share, law=law: progress(law, share)) if progress else None
        found[law] = run_test(specimen, build_fabric(with_law(fabric, law)), peak, progress=tell)
    return found


def rate(measured: Measured, data: Mapping[str, Points]) -> dict[str, dict[str, float]]:
    """Curve -> peak stress [Pa], ripple of loading and unloading, and, where there is data, match of both [-]."""
    ratings = {}
    for k, curve in enumerate(measured.curves):
        strain, stress = measured.strain[:, k], measured.stress[:, k]
        ratings[curve] = rating = {"peak_stress": float(stress.max())}
        rating["ripple_loading"], rating["ripple_unloading"] = ripple(strain, stress)
        if curve in data:
            rating["match_loading"], rating["match_unloading"] = match(strain, stress, *data[curve])
    return ratings


def write_comparison(
    folder: Path, test: str, fabric: schema_fabric.Fabric, measured: Mapping[str, Measured], data: Mapping[str, Points]
) -> dict[str, dict[str, dict[str, float]]]:
    """Write LAW.csv of each law, coupon.png and coupon.toml; returns law -> curve -> ratings.

    Raises InputError E-RES-009 if the folder exists and is not empty.
    """
    with new_folder(folder) as partial:
        return _write(partial, test, fabric, measured, data)


def _write(folder: Path, test: str, fabric: schema_fabric.Fabric, measured: Mapping[str, Measured], data) -> dict:
    ratings = {}
    for law, test_run in measured.items():
        columns = {"time [s]": test_run.time, "machine_force [N]": test_run.machine_force}
        for k, curve in enumerate(test_run.curves):
            name = "angle [rad]" if curve == "shear" else "strain [-]"
            columns |= {f"{curve}_{name}": test_run.strain[:, k], f"{curve}_stress [Pa]": test_run.stress[:, k]}
        write_histories(folder / f"{law}.csv", columns)
        ratings[law] = rate(test_run, data)
    summary = {
        "test": test,
        "laws": ratings,
        "energy": {law: {key: getattr(m, key) for key in ENERGIES} for law, m in measured.items()},
        "fabric": fabric.model_dump(mode="python"),
    }
    write_atomically(folder / "coupon.toml", tomli_w.dumps(summary))
    write_atomically(folder / "coupon.png", stress_strain(test, measured, data))
    return ratings


def stress_strain(title: str, measured: Mapping[str, Measured], data: Mapping[str, Points]) -> bytes:
    """Stress against strain of every law and of the test data, a panel a curve, as PNG. measured: law -> test."""
    curves = next(iter(measured.values())).curves
    with styled():
        figure = Figure(figsize=(5.6 * len(curves), 4.2), layout="constrained")
        for k, (axes, curve) in enumerate(zip(np.atleast_1d(figure.subplots(1, len(curves))), curves, strict=True)):
            scale = 180.0 / np.pi if curve == "shear" else 100.0
            if curve in data:
                strain, stress = data[curve]
                axes.plot(scale * strain, 1e-6 * stress, "ko", markersize=3.5, label="test data")
            for law, test in measured.items():
                colour = COLOURS.get(law, "#666666")
                axes.plot(scale * test.strain[:, k], 1e-6 * test.stress[:, k], color=colour, linewidth=1.3, label=law)
            axes.set_xlabel("shear angle [deg]" if curve == "shear" else "true strain [%]")
            axes.set_ylabel("shear stress [MPa]" if curve == "shear" else "true stress [MPa]")
            axes.set_title(f"{title}: {curve}")
            axes.grid(alpha=0.3)
            axes.legend(frameon=False)
        return png(figure, 130)
