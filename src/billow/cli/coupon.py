"""`billow coupon`: the virtual test bench for fabric."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from billow.base.errors import InputError
from billow.base.units import in_unit
from billow.cli.options import make_console, steps, usable

UNKNOWN_CHOICE = InputError.declare(
    "E-CLI-006",
    "there is no {option} {text!r}",
    where="billow coupon",
    why="known are {known}",
    remedy="choose one of them, or see what the options of `billow coupon` mean",
)


def coupon(
    test: Annotated[str, typer.Argument(metavar="TEST", help="biaxial, strip or picture-frame.")],
    out: Annotated[Path, typer.Option(help="Result folder; must not exist yet.")],
    fabric_file: Annotated[
        Path | None,
        typer.Option(
            "--fabric",
            help="Case file (TOML) whose \\[fabric] is tested; without one, the nylon that comes with Billow.",
        ),
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(
            help="linear, curves or curves-shear, repeat it to compare (default: the law of the file, else all)."
        ),
    ] = None,
    data: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[CURVE=]CSV",
            help="Measured test to rate against, loading first: strain (or angle), stress. CURVE: warp, weft, shear.",
        ),
    ] = None,
    peak: Annotated[str | None, typer.Option(help="Largest load: true strain, or angle with unit, '35 deg'.")] = None,
    direction: Annotated[str, typer.Option(help="warp or weft: direction of a strip.")] = "warp",
    element_size: Annotated[str, typer.Option(help="Edge length of the elements.")] = "10 mm",
) -> None:
    """Simulate a fabric test on a mesh, compare fabric laws, and rate them against test data.

    Biaxial: a square stretched equally along warp and weft. Strip: clamped ends, free sides. Picture frame: pure shear.
    Each is loaded and unloaded. Writes stress and strain of each law (CSV), coupon.png and coupon.toml.

    Without --data, the curves in the fabric file serve as test data.
    """
    from billow.apps.coupon import comparison
    from billow.case.schema import Case
    from billow.results.atomic import new_place

    new_place(out)
    _known("test", test, comparison.TESTS)
    _known("direction", direction, ("warp", "weft"))
    given = Case.load(fabric_file).fabric if fabric_file else Case.from_dict({"fabric": {"law": "curves-shear"}}).fabric
    laws = tuple(law) if law else ((given.law,) if fabric_file else comparison.LAWS)
    for name in laws:
        _known("law", name, comparison.LAWS)
    amount = comparison.USUAL_PEAK[test]
    if peak is not None:
        unit, largest, scale = ("deg", 60.0, math.pi / 180.0) if test == "picture-frame" else ("-", 0.5, 1.0)
        amount = _number("peak", peak, unit, 1e-4, largest) * scale
    size = _number("element-size", element_size, "m", 1e-3, 0.05)
    curves = comparison.make_specimen(test, size, direction).curves
    points = _test_data(data, curves) if data else comparison.given_curves(test, given, amount)
    console = make_console()
    with steps(console) as progress:
        measured = comparison.run_laws(
            test, given, laws, amount, size, direction,
            progress=lambda name, share: progress(round(100 * share), 100, name) if share * 10 % 1 == 0.0 else None,
        )  # fmt: skip
    ratings = comparison.write_comparison(out, test, given, measured, points)
    heads = ("peak [MPa]", "match up", "match down", "ripple up", "ripple down")
    console.print(f"{'law':<14}{'curve':<7}" + "".join(f"{head:>13}" for head in heads))
    for name, rated in ratings.items():
        for curve, r in rated.items():
            up, down = (_percent(r.get(k)) for k in ("match_loading", "match_unloading"))
            console.print(
                f"{name:<14}{curve:<7}{1e-6 * r['peak_stress']:>13.3f}{up:>13}{down:>13}"
                f"{100 * r['ripple_loading']:>11.3f} %{100 * r['ripple_unloading']:>11.3f} %"
            )
    for name, tested in measured.items():
        if tested.created > 0.01 * tested.lost:
            console.print(
                f"{name} creates {tested.created:.3g} J in the cycle, which turns {tested.lost:.3g} J to heat"
            )
    console.print(f"{out}: written")


def _percent(share: float | None) -> str:
    return "-" if share is None or math.isnan(share) else f"{100 * share:.1f} %"


def _known(option: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise UNKNOWN_CHOICE(option=option, text=value[:40], known=", ".join(choices))


def _number(option: str, text: str, unit: str, low: float, high: float) -> float:
    with usable("coupon", option, text):
        number = in_unit(text, unit)
        if not low <= number <= high:
            raise ValueError(f"{number:g} {unit} is outside {low:g} to {high:g} {unit}")
    return number


def _test_data(texts: list[str], curves: tuple[str, ...]) -> dict:
    from billow.apps.coupon.comparison import read_test_data

    points = {}
    for text in texts:
        name, equals, path = text.partition("=")
        curve, path = (name, path) if equals else (curves[0], text)
        _known("curve of this test", curve, curves)
        points[curve] = read_test_data(Path(path), curve)
    return points
