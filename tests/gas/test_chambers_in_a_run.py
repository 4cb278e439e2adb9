"""A bag of two chambers through the whole program: books, histories, resumption, threads."""

from __future__ import annotations

import numpy as np
import pytest
from run_fingerprint import fingerprint

from billow.case.schema import Case
from billow.parts.gas.supply import passages
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import PRESENT_AREA, VENT, Passage, Passages
from billow.run.interrupts import STOP_FILE, RunInterrupted
from billow.run.simulate import resume, simulate

CASE = {
    "bag": {
        "shape": "rectangular", "length": 0.5, "width": 0.3, "chambers": 2, "element_size": 0.04, "mouth_radius": 0.045,
        "vents": {"chambers": [2], "blockage": True},
    },
    "fabric": {"permeability": 0.0275},
    "gas": {"heat_transfer": 100.0},
    "inflator": [
        {"name": "main", "mass_flow": {"time": [0, 0.003, 0.010], "value": [0, 1.5, 0]}},
        {"name": "late", "mass_flow": {"time": [0, 0.004], "value": [0.5, 0]}, "delay": "3 ms", "chamber": "chamber_2",
         "jets": {"count": 0}},
    ],
    "obstacles": [{"shape": "plate"}],
    "run": {"end_time": 0.008, "frames": 4, "histories_per_frame": 5},
}  # fmt: skip


@pytest.fixture(scope="module")
def straight(tmp_path_factory):
    return simulate(Case.from_dict(CASE), tmp_path_factory.mktemp("chambers") / "straight", threads=1)


def test_the_books_of_the_whole_run_close(straight):
    assert straight.ledger["gas_mass_error"] <= 1e-12
    assert straight.ledger["gas_energy_error"] <= 1e-12
    assert straight.ledger["energy_residual_of_largest"] < 0.02


def test_histories_tell_chambers_and_passages_apart(straight):
    h = straight.histories
    for total, unit in (("volume", "m^3"), ("gas_energy", "J")):
        name = total.removeprefix("gas_")
        parts = sum(h[f"chamber_{k}_{name} [{unit}]"] for k in (1, 2))
        np.testing.assert_allclose(parts, h[f"{total} [{unit}]"], rtol=1e-12)
    assert (
        h["chamber_1_pressure [Pa]"].max() > h["chamber_2_pressure [Pa]"].max()
    )  # the larger inflator is in the first
    leaked = sum(h[f"{panel}_chamber_{k}_leaked [kg]"] for panel in ("front", "rear") for k in (1, 2))
    np.testing.assert_allclose(leaked, h["leaked [kg]"], rtol=1e-12)
    np.testing.assert_allclose(h["vent_1_vented [kg]"], h["vented [kg]"], rtol=1e-12)
    assert h["opening_1_passed [kg]"][-1] != 0.0
    assert h["heat_lost [J]"][-1] > 0.0
    assert h["injected [kg]"][-1] > 0.008


def test_the_same_bits_with_and_without_interruption(straight, tmp_path):
    partial = tmp_path / "run.partial"
    with pytest.raises(RunInterrupted):
        simulate(Case.from_dict(CASE), tmp_path / "run", progress=lambda progress: (partial / STOP_FILE).touch())
    assert fingerprint(resume(tmp_path / "run").folder) == fingerprint(straight.folder)


def test_parallel_kernels_give_the_same_bits():
    rng = np.random.default_rng(3)
    positions = rng.normal(size=(700, 3))
    triangles = rng.integers(0, 700, (5000, 3)).astype(np.uint32)
    touched = rng.random((2, 700)) < 0.3
    table = Passages((Passage("hole", VENT, ORIFICE, 0, triangles=np.arange(5000), area_terms=PRESENT_AREA),))
    found = []
    for how in ("serial", "parallel"):
        areas = np.empty((len(table.chunk_start) - 1, 2))
        getattr(passages._measure, how)(5000, triangles, table.members, table.chunk_start, positions, touched, areas)
        found.append(areas.tobytes())
    assert found[0] == found[1]
