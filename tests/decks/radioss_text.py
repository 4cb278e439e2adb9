"""A bag of ours as a starter deck of Radioss, and small decks with known truth."""

from __future__ import annotations

import numpy as np

from billow.case.bag.build_bag import build_shape
from billow.case.schema import Case
from billow.decks.exact_lengths import written
from billow.decks.units import Units

DIGITS = 9
"""Decimals of coordinates in metres, so that they fit their columns."""


def reals(*values: float | None) -> str:
    texts = ["" if v is None else repr(float(v)) for v in values]
    assert all(len(t) <= 20 for t in texts), texts
    return "".join(t.rjust(20) for t in texts).rstrip() + "\n"


def line(*cells: tuple[object, int]) -> str:
    """Cells and their widths."""
    texts = [("" if v is None else repr(v) if isinstance(v, float) else str(v), w) for v, w in cells]
    assert all(len(t) <= w for t, w in texts), texts
    return "".join(t.rjust(w) for t, w in texts).rstrip() + "\n"


def whole(*values: int | None) -> str:
    return line(*((v, 10) for v in values))


class Starter:
    """Blocks as they are added; lengths in the units of the deck."""

    def __init__(self, mass: str = "kg", length: str = "mm", time: str = "ms", units: Units | None = None):
        self.units = units or Units("deck", 1.0, 1e-3, 1e-3)
        rows = f"{mass:>20}{length:>20}{time:>20}\n"
        self.text = "#RADIOSS STARTER\n# a bag of our own\n/BEGIN\nbag\n" + whole(2022, 0) + rows * 2

    def add(self, head: str, *lines: str) -> None:
        self.text += f"/{head}\n#---1----|----2----|\n" + "".join(lines)

    def of(self, value: float, dimension: str) -> float:
        return self.units.of_si(float(value), dimension)

    def nodes(self, points: np.ndarray, first: int = 1) -> str:
        rows = ""
        for k, point in enumerate(points.tolist(), first):
            texts = [written(v, self.units, 20) for v in point]
            assert all(len(t) <= 20 for t in texts)
            rows += f"{k:10d}" + "".join(t.rjust(20) for t in texts) + "\n"
        return rows

    def curve(self, number: int, title: str, x, y) -> None:
        self.add(f"FUNCT/{number}", title + "\n", *(reals(a, b) for a, b in zip(x, y, strict=True)))

    def __str__(self) -> str:
        return self.text + "/END\n"


