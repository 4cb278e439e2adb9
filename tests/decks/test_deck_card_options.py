"""Options of keywords that bring cards of their own: nothing behind them may be read from the wrong card."""

from __future__ import annotations

import numpy as np
import pytest
from test_deck_gases import BEGIN, END, ring, with_mouth
from test_decks_of_others import CLOTH, GAS, Pillow

from billow.case.schema import Case
from billow.decks.import_deck import Options, import_deck


@pytest.fixture
def read(tmp_path):
    """Import a deck: its case and report."""

    def make(text: str, **options):
        (tmp_path / "bag.k").write_text(text)
        case = tmp_path / f"case_{len(list(tmp_path.iterdir()))}"
        report = import_deck(tmp_path / "bag.k", case, Options(**options))
        return Case.load(case / "case.toml"), report

    return make


@pytest.fixture
def use(read):
    """The same with other cards of the airbag, of a pillow whose part 3 is the mouth."""

    def make(airbag: str, more: str = "", **options):
        deck = with_mouth().deck(gas=GAS[:BEGIN] + airbag + GAS[END:], cloth=CLOTH, more=more)
        return read(deck, parts={3: "mouth"}, **options)

    return make


AIR = "1.01e-4,293,0.029,29,0,0"
PARTICLE = (
    "*AIRBAG_PARTICLE{name}\n{mpp}{id}{time}1,1,0,0,0,0,0,0\n{segment}5000,0,1,293,1.01e-4,0,40,1e10\n{jet}1,2,6\n"
    + AIR
    + "\n{moles}1,2,0.028,29,0,0,1\n{second},2,0.044,37,0,0,1\n"
    + "".join(f"{9001 + k},12.5,{9001 + k},,1\n" for k in range(6))
)
SHARES = "*DEFINE_CURVE\n3\n0,0.75\n100,0.25\n*DEFINE_CURVE\n4\n0,0.25\n100,0.75\n"


def particle(name: str = "", **cards: str) -> str:
    blank = dict.fromkeys(("mpp", "id", "time", "segment", "jet", "moles"), "")
    return PARTICLE.format(name=name, **{**blank, "second": "1", **cards})


def test_options_of_particles_insert_their_cards_before_the_right_ones(use):
    plain, _ = use(particle(), ring(-90.0))
    cards = {
        "mpp": "2,1,1\n", "id": "7,the bag\n", "time": "0,1e20\n", "segment": "0\n", "jet": "0\n",
    }  # fmt: skip
    case, report = use(particle("_MPP_DECOMPOSITION_INFLATION_JET_SEGMENT_TIME_ID", **cards), ring(-90.0))
    expected, found = plain.to_dict(), case.to_dict()
    assert found["gas"] == expected["gas"]
    assert found["inflator"] == expected["inflator"]
    names = {row.field.split(".")[1] for row in report.of("refused")}
    assert names == {"SEGSID", "JNODE"}


@pytest.mark.parametrize(("card", "refused"), [("3,1e20", "BIRTH"), ("0,15", "DEATH")])
def test_a_gas_that_comes_later_or_goes_is_refused(use, card, refused):
    _, report = use(particle("_TIME", time=card + "\n"), ring(-90.0))
    assert [row.field for row in report.of("refused")] == [f"AIRBAG_PARTICLE_TIME.{refused}"]


def test_shares_of_moles_become_mass_flows(use):
    """m_i = m x_i M_i / sum(x M): here x = 0.5 both at 50 ms, M = 28 and 44 g/mol."""
    cards = particle("_MOLEFRACTION", moles="1\n", second="4").replace("\n1,2,0.028", "\n3,2,0.028")
    case, report = use(cards, ring(-90.0) + SHARES)
    time = np.linspace(0.0, 0.04, 9)
    whole = np.interp(time, [0.0, 0.01, 0.04], [0.0, 1.0, 0.0])  # kg/s
    flows = [np.interp(time, one.mass_flow.time, one.mass_flow.value) for one in case.inflators]
    assert sum(flows) == pytest.approx(whole, abs=1e-12)
    at = 0.01
    x = 0.75 - 0.5 * at / 0.1
    share = x * 28.0 / (x * 28.0 + (1.0 - x) * 44.0)
    assert np.interp(at, case.inflators[0].mass_flow.time, case.inflators[0].mass_flow.value) == pytest.approx(share)
    assert {row.status for row in report.rows.values() if row.field.endswith("LCMASS")} == {"mapped"}


