"""A case that is exported and imported again is the same case: bits of the mesh, and every number, in any units."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.gas.build_gas import build_supply
from billow.case.schema import Case
from billow.decks.exact_lengths import metres, written
from billow.decks.export_deck import deck_of, export_deck
from billow.decks.fields import known
from billow.decks.import_deck import Options, import_deck
from billow.decks.keyword_file import Deck
from billow.decks.tables import Model
from billow.decks.units import SYSTEMS
from billow.geometry.shapes.pose import rotation_matrix
from billow.run.simulate import simulate

SMOKE = {"molar_mass": 0.028, "a": 29.0, "b": 1e-3, "c": -1e-7}
CASE = {
    "title": "A driver bag",
    "bag": {
        "element_size": 0.06,
        "seam": {"layers": 1.0},
        "vents": {"count": 1, "discharge": 0.65, "opening_pressure": 2000.0},
        "straps": {"count": 0},
    },
    "fabric": {"young_weft": 0.3e9, "poisson": 0.25, "damping": 0.04, "liner": {"ratio": 0.02}, "self_contact": True},
    "gas": {
        "species": {"gas_1": SMOKE, "gas_2": {"molar_mass": 0.018, "a": 33.5}},
        "initial": {"gas": {"gas_1": 0.4, "gas_2": 0.6}, "fractions": "mass"},
        "heat_transfer": 12.0,
        "orifices": [{"name": "porosity", "between": ["bag", "ambient"], "area": 2e-4, "discharge": 0.6}],
    },
    "leakage": {"law": "wang-nefske", "time_factor": 0.01, "pressure_factor": 0.5, "area": "deformed"},
    "inflator": [
        {
            "name": name,
            "gas": {name: 1.0},
            "mass_flow": {"time": [0.0, 0.01, 0.04], "value": [0.0, flow, 0.0]},
            "temperature": {"time": [0.0, 0.05], "value": [700.0, 450.0]},
            "jets": {"count": 0},
        }
        for name, flow in (("gas_1", 1.5), ("gas_2", 0.3))
    ],
    "ambient": {"pressure": 98000.0, "temperature": 291.0},
    "obstacles": [
        {"shape": "plate", "name": "table_in_the_middle_of_the_room", "friction": 0.3, "height": -0.01},
        {"shape": "super-ellipsoid", "name": "head", "radii": [0.08, 0.08, 0.08], "clearance": 0.2},
    ],
    "run": {"end_time": 0.04, "frames": 20, "histories_per_frame": 5},
}


@pytest.fixture(scope="module")
def case():
    return Case.from_dict(CASE)


@pytest.fixture(scope="module")
def imported(case, tmp_path_factory):
    """The case that comes back from a deck in each system of units."""
    place = tmp_path_factory.mktemp("decks")
    found = {}
    for units in SYSTEMS:
        export_deck(case, place / f"{units}.k", units)
        report = import_deck(place / f"{units}.k", place / units)
        assert report.remarks[0].startswith(f"units {units}:")
        assert not report.of("refused")
        found[units] = Case.load(place / units / "case.toml")
    return found


RING = {"count": 8, "ring_radius": 0.03, "hole_diameter": 0.004, "angle": 60.0, "cone": 12.0}


def numbers(tree, path=""):
    if isinstance(tree, dict):
        return {k: v for key, value in tree.items() for k, v in numbers(value, f"{path}.{key}").items()}
    if isinstance(tree, list | tuple):
        return {k: v for n, value in enumerate(tree) for k, v in numbers(value, f"{path}.{n}").items()}
    return {path: tree}


def same(one: Case, other: Case, tolerance: float) -> None:
    a, b = (numbers(c.to_dict()) for c in (one, other))
    assert a.keys() == b.keys()
    for key, value in a.items():
        if key.endswith(("start", "reference", "digest")):
            continue
        if isinstance(value, float):
            assert value == pytest.approx(b[key], rel=tolerance, abs=1e-15), key
        else:
            assert value == b[key], key


def test_one_bag_in_five_systems_of_units_is_the_same_case(imported):
    first = imported["kg-mm-ms"]
    mine = build_shape(first.bag)
    for units, other in imported.items():
        same(first, other, 1e-9)
        theirs = build_shape(other.bag)
        assert np.array_equal(mine.surface.triangles, theirs.surface.triangles), units
        assert np.allclose(mine.positions, theirs.positions, rtol=1e-9, atol=1e-15)
        assert np.allclose(mine.reference, theirs.reference, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("units", ["kg-mm-ms", "t-mm-s", "kg-m-s", "g-mm-ms"])
def test_mesh_and_flat_cut_keep_their_bits(case, imported, units):
    before, after = build_shape(case.bag), build_shape(imported[units].bag)
    assert np.array_equal(before.surface.triangles, after.surface.triangles)
    assert before.surface.part_names == after.surface.part_names
    assert before.surface.part_kinds == after.surface.part_kinds
    assert before.positions.tobytes() == (after.positions + 0.0).tobytes() or np.array_equal(
        before.positions, after.positions
    )
    fabric = before.surface.triangles_of_kind("fabric")
    assert np.array_equal(before.reference[fabric], after.reference[fabric])
    assert np.array_equal(before.fixed, after.fixed)


def test_every_number_comes_back(case, imported):
    """What both cases say: the tables of a mesh are others than those of a driver bag."""
    before, after = numbers(case.to_dict()), numbers(imported["kg-mm-ms"].to_dict())
    shared = [key for key in before if not key.startswith(".bag") or key.startswith(".bag.vents")]
    for key in shared:
        if key.split(".")[-1] in ("count", "diameter", "distance"):
            continue
        value = before[key]
        if isinstance(value, float):
            assert after[key] == pytest.approx(value, rel=1e-6, abs=1e-12), key
        else:
            assert after[key] == value, key


def test_masses_and_volume_are_those_of_the_case(case, imported):
    before, after = build_model(case), build_model(imported["t-mm-s"])
    assert after.mass.sum() == pytest.approx(before.mass.sum(), rel=1e-9)
    assert after.surface.volume(after.start) == pytest.approx(before.surface.volume(before.start), rel=1e-12)
    areas = [{p.name: p.area for p in m.gas.supply.passages.rows} for m in (before, after)]
    assert sorted(areas[0].values()) == pytest.approx(sorted(areas[1].values()), rel=1e-9)


def test_a_run_of_the_imported_case_has_the_same_bits(case, imported, tmp_path):
    """The same mesh: what the deck says of fabric, gas and walls must then be the same to the last bit."""
    after = imported["kg-mm-ms"]
    tables = {"bag": after.to_dict()["bag"], "obstacles": CASE["obstacles"][:1], "run": {"end_time": 1e-3, "frames": 2}}
    native = Case.from_dict({**CASE, **tables})
    wall = after.to_dict()["obstacles"][0]
    brought = Case.from_dict({**after.to_dict(), "obstacles": [wall], "run": {"end_time": 1e-3, "frames": 2}})
    rows = []
    for number, one in enumerate((native, brought)):
        result = simulate(one, tmp_path / str(number))
        rows.append((result.folder / "histories.csv").read_bytes())
    assert rows[0] == rows[1]
    assert len(rows[0].splitlines()) == 22


def test_fabrics_of_parts_come_back(tmp_path):
    curved = {"law": "curves-shear", "density": 900.0, "thickness": 0.4e-3, "permeability": 0.05}
    before = Case.from_dict({**CASE, "leakage": {}, "fabric": {**CASE["fabric"], "parts": {"front": curved}}})
    export_deck(before, tmp_path / "bag.k", "kg-mm-ms")
    report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options())
    assert not report.of("refused")
    after = Case.load(tmp_path / "case" / "case.toml")
    cloth, again = before.fabric.parts["front"], after.fabric.parts["front"]
    assert (again.law, again.density, again.thickness) == pytest.approx((cloth.law, cloth.density, cloth.thickness))
    warp, own = (c.curves.warp.loading for c in (again, cloth))
    assert warp.strain == pytest.approx(own.strain, rel=1e-6)
    # From transverse 1 to 0: the same second Piola-Kirchhoff stress.
    assert warp.stress == pytest.approx(np.array(own.stress) * np.exp(own.strain), rel=1e-6)
    assert after.fabric.of("rear").young_weft == pytest.approx(0.3e9)
    one, other = build_model(before), build_model(after)
    assert other.mass.sum() == pytest.approx(one.mass.sum(), rel=1e-9)
    assert [type(m.fabric) for m in other.fabric.membranes] == [type(m.fabric) for m in one.fabric.membranes]
    rows = [row for row in report.rows.values() if row.key.startswith("fabric.parts.front.")]
    assert len(rows) > 10  # of the second material


def test_exporting_again_gives_the_same_deck(imported):
    first = imported["kg-mm-ms"]
    once, _ = deck_of(first, "kg-mm-ms")
    assert once == deck_of(first, "kg-mm-ms")[0]
    assert "*AIRBAG_HYBRID" in once


def test_one_keyword_makes_it_particles(case, tmp_path):
    made = Case.from_dict(
        CASE
        | {
            "gas": {**CASE["gas"], "model": "corpuscular", "particles": 20_000, "orifices": [], "switch_time": 0.03},
            "inflator": [
                {
                    **table,
                    "jets": {"count": 8, "ring_radius": 0.03, "hole_diameter": 0.004, "angle": 60.0, "cone": 12.0},
                }
                for table in CASE["inflator"]
            ],
        }
    )
    for units in ("kg-mm-ms", "g-mm-ms"):
        export_deck(made, tmp_path / f"{units}.k", units)
        report = import_deck(tmp_path / f"{units}.k", tmp_path / units)
        after = Case.load(tmp_path / units / "case.toml")
        assert not report.of("refused")
        assert (after.gas.model, after.gas.particles) == ("corpuscular", 20_000)
        assert after.gas.switch_time == pytest.approx(0.03)
        assert after.bag.vents.discharge == pytest.approx(0.65)
        assert after.bag.vents.opening_pressure == pytest.approx(2000.0)
        for before, back in zip(made.inflators, after.inflators, strict=True):
            assert back.jets.count == 8
            assert (back.jets.ring_radius, back.jets.angle) == pytest.approx((0.03, 60.0))
            assert (back.jets.hole_diameter, back.jets.cone) == pytest.approx((0.004, 12.0))
            assert back.mass_flow.value == pytest.approx(before.mass_flow.value)


@pytest.mark.parametrize(("model", "sign"), [("uniform-pressure", 1.0), ("corpuscular", -1.0)])
def test_normals_point_where_the_airbag_wants_them(model, sign, tmp_path):
    """Out of a control volume, into a bag of particles; either way the mesh comes back with its bits."""
    made = Case.from_dict({"bag": CASE["bag"], "gas": {"model": model}, "obstacles": []})
    export_deck(made, tmp_path / "bag.k")
    written = Model(Deck(tmp_path / "bag.k"))
    rows = written.nodes.rows(written.shells.corners[:, :3].ravel(), "a shell", "")
    a, b, c = written.nodes.metres(rows, SYSTEMS["kg-mm-ms"]).reshape(-1, 3, 3).transpose(1, 0, 2)
    before = build_shape(made.bag)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(
        sign * before.surface.volume(before.positions), rel=1e-9
    )
    import_deck(tmp_path / "bag.k", tmp_path / "case")
    after = build_shape(Case.load(tmp_path / "case" / "case.toml").bag)
    assert np.array_equal(before.surface.triangles, after.surface.triangles)
    cloth = before.surface.triangles_of_kind("fabric")
    assert np.array_equal(before.reference[cloth], after.reference[cloth])


@pytest.mark.parametrize("units", ["kg-mm-ms", "lbf-in-s"])
def test_every_field_of_airbag_material_and_contact_has_a_row(case, tmp_path, units):
    export_deck(case, tmp_path / "bag.k", units)
    import_deck(tmp_path / "bag.k", tmp_path / "case")
    rows = json.loads((tmp_path / "case" / "import.json").read_text())["fields"]
    named = {(row["field"], row["at"] if "at" in row else row["place"]) for row in rows}
    counted = 0
    for block in Deck(tmp_path / "bag.k").blocks:
        if not block.is_a("AIRBAG_HYBRID") and not block.is_a("MAT_FABRIC") and not block.is_a("CONTACT"):
            continue
        mine = [field for field, place in named if field.startswith(block.name + ".")]
        filled = 0
        for number, line in block.lines():
            texts = [line[k : k + 20].strip() for k in range(0, len(line), 20)]
            here = sum(place == f"{block.file}:{number}" for _, place in named)
            assert here >= sum(map(bool, texts)), (block.name, number)
            filled += here
        assert mine
        assert known(block.name)
        counted += filled
    assert counted > 100
    assert {row["status"] for row in rows} <= {"mapped", "approximated", "ignored", "refused"}
    assert all(row["note"] for row in rows if row["status"] != "mapped")


@given(st.floats(-5.0, 5.0), st.sampled_from(["kg-mm-ms", "kg-m-s"]))
def test_lengths_are_written_exactly(value, name):
    units = SYSTEMS[name]
    text = np.array([[written(value, units, 20).encode()] * 3])
    assert (metres(text, np.zeros((1, 3)), np.ones(1), units) == value).all()
    assert float(written(value, units, 20)) == pytest.approx(value / units.length, rel=1e-15)


def test_a_case_that_no_deck_can_be_is_refused_by_name(tmp_path):
    several = Case.from_dict({
        "bag": {"shape": "rectangular", "chambers": 2, "element_size": 0.05}, "gas": {"model": "corpuscular"},
        "inflator": {"chamber": "chamber_2", "jets": {"count": 0}},
    })  # fmt: skip
    with pytest.raises(InputError, match="E-DCK-020"):
        export_deck(several, tmp_path / "a.k")
    assert not (tmp_path / "a.k").exists()


def test_units_that_are_said_count(case, tmp_path):
    export_deck(case, tmp_path / "bag.k", "kg-m-s")
    import_deck(tmp_path / "bag.k", tmp_path / "case", Options(units="kg-m-s"))
    assert Case.load(tmp_path / "case" / "case.toml").run.end_time == pytest.approx(0.04)


@pytest.mark.parametrize(
    ("name", "pressure", "force", "density"),
    [
        ("kg-mm-ms", 1e9, 1e3, 1e9),
        ("t-mm-s", 1e6, 1.0, 1e12),
        ("kg-m-s", 1.0, 1.0, 1.0),
        ("g-mm-ms", 1e6, 1.0, 1e6),
        ("lbf-in-s", 6894.757293168, 4.4482216152605, 10686895.178),
    ],
)
def test_systems_of_units_are_what_they_are(name, pressure, force, density):
    """GPa and kN, MPa and N, Pa and N, MPa and N, psi and lbf: by the definitions of pound and inch."""
    units = SYSTEMS[name]
    assert units.factor("pressure") == pytest.approx(pressure, rel=1e-9)
    assert units.factor("pressure") * units.factor("area") == pytest.approx(force, rel=1e-9)
    assert units.factor("density") == pytest.approx(density, rel=1e-9)
    assert units.of_si(units.si(0.1234567, "density"), "density") == pytest.approx(0.1234567, rel=1e-14)


PAPER = Path(__file__).parents[2] / "examples" / "paper"
STAGE = {"gas": {"gas_1": 1.0}, "jets": {"count": 0}}


def of_the_paper(name: str, size: float, **settings) -> Case:
    """An example of the paper as far as *AIRBAG_HYBRID can say it: coarse, one layer of fabric, a gas of one species
    whose heat is a polynomial, no jets, self-contact on and not by itself."""
    tables = tomllib.loads((PAPER / f"{name}_up.toml").read_text())
    bag = {**tables["bag"], "element_size": size, "seam": {"layers": 1.0}}
    inflators = tables["inflator"] if isinstance(tables["inflator"], list) else [tables["inflator"]]
    stages = [{**one, **STAGE, "name": f"gas_{k}", "gas": {f"gas_{k}": 1.0}} for k, one in enumerate(inflators, 1)]
    gas = {**tables["gas"], "species": {one["name"]: SMOKE for one in stages}, "initial": {"gas": {"gas_1": 1.0}}}
    fabric = {**tables.get("fabric", {}), "self_contact": True}
    return Case.from_dict({**tables, "bag": bag, "inflator": stages, "gas": gas, "fabric": fabric}).vary(settings)


@pytest.mark.parametrize(
    ("name", "size"),
    [("square_two_stage", 0.06), ("square_spinning_jet", 0.05), ("folded_tube", 0.02), ("flat_driver", 0.06),
     ("folded_driver", 0.03)],
)  # fmt: skip
def test_examples_of_the_paper_come_back_and_run_to_the_same_bits(name, size, tmp_path):
    """Examples 5.1, 5.2, 5.4, 6.1, and 6.2 from its folded start against its flat cut; 5.3, with its chambers, is among
    the tests of several bags."""
    made = of_the_paper(name, size)
    export_deck(made, tmp_path / "bag.k")
    report = import_deck(tmp_path / "bag.k", tmp_path / "case")
    assert not report.of("refused")
    back = Case.load(tmp_path / "case" / "case.toml")
    before, after = build_shape(made.bag), build_shape(back.bag)
    assert np.array_equal(before.surface.triangles, after.surface.triangles)
    assert np.array_equal(before.positions + 0.0, after.positions + 0.0)
    cloth = before.surface.triangles_of_kind("fabric")
    assert np.array_equal(before.reference[cloth], after.reference[cloth])
    assert getattr(back.bag, "birth_time", 0.0) == getattr(made.bag, "birth_time", 0.0)
    short = {"run.end_time": 5e-4, "run.frames": 2, "run.histories_per_frame": 5, "run.dt_scale": 1.0,
             "run.guard_crossings": False}  # fmt: skip
    rows = []
    for number, one in enumerate((made, back)):
        shared = {**one.to_dict(), "bag": back.to_dict()["bag"], "obstacles": back.to_dict()["obstacles"][:1]}
        shared["inflator"] = made.to_dict()["inflator"] if number == 0 else shared["inflator"]
        case = Case.from_dict(shared).vary(short)
        rows.append((simulate(case, tmp_path / str(number)).folder / "histories.csv").read_bytes())
    assert rows[0] == rows[1]


@pytest.mark.parametrize(
    ("name", "size"),
    [("square_two_stage", 0.05), ("square_spinning_jet", 0.05), ("folded_tube", 0.02), ("flat_driver", 0.06),
     ("folded_driver", 0.03)],
)  # fmt: skip
def test_the_same_examples_with_particles_keep_jets_gas_and_vents(name, size, tmp_path):
    """One keyword switches; holes of single jets and of rings stand and blow as before."""
    tables = tomllib.loads((PAPER / f"{name}_particles.toml").read_text())
    made = Case.from_dict(tables).vary({"bag.element_size": size})
    notes = export_deck(made, tmp_path / "bag.k")
    assert any("spin" in note for note in notes) == ("spin" in name)
    report = import_deck(tmp_path / "bag.k", tmp_path / "case")
    back = Case.load(tmp_path / "case" / "case.toml")
    assert not report.of("refused")
    assert (back.gas.model, back.gas.particles) == ("corpuscular", made.gas.particles)
    injected = [sum(np.trapezoid(i.mass_flow.value, i.mass_flow.time) for i in one.inflators) for one in (made, back)]
    assert injected[1] == pytest.approx(injected[0], rel=1e-9)
    assert [p.kind for p in back.bag.parts].count("vent") == ("spin" in name)
    before, after = (holes(one) for one in (made, back))
    for mine, other in zip(before, after[:: len(after) // len(before)], strict=True):
        for a, b in zip(mine[:2], other[:2], strict=True):
            assert a == pytest.approx(b, abs=1e-9)


def holes(case: Case) -> list[tuple[np.ndarray, ...]]:
    """Places of the holes of each inflator, and frames of their jets."""
    shape = build_shape(case.bag)
    return [source.jets.nozzles(shape.positions) for source in build_supply(case, shape).sources]


@pytest.mark.parametrize("azimuth", [0.0, 10.0, -20.0])
def test_a_ring_of_jets_keeps_its_place(azimuth, tmp_path):
    """Exported from a mesh: azimuths count from a node of the mouth's rim."""
    gas = {**CASE["gas"], "model": "corpuscular", "orifices": [], "initial": {"gas": {"gas_1": 1.0}}}
    stages = [{**one, "jets": {**RING, "azimuth": azimuth}} for one in CASE["inflator"]]
    made = Case.from_dict({**CASE, "gas": gas, "inflator": stages})
    once, twice = tmp_path / "once", tmp_path / "twice"
    export_deck(made, tmp_path / "bag.k")
    import_deck(tmp_path / "bag.k", once)
    export_deck(Case.load(once / "case.toml"), tmp_path / "again.k")
    import_deck(tmp_path / "again.k", twice)
    expected = holes(made)
    for folder in (once, twice):
        for mine, other in zip(expected, holes(Case.load(folder / "case.toml")), strict=True):
            # Rings are the same whichever of their holes is the first.
            order = [np.lexsort(np.round(place, 9).T) for place in (mine[0], other[0])]
            for k in (0, 1):
                assert mine[k][order[0]] == pytest.approx(other[k][order[1]], abs=1e-9)


