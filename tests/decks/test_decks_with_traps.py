"""Decks of the kinds that real ones are: imported, run to their own end, and judged; a verdict below PASS names what of
the deck is at fault."""

from __future__ import annotations

import numpy as np
import pytest
from test_decks_of_others import CLOTH, GAS, Pillow

from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck
from billow.run.simulate import simulate

ROWS = 10
FULL = GAS.replace("10,1e-3\n40,0\n", "4,3e-3\n10,0\n").replace("0,,0\n0,,1", "0.7,,400\n0,,1")
"""15 g in 10 ms and an exit of 4 cm^2: the pressure has its peak before the end of 20 ms."""


def glued(pillow: Pillow) -> str:
    """Columns that touch: 17.86000E-7 is part 1 of 7.86e-7."""
    card = "         17.86000E-7       0.4      0.35                 0.2\n"
    return pillow.deck(gas=FULL, cloth=CLOTH.replace("1,8e-7,0.4,0.35,,0.2\n", card))


def random_normals(pillow: Pillow) -> str:
    for k in np.random.default_rng(3).choice(len(pillow.cells), 30, replace=False):
        pillow.cells[k] = pillow.cells[k][::-1]
    return pillow.deck(gas=FULL)


def open_around_the_nozzle(pillow: Pillow) -> str:
    """Four shells short, around which a rigid part lies."""
    gone = {j * ROWS + i for j in (4, 5) for i in (4, 5)}
    rim = [n + 1 for n in sorted({n for k in gone for n in pillow.cells[k]})]
    first = max(rim) + 900
    pillow.cells = [c for k, c in enumerate(pillow.cells) if k not in gone]
    pillow.parts = [p for k, p in enumerate(pillow.parts) if k not in gone]
    at = {n: pillow.points[n - 1] for n in rim}
    nozzle = f"{first},300,300,-180\n"
    centre = np.array([300.0, 300.0])
    ring = sorted((n for n in rim if np.abs(at[n][:2] - centre).max() > 1.0),
                  key=lambda n: np.arctan2(*(at[n][:2] - centre)))  # fmt: skip
    shells = "".join(f"{800 + k},9,{a},{b},{first},{first}\n" for k, (a, b) in enumerate(
        zip(ring, ring[1:] + ring[:1], strict=True)))  # fmt: skip
    rigid = "*PART\nnozzle\n9,9,9\n*SECTION_SHELL\n9,2\n1,1,1,1\n*MAT_RIGID\n9,7.8e-6,210\n1,7,7\n0\n"
    return pillow.deck(gas=FULL, more=f"*NODE\n{nozzle}*ELEMENT_SHELL\n{shells}{rigid}")


def a_gas_that_is_none(pillow: Pillow) -> str:
    """Heats in other units than the model: cp - cv is no gas constant."""
    begin, end = FULL.index("*AIRBAG_HYBRID"), FULL.index("*CONTROL")
    model = "*AIRBAG_SIMPLE_AIRBAG_MODEL\n1,1\n17.36,24.30,600,1,0.7,400,1.01e-4,1.2e-9\n"
    curve = FULL[:begin].replace("3e-3", "0.15")  # the same flow of enthalpy
    return pillow.deck(gas=curve + model + FULL[end:])


def upright(pillow: Pillow) -> str:
    """y points up, towards a wall."""
    pillow.points = pillow.points[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    return pillow.deck(gas=FULL, more="*RIGIDWALL_PLANAR\n0\n0,250,0,0,0,0,0.3\n")


def odd_curves(pillow: Pillow) -> str:
    """Scale factors of 0, an offset that counts before them, and a time that is there twice."""
    curve = FULL.replace(
        "*DEFINE_CURVE\n1\n0,0\n4,3e-3\n10,0\n", "*DEFINE_CURVE\n1,0,0,0,-1\n1,0\n5,3e-3\n5,3e-3\n11,0\n"
    )
    assert curve != FULL
    return pillow.deck(gas=curve)


def cut_short(pillow: Pillow) -> str:
    """Gas without an exit: the deck ends as the pressure has its peak."""
    return pillow.deck(gas=FULL.replace("0.7,,400", "0,,0").replace("20\n", "11\n"))


def of_rubber(pillow: Pillow) -> str:
    """A hundredth of the modulus of any fabric."""
    return pillow.deck(gas=FULL, cloth=CLOTH.replace("1,8e-7,0.4,0.35,,0.2\n0.01", "1,8e-7,0.004,0.0035,,0.2\n0.0001"))


TRAPS = {
    glued: "", random_normals: "", open_around_the_nozzle: "", a_gas_that_is_none: "", upright: "", odd_curves: "",
    cut_short: "a longer run.end_time", of_rubber: "W-FAB-001",
}  # fmt: skip
"""Deck, and what a verdict below PASS or its warning is about."""


@pytest.mark.parametrize("deck", list(TRAPS), ids=[deck.__name__ for deck in TRAPS])
def test_it_runs_to_its_end_with_a_verdict_that_names_the_fault(deck, tmp_path):
    (tmp_path / "bag.k").write_text(deck(Pillow(ROWS)))
    units = "kg-mm-ms" if deck in (a_gas_that_is_none, of_rubber) else "auto"
    import_deck(tmp_path / "bag.k", tmp_path / "case", Options(units=units))
    case = Case.load(tmp_path / "case" / "case.toml")
    assert case.fabric.density == pytest.approx(786.0 if deck is glued else 800.0)
    result = simulate(case, tmp_path / "run")
    assert result.status == "completed"
    if deck is not a_gas_that_is_none:  # whose mass flow is another
        blown = np.interp(5e-3, result.histories["time [s]"], result.histories["injected [kg]"])
        assert blown == pytest.approx(8.75e-3, rel=1e-3)
    quality, log = result.record["quality"], (tmp_path / "run" / "solver.log").read_text()
    about = [c for c in quality["criteria"] if c["verdict"] != "PASS"]
    if not TRAPS[deck]:
        assert quality["verdict"] == "PASS", about
    else:
        assert quality["verdict"] == "REVIEW"
        assert TRAPS[deck] in log


BASE = """[fabric]
[inflator]
mass_flow = { time = [0, "5 ms", "10 ms"], value = [0, 12.0, 0] }
[inflator.jets]
count = 12
[run]
end_time = "20 ms"
"""


def test_a_mesh_alone_takes_the_rest_from_a_case_and_runs_without_jets_if_it_has_no_mouth(tmp_path):
    """As a public deck of 2,432 quads comes: parts without sections and materials."""
    (tmp_path / "base.toml").write_text(BASE)
    (tmp_path / "bag.k").write_text(Pillow(ROWS).deck(cloth="", gas=""))
    parts = {1: "fabric", 2: "fabric"}
    options = Options(units="kg-mm-ms", parts=parts, base=tmp_path / "base.toml")
    report = import_deck(tmp_path / "bag.k", tmp_path / "case", options)
    case = Case.load(tmp_path / "case" / "case.toml")
    assert case.inflators[0].jets.count == 0
    assert any("no mouth" in remark for remark in report.remarks)
    result = simulate(case, tmp_path / "run")
    assert (result.status, result.record["quality"]["verdict"]) == ("completed", "PASS")
