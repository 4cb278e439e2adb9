"""ASCII histories of LS-DYNA: columns whose numbers touch, tables of rotations, sides of contacts, and damage."""

from __future__ import annotations

import numpy as np
import pytest
from test_dyna_results import write_histories, write_runs

from billow.base.errors import InputError
from billow.results.histories import read_histories
from billow.study.dyna_text import read_text
from billow.study.import_runs import import_runs

TIMES = (0.0, 10.0, 20.0)
LEGEND = " a title\n{BEGIN LEGEND}\n Entity #        Title\n       11     a node\n{END LEGEND}\n"


def nodout(times=TIMES) -> str:
    text = LEGEND
    for k, t in enumerate(times, 1):
        head = f"\n\n\n n o d a l   p r i n t   o u t   f o r   t i m e  s t e p{k:8d}{'':30s}( at time{t:14.7E} )\n"
        text += head + "\n nodal point  x-disp     y-disp      z-disp      x-vel       y-vel\n"
        for node in (11, 12):
            values = [-1.5e-100, 0.25, t * (node - 10), *(-1.0 - t,) * 9]
            text += f"{node:9d}{values[0]:13.4E}" + "".join(f"{v:12.4E}" for v in values[1:]) + "\n"
        text += head + "\n nodal point  x-rot      y-rot       z-rot\n"
        text += "".join(f"{node:9d}{9.9:13.4E}" + 8 * f"{9.9:12.4E}" + "\n" for node in (11, 12))
    return text


def rbdout() -> str:
    text = " a title\n"
    for k, t in enumerate(TIMES, 1):
        text += f"1\n\n  r i g i d   b o d y   m o t i o n   a t  cycle={k:8d}    time={t:15.6E}\n"
        for body, called in ((7, "\n rigid body"), (8, " nodal rigid body")):
            row = lambda *v: "".join(f"{x:12.4E}" for x in v) + "\n"  # noqa: E731
            text += f"{called}{body:8d}\n   global             x           y           z          x-rot\n"
            text += "   coordinates:  " + row(1, 2, 3)
            text += " displacements:  " + row(0, 0, t, 5, 5, 5) + "    velocities:  " + row(0, body, -t, 5, 5, 5)
            text += " accelerations:  " + row(6, 6, 6, 6, 6, 6)
            text += "\nprincipal or user defined local coordinate direction vectors\n     row 1" + row(1, 0, 0)
            text += " output in principal or user defined local coordinate directions\n"
            text += " displacements:  " + row(9, 9, 9, 9, 9, 9) + "    velocities:  " + row(9, 9, 9, 9, 9, 9)
    return text


def rcforc() -> str:
    rows = ""
    for t in TIMES:
        for side, z in (("slave ", t), ("master", -t)):
            rows += f"   {side}{3:11d} time{t:12.5E}  x {0.0:12.5E}  y {1.0:12.5E} z {z:12.5E} mass {0.0:12.5E}\n"
    return LEGEND + rows


def abstat(pressure: float = 1e-4) -> str:
    text = LEGEND
    head = (
        "\n\n      time   airbag/cv #  volume        pressure    internal energy      dm/dt in      density dm/dt out"
        "  total mass gas temp. surface area   reaction\n"
    )
    for t in TIMES:
        for bag, p in ((1, pressure), (2, 9.0)):
            values = "".join(f"{v:15.4E}" for v in (5e7, p, 3.0, 1e-3, 1e-9))
            text += (head if bag == 1 else "") + f"{t:12.5E}{bag:8d}{values}"
            text += "".join(f"{v:11.3E}" for v in (2e-4, 0.02, 500.0, 1e5, 0.0)) + "\n"
    return text


WRITERS = {"nodout": nodout, "rbdout": rbdout, "rcforc": rcforc, "abstat": abstat}


@pytest.fixture
def read(tmp_path):
    def make(name: str, change=lambda text: text):
        (tmp_path / name).write_text(change(WRITERS[name]()))
        return read_text(tmp_path / name)

    return make