def test_a_body_that_is_free_is_written_with_its_mass(tmp_path):
    made = of_the_paper("folded_driver", 0.03)
    export_deck(made, tmp_path / "bag.k")
    import_deck(tmp_path / "bag.k", tmp_path / "case")
    (body,) = [o for o in Case.load(tmp_path / "case" / "case.toml").obstacles if o.shape != "plate"]
    assert body.mass == pytest.approx(15.0)
    assert not body.locked


def test_seams_that_vary_in_layers_are_written_shell_by_shell(tmp_path):
    made = Case.from_dict({**CASE, "bag": {**CASE["bag"], "seam": {"layers": 2.0}}})
    notes = export_deck(made, tmp_path / "bag.k")
    assert any("each shell" in note for note in notes)
    shells = Model(Deck(tmp_path / "bag.k")).shells
    shape = build_shape(made.bag)
    written = shells.thickness[np.argsort(shells.number)] * 1e-3
    cloth = shape.surface.triangles_of_kind("fabric")
    assert written[cloth] == pytest.approx(made.fabric.thickness * shape.layers[cloth], rel=1e-12)
    assert np.ptp(written[cloth]) > 0.0


@pytest.mark.parametrize(
    ("key", "table"),
    [("tear_seams", {"strength": 1e3, "begin": [0.1, -0.1], "end": [0.1, 0.1]}),
     ("covers", {"strength": 1e3, "place": [0, 0, 0.05], "length": 0.3, "width": 0.2})],
)  # fmt: skip
def test_what_would_open_the_bag_otherwise_is_refused(key, table, tmp_path):
    made = Case.from_dict({"bag": {"element_size": 0.06, key: [table]}})
    with pytest.raises(InputError, match=rf"E-DCK-020(.|\n)*bag\.{key}"):
        export_deck(made, tmp_path / "a.k")


