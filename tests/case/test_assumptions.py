"""Typical values that stand for a measurement are named: by check, in the log, in the saved case and in run.json."""

from __future__ import annotations

import pytest

from billow.case.assumptions import HEADING, assumptions, header
from billow.case.schema import Case
from billow.run.check import describe
from billow.run.simulate import simulate

SHORT = {
    "bag": {"diameter": 0.4, "element_size": 0.06, "vents": {"distance": 0.12}, "straps": {"count": 0}},
    "obstacles": [{"shape": "plate"}],
    "run": {"end_time": 5e-5, "frames": 1, "histories_per_frame": 1},
}  # fmt: skip
CURVES = SHORT | {"fabric": {"law": "curves-shear"}}
MEASURED = SHORT | {
    "fabric": {
        "density": 790.0, "thickness": 0.29e-3, "young_warp": 0.41e9, "young_weft": 0.36e9, "poisson": 0.21,
        "shear": 9e6, "permeability": 0.01,
    },
    "inflator": {"gas": {"N2": 1.0}, "mass_flow": {"time": [0, 0.05], "value": [1.0, 0.0]}, "temperature": 600.0},
    "gas": {"heat_transfer": 20.0},
    "obstacles": [{"shape": "plate", "slope": 2e5, "friction": 0.3, "damping": 0.05}],
}  # fmt: skip


def test_curves_that_come_from_the_library_are_named_wherever_a_user_looks(tmp_path):
    """They were taken without a word, and the saved case called them the user's own."""
    case, told = Case.from_dict(CURVES), "fabric.curves: warp, weft, shear from nylon66-470dtex"
    assert told in assumptions(case)
    assert told in describe(case)
    result = simulate(case, tmp_path / "run")
    assert told in (result.folder / "solver.log").read_text()
    assert told in result.record["assumptions"]
    saved = (result.folder / "case.toml").read_text()
    assert saved.startswith(f"# {HEADING}:\n")
    assert f"# {told}\n" in saved
    again = Case.load(result.folder / "case.toml")
    assert again.fabric.library == "nylon66-470dtex"
    assert (again.digest(), assumptions(again)) == (case.digest(), assumptions(case))


def test_what_was_measured_is_not_named():
    case = Case.from_dict(MEASURED | {"bag": SHORT["bag"] | {"vents": {"distance": 0.12, "discharge": 0.65}}})
    assert assumptions(case) == []
    assert header(case) == ""
    assert HEADING not in describe(case)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"fabric.young_warp": 0.4e9}, "fabric: young_warp = 4e+08 Pa"),
        ({"inflator.temperature": 650.0}, "inflator: temperature"),
        ({"bag.vents.discharge": 0.7}, "bag.vents: discharge"),
        ({"gas.heat_transfer": 0.0}, "gas: heat_transfer = 0 W/(m^2 K)"),
        ({"obstacles.plate.slope": 1e5}, "obstacles.plate: slope = 100000 N/m"),
    ],
)
def test_each_default_is_named_alone(changes, line):
    case = Case.from_dict(MEASURED | {"bag": SHORT["bag"] | {"vents": {"distance": 0.12, "discharge": 0.65}}})
    assert assumptions(case.vary(changes)) == [line]


def test_what_a_case_has_no_use_for_is_not_named():
    closed = MEASURED | {"bag": SHORT["bag"] | {"vents": {"count": 0}}, "gas": {"model": "none"}, "inflator": {}}
    assert assumptions(Case.from_dict(closed)) == []
