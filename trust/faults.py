"""Seeded faults: mistakes a user, a disk or the solver itself may make, and whether Billow names the cause.

Each fault goes the way a user goes: the case file is read, checked, run. What was found is the error it ended with, or
the warnings and the verdict in the record of the run. A fault is *named* if one of the expected codes is among them and
its message says the expected words; it is *silent* if nothing was found at all.
"""

from __future__ import annotations

import contextlib
import copy
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from billow.base.errors import BillowError, NumericalStop
from billow.case.schema import Case
from billow.results.result import Result
from billow.run.check import describe
from billow.run.simulate import simulate
from trust import injections as inject

SOUND: dict[str, Any] = {
    "title": "A sound case",
    "bag": {"element_size": 0.05, "vents": {}, "straps": {}},
    "fabric": {},
    "inflator": {"mass_flow": {"time": [0.0, 0.002, 0.008], "value": [0.0, 12.5, 0.0]}, "jets": {}},
    "ambient": {},
    "obstacles": [{"shape": "plate"}, {"shape": "super-ellipsoid", "locked": False}],
    "run": {"end_time": 0.010, "frames": 2, "histories_per_frame": 5},
}
"""50 g of gas within 8 ms; passes without a warning."""


@dataclass(frozen=True)
class Fault:
    """name; codes, one of which must be found; words that its message must hold; and one way to inject it:

    changes: keys of the case with their wrong values. text: the file's text changed. spoil: something in the solver
    changed while the case is checked and run. left: what the user finds on disk and does with it.
    """

    name: str
    codes: str
    words: tuple[str, ...]
    changes: dict[str, Any] | None = None
    text: Callable[[str], str | bytes | None] | None = None
    spoil: Callable[[], contextlib.AbstractContextManager] | None = None
    left: Callable[[Path, Case], object] | None = None


@dataclass(frozen=True)
class Finding:
    """A code, or "quality" for a line of the verdict, and everything said about it."""

    code: str
    message: str


@dataclass(frozen=True)
class FaultResult:
    """expected: codes; found: codes; named: the cause was told; silent: nothing was; seconds: wall time."""

    name: str
    expected: str
    found: str
    named: bool
    silent: bool
    seconds: float