STRAPS = {
    "tethers": {"count": 4, "length": 0.28},  # slack: the start is flat
    "of their own": {"count": 2, "length": "start", "stiffness": 9e3, "width": 0.04},
    "tense": {"count": 3, "length": 0.03, "stiffness": 9e3},
}


@pytest.mark.parametrize("units", ["kg-mm-ms", "lbf-in-s"])
@pytest.mark.parametrize("straps", STRAPS.values(), ids=list(STRAPS))
def test_straps_come_back_as_bars_of_the_same_length_stiffness_and_mass(straps, units, tmp_path):
    made = Case.from_dict({**CASE, "bag": {**CASE["bag"], "straps": straps}})
    notes = export_deck(made, tmp_path / "bag.k", units)
    report = import_deck(tmp_path / "bag.k", tmp_path / "case", Options(units=units))
    assert not report.of("refused")
    before, after = (build_model(c).straps for c in (made, Case.load(tmp_path / "case" / "case.toml")))
    rows = []
    for one in (before, after):
        order = np.lexsort((one.bars[:, 1], one.bars[:, 0]))
        rows.append([one.bars[order], one.length[order], one.stiffness[order], one.mass[order]])
    assert np.array_equal(rows[0][0], rows[1][0])
    assert rows[1][1] == pytest.approx(rows[0][1], rel=1e-9)
    assert rows[1][2] == pytest.approx(rows[0][2], rel=1e-9)
    springs = any("springs, without mass" in note for note in notes)
    assert springs == (straps["length"] == 0.03)
    if not springs:
        assert rows[1][3] == pytest.approx(rows[0][3], rel=1e-9)


