"""What is wrong with a case or a command."""

from __future__ import annotations

import contextlib
import io
import re
import sys
from collections.abc import Callable

from here import Here, Told, dotted

from billow.case.build import build_model
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.cli import main as cli
from billow.run.check import describe
from trust import injections as inject
from trust.faults import SOUND, changed


def case(**changes) -> Callable[[Here], object]:
    """Check a case with these keys (`__` for a dot) changed."""
    return lambda here: describe(Case.from_dict(changed(SOUND, dotted(changes))))


def warns(code: str, **changes) -> Callable[[Here], object]:
    def trigger(here: Here):
        odd = Case.from_dict(changed(SOUND, dotted(changes)))
        assert f"{code} warning: " in describe(odd)
        return next(warning for warning in concerns_of(odd, build_model(odd)) if warning.code == code)

    return trigger


def command(*arguments: str) -> Told:
    """What `billow ARGUMENTS` prints when it fails."""
    before, printed = sys.argv, io.StringIO()
    sys.argv = ["billow", *arguments]
    try:
        with contextlib.redirect_stderr(printed), contextlib.suppress(SystemExit):
            cli.main()
    finally:
        sys.argv = before
    said = re.fullmatch(r"(\S+) error: (.*)\n  where: (.*)\n  why:   (.*)\n  try:   (.*)\n", printed.getvalue())
    assert said, printed.getvalue()
    return Told(*said.groups())


def demo_over_another(here: Here) -> Told:
    here.write("case.toml", "title = 'mine'\n")
    return command("demo", "--out", str(here.place))


def prediction_over_a_file(here: Here) -> Told:
    taken = here.write("taken.vtkhdf", "mine")
    settings = ["--set", "permeability=0.03", "--set", "temperature=600"]
    return command("predict", str(here.bench.surrogate), *settings, "--out", str(taken))


THROWN = {"name": "thrown", "velocity": [0.0, 0.0, 1.0]}
CARRIED = {"name": "module", "parts": ["mouth"], "motion": {"kind": "speed", "speed": 1.0}}

RAIL = {"name": "rail", "parts": ["front"], "motion": {"kind": "fixed", "directions": ["x"]}}


def bug_in_a_command(here: Here) -> Told:
    here.patch.setattr("billow.run.check.describe", lambda case: 1 / 0)
    here.patch.setattr("tempfile.tempdir", str(here.place))
    told = command("check", str(here.bench.place / "case.toml"))
    assert "ZeroDivisionError" in next(here.place.glob("billow-report-*")).read_text()
    return told


def no_memory_for_a_command(here: Here) -> Told:
    def describe(case):
        raise MemoryError

    here.patch.setattr("billow.run.check.describe", describe)
    return command("check", str(here.bench.place / "case.toml"))


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-CASE-001": lambda here: Case.load(here.place / "none.toml"),
    "E-CASE-002": lambda here: Case.load(here.write("case.toml", "title =")),
    "E-CASE-003": case(bag__diametre=0.7),
    "E-CASE-004": case(inflator__mass_flow={"time": [0.0, 0.05]}),
    "E-CASE-005": case(fabric__thickness=0.3),
    "E-CASE-007": case(obstacles__1__name="vent_1"),
    "E-CASE-213": case(nodes=[{"name": "rim", "between": ["front", "back"], "velocity": [0, 0, 1]}]),
    "E-CASE-214": case(nodes=[THROWN, {**THROWN, "name": "again", "parts": ["rear"]}]),
    "E-CASE-215": case(nodes=[CARRIED]),
    "E-CASE-216": case(nodes=[RAIL], fabric__self_contact="layers"),
    "E-CASE-006": lambda here: Case.from_dict(SOUND).vary({"obstacles.sphere.degree": 3.0}),
    "E-CLI-001": lambda here: command("check", str(here.bench.place / "case.toml"), "--set", "permeability"),
    "E-CLI-002": demo_over_another,
    "E-CLI-003": lambda here: command("check"),
    "E-CLI-004": prediction_over_a_file,
    "E-CLI-006": lambda here: command("coupon", "bending", "--out", str(here.place / "out")),
    "E-CLI-007": lambda here: command("coupon", "strip", "--peak", "5 mm", "--out", str(here.place / "out")),
    "E-CLI-005": lambda here: command("demo", "--out", str(here.write("file", "") / "below")),
    "E-CLI-008": lambda here: command("paper", "--out", str(here.place / "out")),
    "E-CLI-009": no_memory_for_a_command,
    "E-CLI-030": lambda here: command("verify", "X9"),
    "E-CLI-070": bug_in_a_command,
    "E-GEO-010": case(bag__straps__stitch_radius=0.5),
    "E-GEO-011": case(bag__element_size=5e-4),
    "E-GEO-020": case(obstacles__0__height=0.01),
    "E-GEO-022": case(obstacles__0={"shape": "plate", "height": 0.4, "normal": [0, 0, -1]}),
    "E-GEO-021": case(bag__initial_gap=0.2, obstacles__1=inject.PEBBLE),
    "W-FAB-001": warns("W-FAB-001", fabric__young_warp=4e5, fabric__young_weft=4e5),
    "W-FAB-002": warns("W-FAB-002", fabric__thickness=3e-5),
    "W-FAB-003": warns("W-FAB-003", fabric__shear=1e10),
    "W-GAS-001": warns("W-GAS-001", run__end_time=0.002),
    "W-GAS-002": warns("W-GAS-002", inflator__mass_flow__time=[0, 2e-5, 8e-5]),
    "W-GAS-003": warns("W-GAS-003", inflator__mass_flow__value=[0, 0.0125, 0]),
    "W-GAS-007": warns("W-GAS-007", gas={"initial": {"pressure": 2e4}}),
    "W-GAS-004": warns("W-GAS-004", fabric__permeability=10.0),
    "W-GAS-005": warns("W-GAS-005", bag__vents__opening_pressure=0.3),
    "W-GAS-021": warns("W-GAS-021", gas={"model": "mesh", "cell": 0.1}),
    "W-GAS-022": warns("W-GAS-022", gas={"model": "mesh", "cell": 0.002}),
    "W-GAS-006": warns("W-GAS-006", inflator__jets__ring_radius=0.1),
    "W-MESH-001": warns("W-MESH-001", bag__element_size=0.12, bag__vents__count=0),
    "W-MESH-002": warns("W-MESH-002", bag__initial_gap=0.12),
    "W-MESH-003": warns("W-MESH-003", bag__straps__length=0.02),
    "W-OBS-001": warns("W-OBS-001", obstacles__1__clearance=0.9),
    "W-OBS-002": warns("W-OBS-002", obstacles__1__mass=0.0045),
    "W-OBS-217": warns("W-OBS-217", nodes=[RAIL]),
    "W-OBS-003": warns("W-OBS-003", obstacles__1__slope=100.0),
}