def test_numbers_that_touch_and_tables_of_rotations(read):
    found = read("nodout")
    assert found.ids == [11, 12]
    assert found.time.tolist() == [0.0, 10.0, 20.0]
    assert found.values["z_displacement"].tolist() == [[0.0, 0.0], [10.0, 20.0], [20.0, 40.0]]
    assert found.values["x_displacement"][0, 0] == -1.5e-100
    assert found.values["y_velocity"][:, 1].tolist() == [-1.0, -11.0, -21.0]


def test_bodies_in_the_axes_of_space(read):
    found = read("rbdout")
    assert found.ids == [7, 8]
    assert found.values["global_dz"][:, 0].tolist() == [0.0, 10.0, 20.0]
    assert found.values["global_vy"][2].tolist() == [7.0, 8.0]
    assert found.values["global_vz"][2].tolist() == [-20.0, -20.0]


def test_the_first_side_of_a_contact(read):
    found = read("rcforc")
    assert found.ids == [3]
    assert found.values["z_force"][:, 0].tolist() == [0.0, 10.0, 20.0]
    assert found.values["y_force"][:, 0].tolist() == [1.0, 1.0, 1.0]


def test_an_airbag(read):
    found = read("abstat")
    assert found.ids == [1, 2]
    first = {name: values[0, 0] for name, values in found.values.items()}
    assert (first["volume"], first["pressure"], first["dm_dt_in"], first["dm_dt_out"]) == (5e7, 1e-4, 1e-3, 2e-4)
    assert (first["total_mass"], first["gas_temp"]) == (0.02, 500.0)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("nodout", lambda text: text[: text.rindex("       12 -1.5")], "state at 20"),
        ("nodout", lambda text: text.replace("2.5000E-01", "**********", 1), "line 12: 11 numbers; 12"),
        ("nodout", lambda text: text.replace("at time 2.0000000E+01", "at time 5.0000000E+00"), "time 5 follows 10"),
        ("rcforc", lambda text: "another layout\n", "no state"),
        ("abstat", lambda text: text.replace("dm/dt in", "flow in"), "columns that are not known"),
        ("rbdout", lambda text: text.replace(" nodal rigid body       8", " nodal rigid body       9", 1), "state at"),
    ],
)
def test_what_is_damaged_is_refused_with_its_place(read, name, change, words):
    with pytest.raises(ValueError, match=words):
        read(name, change)


def test_ascii_histories_become_those_of_binout(tmp_path):
    """The same numbers by both ways; what binout has counts."""
    for kind in ("binout", "ascii"):
        write_runs(tmp_path / kind)
    write_histories(tmp_path / "binout")
    for run in range(4):
        place = tmp_path / "ascii" / f"{run:04d}"
        (place / "abstat").write_text(abstat(1e-4 * (1 + run)))
        (place / "nodout").write_text(nodout())
        (place / "rcforc").write_text(rcforc())
        (tmp_path / "binout" / f"{run:04d}" / "abstat").write_text(abstat(7.0))  # binout has it, too
    found = []
    for kind in ("binout", "ascii"):
        import_runs(tmp_path / kind, tmp_path / f"study_{kind}", units="kg-mm-ms")
        found.append(read_histories(tmp_path / f"study_{kind}" / "runs" / "0001" / "histories.csv"))
    assert found[0]["pressure [Pa]"] == pytest.approx([2e5] * 3)
    for name in ("time [s]", "pressure [Pa]", "node_12_displacement_z [m]", "contact_3_force_z [N]"):
        np.testing.assert_allclose(found[1][name], found[0][name], rtol=1e-6)


def test_ascii_histories_at_other_times_are_refused(tmp_path):
    write_runs(tmp_path / "runs")
    for run in range(4):
        place = tmp_path / "runs" / f"{run:04d}"
        (place / "abstat").write_text(abstat())
        (place / "nodout").write_text(nodout((0.0, 10.0, 20.5)))
    with pytest.raises(InputError, match=r"E-STU-027(.|\n)*abstat has other times"):
        import_runs(tmp_path / "runs", tmp_path / "study", units="kg-mm-ms")