PUSH = {"kind": "travel", "direction": [0.0, 0.0, 1.0], "travel": {"time": [0.0, 0.02], "value": [0.0, 0.03]}}


@pytest.mark.parametrize(
    ("table", "count"),
    [
        ({"shape": "housing", "inner": [0.3, 0.2], "depth": 0.06, "place": [0.02, 0.0, -0.1], "turn": 30.0}, 5),
        ({"shape": "housing", "inner": [0.3, 0.2], "depth": 0.06, "floor": False, "normal": [0.0, 1.0, 1.0]}, 4),
        ({"shape": "box", "size": [0.2, 0.1, 0.05], "place": [0.0, 0.0, 0.4], "motion": PUSH}, 1),
    ],
)
def test_boxes_and_housings_are_written_as_rigid_parts(table, count, tmp_path):
    """Their triangles lie on the surfaces of the boxes, and as many obstacles stand or move alike."""
    made = Case.from_dict({**CASE, "obstacles": [{**table, "name": "tin", "edge": 0.004}]})
    notes = export_deck(made, tmp_path / "bag.k")
    assert any("rigid parts, one for each" in note for note in notes) == (count > 1)
    report = import_deck(tmp_path / "bag.k", tmp_path / "case")
    assert not report.of("refused")
    back = Case.load(tmp_path / "case" / "case.toml").obstacles
    assert [o.name for o in back] == (["tin"] if count == 1 else [f"tin_{k}" for k in range(1, count + 1)])
    carried, _, start = made.obstacles[0].build()
    turn = rotation_matrix(start.quaternion)
    for box, obstacle in zip(carried, back, strict=True):
        (mesh,), _, stands = obstacle.build()
        points = mesh.shape.points @ rotation_matrix(stands.quaternion).T + mesh.centre + stands.centre
        own = (points - start.centre) @ turn - box.centre
        assert np.abs(box.shape.level(own)).max() < 1e-9
        assert np.ptp(own, axis=0) == pytest.approx(2.0 * np.asarray(box.shape.half), rel=1e-9)
        assert obstacle.locked
        assert obstacle.motion.kind == table.get("motion", {"kind": "none"})["kind"]


def test_a_housing_on_a_rail_is_left_out_with_a_word(tmp_path):
    rail = {"kind": "guided", "direction": [0.0, 0.0, 1.0], "mass": 1.0}
    tin = {"shape": "housing", "name": "tin", "inner": [0.3, 0.2], "depth": 0.06, "motion": rail}
    notes = export_deck(Case.from_dict({**CASE, "obstacles": [tin]}), tmp_path / "bag.k")
    assert any("obstacles.tin: left out" in note for note in notes)