def cut(text: str) -> str:
    return text[: len(text) // 2].rstrip("]\n") + " = ["


FAULTS = [
    # --- units -------------------------------------------------------------------------------------------------------
    Fault("curve in ms", "E-CASE-005", ("mass_flow.time", "50 ms"), {"inflator.mass_flow.time": [0, 8, 50]}),
    Fault("short curve in ms", "W-GAS-001", ("mass_flow", "milliseconds"), {"inflator.mass_flow.time": [0, 2, 8]}),
    Fault("curve in us", "W-GAS-002", ("mass_flow", "unit"), {"inflator.mass_flow.time": [0, 2e-6, 8e-6]}),
    Fault("mass flow in g/s", "E-CASE-005", ("mass_flow", "g/s"), {"inflator.mass_flow.value": [0, 12500, 0]}),
    Fault("mass flow in kg/ms", "W-GAS-003", ("mass_flow", "unit"), {"inflator.mass_flow.value": [0, 0.0125, 0]}),
    Fault("modulus in MPa", "E-CASE-005", ("young_warp", "400 mpa"), {"fabric.young_warp": 400.0}),
    Fault("moduli in kPa", "W-FAB-001", ("young_warp", "unit"), {"fabric.young_warp": 4e5, "fabric.young_weft": 3.5e5}),
    Fault("one modulus in kPa", "E-CASE-005", ("young_warp", "unit"), {"fabric.young_warp": 4e5}),
    Fault("thickness in mm", "E-CASE-005", ("thickness", "0.3 mm"), {"fabric.thickness": 0.3}),
    Fault("density in g/cm^3", "E-CASE-005", ("density", "0.8 g/cm^3"), {"fabric.density": 0.8}),
    Fault("bag in mm", "E-CASE-005", ("diameter", "700 mm"), {"bag.diameter": 700.0}),
    Fault("ambient pressure as gauge", "E-CASE-005", ("ambient.pressure", "absolute"), {"ambient.pressure": 0.0}),
    Fault("ambient pressure in bar", "E-CASE-005", ("ambient.pressure", "1.013 bar"), {"ambient.pressure": 1.013}),
    Fault("temperature in Celsius", "E-CASE-005", ("ambient.temperature", "celsius"), {"ambient.temperature": 22.0}),
    Fault("gas in Celsius", "E-CASE-005", ("inflator.temperature", "celsius"), {"inflator.temperature": 120.0}),
    Fault("opening pressure in bar", "W-GAS-005", ("opening_pressure", "unit"), {"bag.vents.opening_pressure": 0.3}),
    Fault("impactor mass in g", "E-CASE-005", ("mass", "4500 g"), {"obstacles.1.mass": 4500.0}),
    Fault("impactor mass in t", "W-OBS-002", ("mass", "unit"), {"obstacles.1.mass": 0.0045}),
    Fault("slope in N/mm", "W-OBS-003", ("slope", "n/mm"), {"obstacles.1.slope": 100.0}),
    Fault("end time in ms", "E-CASE-005", ("end_time", "50 ms"), {"run.end_time": 50}),
    Fault("wrong kind of unit", "E-CASE-005", ("thickness", "kg", "mm"), {"fabric.thickness": "0.3 kg"}),
    # --- the file ----------------------------------------------------------------------------------------------------
    Fault("unknown key", "E-CASE-003", ("diametre", "did you mean 'diameter'"), {"bag.diametre": 0.7}),
    Fault(
        "misspelt shape", "E-CASE-005", ("obstacles.1", "'super-ellipsoid'"), {"obstacles.1.shape": "superellipsoid"}
    ),
    Fault("missing file", "E-CASE-001", ("no such file",), text=lambda text: None),
    Fault("not TOML", "E-CASE-002", ("line",), text=lambda text: text.replace("=", ":", 1)),
    Fault("file cut short", "E-CASE-002", ("toml",), text=cut),
    Fault("binary file", "E-CASE-002", ("not a text file",), text=lambda text: b"\x89HDF\r\n\x1a\n" + text.encode()),
    # --- curves and gas ----------------------------------------------------------------------------------------------
    Fault("empty curve", "E-CASE-005", ("mass_flow", "two points"), {"inflator.mass_flow": {"time": [], "value": []}}),
    Fault("curve of one point", "E-CASE-005", ("two points",), {"inflator.mass_flow": {"time": [0], "value": [1]}}),
    Fault("times go back", "E-CASE-005", ("mass_flow", "increase"), {"inflator.mass_flow.time": [0, 0.008, 0.002]}),
    Fault("curve without values", "E-CASE-005", ("equally many",), {"inflator.mass_flow.value": [0.0, 1.0]}),
    Fault("zero mass flow", "E-CASE-005", ("mass flow is zero",), {"inflator.mass_flow.value": [0.0, 0.0, 0.0]}),
    Fault("curve ends after the run", "W-GAS-001", ("mass_flow", "run.end_time"), {"run.end_time": 0.002}),
    Fault("fractions not 1", "E-CASE-005", ("inflator.gas", "sum to 0.9"), {"inflator.gas": {"N2": 0.5, "Ar": 0.4}}),
    Fault("unknown gas", "E-GAS-001", ("xenon", "inflator.gas"), {"inflator.gas": {"xenon": 1.0}}),
    Fault("fabric lets all out", "W-GAS-004", ("fabric.permeability",), {"fabric.permeability": 10.0}),
    Fault(
        "vents let all out",
        "W-GAS-004",
        ("bag.vents",),
        {"bag.vents": {"count": 3, "diameter": 0.2, "distance": 0.2}, "inflator.mass_flow.value": [0, 6, 0]},
    ),
    # --- geometry ----------------------------------------------------------------------------------------------------
    Fault("negative thickness", "E-CASE-005", ("thickness", "range"), {"fabric.thickness": -3e-4}),
    Fault(
        "vent larger than panel", "E-GEO-010", ("bag.vents", "fit"), {"bag.vents": {"diameter": 0.2, "distance": 0.3}}
    ),
    Fault("overlapping vents", "E-GEO-010", ("vents", "overlap"), {"bag.vents": {"count": 8, "diameter": 0.15}}),
    Fault("strap stitched outside", "E-GEO-010", ("stitch_radius", "outside"), {"bag.straps.stitch_radius": 0.5}),
    Fault("strap too short", "W-MESH-003", ("straps.length",), {"bag.straps.length": 0.02}),
    Fault("start shape too high", "W-MESH-002", ("initial_gap",), {"bag.initial_gap": 0.12}),
    Fault("elements too large", "W-MESH-001", ("element_size",), {"bag.element_size": 0.12, "bag.vents.count": 0}),
    Fault("elements too small", "E-GEO-011", ("element_size", "unit"), {"bag.element_size": 5e-4}),
    Fault("plate above the bag", "E-GEO-020", ("plate", "penetrates"), {"obstacles.0.height": 0.01}),
    Fault("obstacle in the bag", "E-GEO-020", ("impactor", "penetrates"), {"obstacles.1.clearance": 0.0}),
    Fault("obstacle swallowed", "E-GEO-021", ("inside",), {"bag.initial_gap": 0.2, "obstacles.1": inject.PEBBLE}),
    Fault("obstacle too far", "W-OBS-001", ("clearance", "not reach"), {"obstacles.1.clearance": 0.9}),
    Fault("obstacle far too soft", "W-OBS-003", ("slope", "softer"), {"obstacles.1.slope": 1.0}),
    Fault("reversed normals", "E-GEO-003", ("normals", "inwards"), spoil=inject.reversed_normals),
    Fault("one flipped triangle", "E-GEO-002", ("orient",), spoil=inject.flipped_triangle),
    Fault("open seam", "E-GEO-001", ("not closed", "seam", "node"), spoil=inject.open_seam),
    Fault("hole in the bag", "E-GEO-001", ("not closed", "3 free edges"), spoil=inject.hole),
    Fault("degenerate reference", "E-GEO-004", ("reference", "triangle 100"), spoil=inject.degenerate_reference),
    Fault("mirrored reference", "W-MESH-002", ("stretched", "triangle"), spoil=inject.mirrored_reference),
    Fault("one node in mm", "W-MESH-002", ("stretched", "triangle"), spoil=inject.stray_node),
    # --- the run -----------------------------------------------------------------------------------------------------
    Fault("step four times too large", "E-NUM-003 E-NUM-001", ("step", "too large"), spoil=inject.large_step),
    Fault("NaN in a position", "E-NUM-001", ("node 123", "not a finite"), spoil=inject.nan_position),
    Fault("NaN in the gas", "E-NUM-001", ("gas", "not a finite"), spoil=inject.nan_gas),
    Fault("gas too hot", "E-NUM-002", ("gas", "inflator.temperature"), spoil=inject.hot_gas),
    Fault("energy from nowhere", "E-NUM-003", ("energy", "node 100"), spoil=inject.kicked_node),
    Fault("moduli in bar", "W-FAB-001", ("young_warp", "unit"), {"fabric.young_warp": 4e6, "fabric.young_weft": 3.5e6}),
    Fault("four times the gas", "W-GAS-003 E-NUM-005", ("mass_flow",), {"inflator.mass_flow.value": [0, 99, 0]}),
    Fault("disk full", "E-RES-020", ("no space",), spoil=inject.full_disk),
    # --- what lies on disk -------------------------------------------------------------------------------------------
    Fault("result folder in use", "E-RES-009", ("exists already",), left=inject.run_twice),
    Fault("interrupted run run again", "E-RES-022", ("resume", "checkpoint"), left=inject.run_over_interrupted),
    Fault("damaged case.toml", "E-RES-033", ("case.toml",), left=inject.resume_damaged_case),
    Fault("changed case.toml", "E-RES-031", ("another case",), left=inject.resume_changed_case),
    Fault("truncated checkpoint", "E-RES-031", ("checkpoint_a", "bytes"), left=inject.resume_cut_checkpoint),
    Fault("no checkpoint", "E-RES-032", ("checkpoint",), left=inject.resume_without_checkpoint),
    Fault("truncated journal", "E-RES-030", ("journal", "byte"), left=inject.resume_cut_journal),
    Fault("result file changed by hand", "E-RES-004", ("histories.csv", "sha-256"), left=inject.open_changed_run),
    Fault("result file missing", "E-RES-005", ("fabric.vtkhdf", "missing"), left=inject.open_incomplete_run),
]


def run_faults(names: set[str] | None = None) -> list[FaultResult]:
    """Inject every fault, or those named, one after the other."""
    return [_run(fault) for fault in FAULTS if names is None or fault.name in names]


def findings(fault: Fault) -> list[Finding]:
    """Everything Billow says about a fault."""
    with tempfile.TemporaryDirectory(prefix="billow-fault-") as place:
        found = []
        try:
            for finding in _find(fault, Path(place)):
                found.append(finding)
        except BillowError as error:
            found.append(Finding(error.code, str(error)))
        return found


def _find(fault: Fault, place: Path) -> Iterator[Finding]:
    text: str | bytes | None = tomli_w.dumps(changed(SOUND, fault.changes or {}))
    if fault.text is not None:
        text = fault.text(text)
    path = place / "case.toml"
    if text is not None:
        path.write_bytes(text.encode() if isinstance(text, str) else text)
    case = Case.load(path)
    if fault.left is not None:
        fault.left(place, case)
        return
    with fault.spoil() if fault.spoil else contextlib.nullcontext():
        describe(case)
        try:
            record = simulate(case, place / "run", threads=1).record
        except NumericalStop as stop:
            yield Finding(stop.code, str(stop))
            record = Result.open(place / "run").record  # a stopped run is published too
    for warning in record["warnings"]:
        yield Finding(warning["code"], " ".join(map(str, warning.values())))
    for line in record["quality"]["criteria"]:
        if line["verdict"] != "PASS":
            yield Finding("quality", f"{line['verdict']}: {line['name']} = {line['measured']} {line['unit']}")


def _run(fault: Fault) -> FaultResult:
    begun = time.perf_counter()
    found = findings(fault)
    named = any(
        finding.code in fault.codes.split() and all(word in finding.message.lower() for word in fault.words)
        for finding in found
    )
    codes = " ".join(dict.fromkeys(finding.code for finding in found))
    return FaultResult(fault.name, fault.codes, codes, named, not found, time.perf_counter() - begun)


def changed(data: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A copy of nested dictionaries with dotted keys replaced; obstacles are counted from 0."""
    data = copy.deepcopy(data)
    for key, value in changes.items():
        *path, last = (int(part) if part.isdigit() else part for part in key.split("."))
        place: Any = data
        for part in path:
            place = place[part]
        place[last] = value
    return data