def starter_of(case: Case) -> str:
    """A driver bag without straps: LAW19, one gas an injector, a vent that opens by pressure, a plate; flat cut by
    elements."""
    shape, deck = build_shape(case.bag), Starter()
    surface = shape.surface
    deck.add("NODE", deck.nodes(np.round(shape.positions, DIGITS)))
    flat = np.round(
        np.concatenate([shape.reference.reshape(-1, 2), np.zeros((3 * surface.triangle_count, 1))], axis=1), DIGITS
    )
    begin = len(shape.positions)
    deck.add("NODE", deck.nodes(flat, begin + 1))
    fabric = [kind == "fabric" for kind in surface.part_kinds]
    runs = np.split(np.arange(surface.triangle_count), np.flatnonzero(np.diff(surface.part.astype(int))) + 1)
    for mine in runs:  # a block for each run of one part, so that shells keep their order
        number = int(surface.part[mine[0]]) + 1
        cells = surface.triangles[mine] + 1
        deck.add(f"SH3N/{number}", *(whole(int(k) + 1, *map(int, c)) for k, c in zip(mine, cells, strict=True)))
        if fabric[number - 1]:
            rows = [whole(int(k) + 1, *(begin + 3 * int(k) + c for c in (1, 2, 3))) for k in mine]
            deck.add(f"EREF/SH3N/{number}", "cut\n", *rows)
    for number, name in enumerate(surface.part_names, 1):
        deck.add(f"PART/{number}", name + "\n", whole(*[1 if fabric[number - 1] else 2] * 2, 0))
    f = case.fabric
    deck.add(
        "MAT/LAW19/1", "nylon\n", reals(deck.of(f.density, "density")),
        reals(deck.of(f.young_warp, "pressure"), deck.of(f.young_weft, "pressure"), f.poisson),
        reals(*[deck.of(f.shear, "pressure")] * 3), reals(1.0 if f.compression else 0.001, None, 0.0, 0.0),
    )  # fmt: skip
    deck.add("MAT/VOID/2", "nothing\n", reals(deck.of(f.density, "density")))
    flags = whole(4, 4, 2, 0) + reals(0.0, 0.0, 0.0, 0.0, 0.0)
    thick = line((1, 10), (0, 10), (deck.of(f.thickness, "length"), 20), (0.0, 20))
    deck.add("PROP/SH_ORTH/1", "fabric\n", flags, thick, reals(1.0, 0.0, 0.0, 0.0))
    deck.add("PROP/TYPE1/2", "nothing\n", flags, thick)
    deck.add("GRNOD/NODE/5", "fixed\n", *rows_of_ten(np.flatnonzero(shape.fixed) + 1))
    deck.add("BCS/1", "mouth\n", line(("   111 111", 10), (0, 10), (5, 10)))
    parts = list(range(1, len(surface.part_names) + 1))
    vents = [k for k in parts if surface.part_kinds[k - 1] == "vent"]
    deck.add("SURF/PART/1", "bag\n", whole(*parts))
    deck.add("SURF/PART/2", "vents\n", whole(*vents))
    for k, table in enumerate(case.inflators, 1):
        gas = case.gas.species[table.name]
        deck.add(
            f"MAT/GAS/MOLE/{10 + k}", table.name + "\n", reals(deck.of(gas.molar_mass, "molar mass")),
            reals(*(deck.of(v, "molar heat") for v in (gas.a, gas.b, gas.c))),
        )  # fmt: skip
        flow = [deck.of(v, "mass flow") for v in table.mass_flow.value]
        deck.curve(20 + k, "mass flow", [deck.of(t, "time") for t in table.mass_flow.time], flow)
        deck.curve(30 + k, "temperature", [deck.of(t, "time") for t in table.temperature.time], table.temperature.value)
        deck.add(
            f"PROP/INJECT1/{40 + k}", table.name + "\n", line((1, 10), (1, 10), (1.0, 20)),
            line((10 + k, 10), (20 + k, 10), (30 + k, 10), (None, 10), (1.0, 20), (1.0, 20)),
        )  # fmt: skip
    flow, initial = case.bag.vents, case.gas.initial
    deck.add(
        "MONVOL/AIRBAG1/1", "bag\n", line((1, 10), (None, 10), (deck.of(case.gas.heat_transfer, "heat transfer"), 20)),
        reals(1.0, 1.0, 1.0, 1.0, 1.0),
        line((11, 10), (None, 10), (0.0, 20), (deck.of(case.ambient.pressure, "pressure"), 20),
             (initial.temperature, 20), (0, 10), (0, 10)),
        whole(len(case.inflators)), *(whole(40 + k, 0, 0, 0, 0, 0) for k in range(1, len(case.inflators) + 1)),
        whole(1 + len(case.gas.orifices), 0),
        line((2, 10), (1, 10), (flow.discharge, 20), (0.0, 20), (None, 20), ("vents", 20)),
        line((deck.of(flow.burst_time, "time"), 20), (0.0, 20), (deck.of(flow.opening_pressure, "pressure"), 20),
             (0.0, 20), (None, 10), (0, 10)),
        whole(0, 0, 0), whole(0, 0, 0),
        *(line((0, 10), (1, 10), (deck.of(o.area * o.discharge, "area"), 20), (0.0, 20)) + reals(0.0, 0.0, 0.0, 0.0)
          + whole(0, 0, 0) * 2 for o in case.gas.orifices),
    )  # fmt: skip
    plate = case.obstacles[0]
    m = deck.of(plate.height, "length")
    deck.add(
        "RWALL/PLANE/1", plate.name + "\n", whole(0, 2, 0, 0), reals(0.0, plate.friction, 0.0, 0.0),
        reals(0.0, 0.0, m), reals(0.0, 0.0, m + 1.0),
    )  # fmt: skip
    deck.add("INTER/TYPE19/1", "fabric\n", whole(1, 1, 0, None, 0, 0, 0, 0, 0), reals(0.0, 0.0), reals(0.0, 0.0),
             reals(1.0, 0.0, 0.5, 0.0, 0.0), "\n", whole(0, 0))  # fmt: skip
    return str(deck)