WANG = "*AIRBAG_WANG_NEFSKE{}\n1,1\n718,1005,600,0,1\n0.7,,0\n1.01e-4,1.2e-9,1\n{}"
ALONG, ENDS = "300,300,-90,300,300,10,0.3,1\n", "0,0,0,0,0\n"


@pytest.mark.parametrize("inflator", ["\n", ""])
def test_the_card_of_an_inflator_may_be_blank_or_missing(use, inflator):
    """Its blank card comes before that of exits that open, which comes before those of the jet."""
    cards = WANG.format("_JETTING_POP", f"{inflator}3,0,0,9,9,1,0,7\n{ALONG}{ENDS}")
    case, report = use(cards, units="kg-mm-ms")
    (inflator,) = case.inflators
    assert inflator.jets.count == 1
    assert {row.field.split(".")[1] for row in report.of("refused")} == {"AZP", "AMAGP", "TDURP", "RBIDP"}


def test_a_field_of_many_jets_is_refused_by_name(use):
    cards = WANG.format("_MULTIPLE_JETTING", f"\n{ALONG}{ENDS}".replace("0.3", "17"))
    case, report = use(cards, units="kg-mm-ms")
    assert case.inflators[0].jets.count == 0
    assert "AIRBAG_WANG_NEFSKE_MULTIPLE_JETTING.LCJRV" in {row.field for row in report.of("refused")}


def test_with_the_fabrics_own_law_the_fields_of_ap23_count_as_zero(use):
    for option, names in (("0", ["exit", "porosity"]), ("7", ["exit"])):
        cards = f"*AIRBAG_HYBRID\n1,1\n293,1.01e-4,,8.314,1\n0.6,,100,,0.5,,200\n{option},,1\n1,2,,0.028,1,29\n"
        case, report = use(cards)
        assert [one.name for one in case.gas.orifices] == names
        assert not report.of("refused")


def test_a_card_of_yarns_stands_between_leakage_and_axes(read):
    """FVOPT below zero; its X0 and X1 are on the card of axes, ISREFG on that of the vector."""
    for yarns, refused in (("", []), ("\n0,0,0,0,0", []), ("\n1,0.2,0.1,0.5,2", ["L", "R", "C1", "C2", "C3"])):
        cloth = CLOTH.replace("2\n,,,1\n\n", f"2,0.1,0.2,,,0,-1{yarns}\n,,1,1,0,0,0.3,0.4\n,,,,,,0,0\n")
        case, report = read(Pillow().deck(cloth=cloth))
        assert case.leakage.area == pytest.approx((0.3, 0.4, 0.1, 0.2))
        assert [row.field.split(".")[1] for row in report.of("refused")] == refused


@pytest.mark.parametrize("mpp", ["0,200\n", "0,200\n&,0,1,0\n"])
def test_contacts_of_mpp_have_a_card_more_and_perhaps_two(read, mpp):
    more = f"*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_MPP_ID\n4\n{mpp}1,2,3,3\n0.35,0.35\n1,1\n"
    _, report = read(Pillow().deck(more=more))
    (row,) = [r for r in report.rows.values() if r.field.endswith(".FS")]
    assert (row.deck, row.status) == ("0.35", "mapped")


def test_sections_of_a_cylinder_stand_before_its_motion(read):
    wall = (
        "*RIGIDWALL_GEOMETRIC_CYLINDER_MOTION\n0\n300,300,900,300,300,1200,0.1\n100,300,1\n50,20\n9,1,0,0,-1\n"
        "*DEFINE_CURVE\n9\n0,0\n20,50\n"
    )
    case, report = read(Pillow().deck(more=wall))
    (one,) = case.obstacles
    assert (one.radius, one.length, one.motion.kind) == (pytest.approx(0.1), pytest.approx(0.3), "travel")
    assert {row.field.split(".")[1] for row in report.of("refused")} == {"VL[1]", "HEIGHT[1]"}