def rows_of_ten(ids: np.ndarray) -> list[str]:
    return [whole(*map(int, ids[k : k + 10])) for k in range(0, len(ids), 10)]


ENGINE = "/RUN/bag/1\n                40.\n/ANIM/DT\n    0.    2.\n/TFILE\n    0.4\n"


SMALL = """#RADIOSS STARTER
/BEGIN
four triangles
      2022         0
                  kg                  mm                  ms
                  kg                  mm                  ms
/PARAMETER/GLOBAL/REAL/1
size
size                     300.0
/PARAMETER/GLOBAL/REAL_EXPR/2
twice
half      &size / 2
/UNIT/7
SI
                  kg                   m                   s
/NODE
         1                 0.0                 0.0                 0.0
         2               &size                 0.0                 0.0
# a comment between nodes
$ and another
         3                 0.0              300.D0                 0.0
#include more.inc
/SH3N/3
         1         1         3         2
         2         1         2         4
/SHELL/3
         3         1         4         3         3
         4         2         3         4         4
/PART/3
bag
         3         3         0
/PROP/TYPE9/3
fabric
         4         4         2
                 0.0                 0.0                 0.0                 0.0                 0.0
         1         0                 0.3                 0.0
                 1.0                 0.0                 0.0                30.0
/MAT/FABRI/3/7
nylon
               800.0
               4.0E8               3.5E8                 0.2
               1.0E7               1.0E7               1.0E7
               0.001
/SURF/PART/1
bag
         3
/MAT/GAS/MASS/11
hot gas
               0.028
              1000.0                 0.1
/MAT/GAS/CSTA/12/7
air
              1005.0               718.0
/FUNCT/21
mass
                 0.0                 0.0
                10.0                0.01
                40.0                0.02
/FUNCT/22
temperature
                 0.0                 1.0
               100.0                 1.0
/PROP/INJECT1/31
inflator
         1         0                 1.0
        11        21        22                           1.0               600.0
/SENSOR/TIME/5
fire
                 2.0
/MONVOL/AIRBAG1/1
bag
         1
                 1.0                 1.0                 1.0                 1.0                 1.0
        12                           0.0              1.0E-4               293.0
         1
        31         5
         1         1
         0         1                20.0                 0.0                                    hole
                 0.0                 0.0                 0.0                 0.0
         0         0         0
         0         0         0
         3         0         0
                 0.0                 0.0                 0.0                 0.0
                 0.5                10.0
/RWALL/SPHER/1
head
         0         0
                 0.0                 0.3               165.0
               100.0               100.0               500.0
/GRAV/1
down
         0         Z         0         0         0                           1.0             -9.8E-3
/FUNCT/0
one
                 0.0                 1.0
               100.0                 1.0
/RBODY/1
a body
/END
what follows is not read
"""
MORE = "/NODE\n         4                 0.0                 0.0                 2.&\n"
MORE = MORE.replace("2.&", "300")


def of_two_fabrics() -> str:
    """The small deck, whose quads are of another material."""
    head = SMALL.index("/MAT/FABRI/3/7")
    cloth = SMALL[head : SMALL.index("/SURF/PART/1")]
    stiff = cloth.replace("/MAT/FABRI/3/7", "/MAT/FABRI/4/7").replace("4.0E8", "9.0E8")
    part = "/PART/4\nrear\n         3         4         0\n"
    text = SMALL.replace("/SHELL/3\n", "/SHELL/4\n").replace(cloth, cloth + stiff + part)
    return text.replace("/SURF/PART/1\nbag\n         3\n", "/SURF/PART/1\nbag\n         3         4\n")
