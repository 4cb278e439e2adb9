"""Decks of LS-DYNA and Radioss, damaged: each is imported or refused with its file and, if there is one, the line."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from random import Random

from billow.base.errors import InputError
from billow.case.schema import Case
from billow.decks.export_deck import deck_of
from billow.decks.import_deck import Options, import_deck
from trust.fuzz_inputs import Attempt, Bench
from trust.mutations import mutate_bytes

TETRAHEDRON = """*KEYWORD
*TITLE
a bag of four triangles
*PARAMETER
R size         300.0I bag              3
*PARAMETER_EXPRESSION
R half    size/2+sqrt(4)-2
*NODE
       1             0.0             0.0             0.0
       2           300.0             0.0             0.0
       3             0.0           300.0             0.0
       4             0.0             0.0           300.0
*NODE
11,&half,0,400
12,200,0,400
13,150,100,400
14,150,0,500
*ELEMENT_SHELL
       1       3       1       3       2       2
       2       3       1       2       4       4
       3       3       1       4       3       3
       4       3       2       3       4       4
      11       9      11      13      12      12
      12       9      11      12      14      14
*PART
bag
         3         3         3
box
         9         9         9
*SECTION_SHELL
         3         9
       0.3       0.3       0.3       0.3
         9         2
       1.0       1.0       1.0       1.0
*SET_PART_LIST
         1
      &bag
*MAT_FABRIC
         3    8.0E-7       0.4      0.35                 0.2
      0.01                           1.0                           0.05
       2.0      0.02       0.5       0.0         0       -14         1
                 0.0                 1.0
       0.0       0.0       0.0                          30.0         1
         4         4         4
         0
*MAT_RIGID
         9    7.8E-6     210.0       0.3
*DEFINE_CURVE
         1
                 0.0                 0.0
                10.0              1.0E-3
                40.0                 0.0
*DEFINE_CURVE
         2
                 0.0               600.0
               100.0               500.0
*DEFINE_CURVE
         4
                 0.0                 0.0
                 0.2                0.02
*AIRBAG_HYBRID
         1         1
     293.0   1.01E-4               8.314       1.0
       0.7               20.0
         0                   2
         1         2             0.028       1.0      29.0     1.E-3

         1         2             0.018                33.0

*AIRBAG_SHELL_REFERENCE_GEOMETRY
       1       3       1       3       2       2
*RIGIDWALL_PLANAR
         0
       0.0       0.0    -100.0       0.0       0.0       0.0       0.3
*INITIAL_VELOCITY_GENERATION
         9         2      0.01       0.0       0.0      -2.0
     100.0       0.0       0.0       0.0       1.0       1.0
*INITIAL_VELOCITY
        78         0         0         0         0
       1.0       0.0       2.0
*INITIAL_VELOCITY_NODE
         2       0.0       0.0       3.0
*SET_NODE_LIST
        78
         1         2
*BOUNDARY_SPC_SET
        78         0         1         0         1
*BOUNDARY_SPC_NODE_BIRTH_DEATH
         3         0         0         1
       0.0    1.0E20
*BOUNDARY_PRESCRIBED_MOTION_SET
        78         2         0         5       0.1
        78        -4         2         5       0.1         6
*DEFINE_VECTOR
         6       0.0       0.0       0.0       0.0       1.0       1.0
*DEFINE_CURVE
         5
                 0.0                 0.0
                10.0                 2.0
*CONTACT_AIRBAG_SINGLE_SURFACE
         1
      0.25
       0.0
*INCLUDE
more.k
*CONTROL_TERMINATION
      40.0
*DATABASE_BINARY_D3PLOT
       1.0
*END
"""
MORE = "*SET_SEGMENT\n         7\n         1         3         2         2\n"
STARTER = """#RADIOSS STARTER
/BEGIN
four triangles
      2022         0
                  kg                  mm                  ms
/PARAMETER/GLOBAL/REAL_EXPR/1
size
size      sqrt(9) * 100
/UNIT/7
SI
                  kg                   m                   s
/NODE
         1                 0.0                 0.0                 0.0
         2               &size                 0.0                 0.0
         3                 0.0              300.D0                 0.0
         4                 0.0                 0.0                 300
#include more.inc
/SH3N/3
         1         1         3         2
         2         1         2         4
/SHELL/3
         3         1         4         3         3
/SH3N/4
         4         2         3         4
/PART/3
bag
         3         3         0
/PART/4
vent
         3         4         8
/PROP/TYPE9/3
fabric
         4         4         2
                 0.0                 0.0                 0.0                 0.0                 0.0
         1         0                 0.3                 0.0
                 1.0                 0.0                 0.0                30.0
/MAT/LAW58/3/7
nylon
               800.0
               4.0E8                 0.0               3.5E8                 0.0                0.01
               1.0E7                 0.0                 0.0                 0.0                   0
                 0.0                 0.0                 0.0                 0.0                 0.0
         1         1                 0.1                 0.1
        23                           1.0
/MAT/VOID/4
nothing
/SURF/PART/1
bag
         3         4
/SURF/SURF/2
vents
         5
/SURF/GRSH3N/5
vent
         6
/GRSH3N/GENE/6
vent
         4         4
/SUBSET/7
all
         8
/GRNOD/SUBSET/11
all
         7
/GRSHEL/SHEL/3
quads
         3
/FUNCT_SMOOTH/25
soft
                 0.0                 2.0                 0.0                 0.0
                 0.0                 0.0
                10.0                 1.0
/MAT/GAS/MASS/11
hot gas
               0.028
              1000.0                 0.1              1.0E-5              1.0E-8
/MAT/GAS/PREDEF/12
air
AIR
/FUNCT/21
mass
                 0.0                 0.0
                10.0                0.01
                40.0                0.02
/FUNCT/22
temperature
                 0.0                 1.0
               100.0                 1.0
/FUNCT/23
warp
                 0.0                 0.0
                 0.2               2.0E7
/FUNCT/24
one
                 0.0                 1.0
               100.0                 1.0
/MOVE_FUNCT/22
moved
                 1.0               600.0
/PROP/INJECT1/31
inflator
         1         0                 1.0
        11        21        22                           1.0                 1.0
/SENSOR/TIME/5
fire
                 2.0
/MONVOL/AIRBAG1/1
bag
         1                           0.0
                 1.0                 1.0                 1.0                 1.0                 1.0
        12                           0.0              1.0E-4               293.0
         1
        31         5
         2         1
         0         1                20.0                 0.0                                    hole
                 0.0                 0.0                 0.0                 0.0
         0         0         0
         0         0         0
         2         1                 0.7                 0.1                                    vent
                10.0                 0.0              2.0E-5                 0.0
        24         0         0                           0.9
         0         0         0
         3         0         0
                 0.0                 0.0                 0.0                 0.0
                 0.5                10.0
/GRNOD/NODE/5
fixed
         1         2
/BCS/1
held
   111 111         0         5
/RWALL/CYL/1
pole
         0         2
                 0.0                 0.3               165.0
               100.0               100.0               500.0
               100.0               200.0               500.0
/INTER/TYPE7/1
fabric
         5         1         4         0         1         0         1
                 1.0                 1.0
                 0.0                 0.0
                 1.0                 0.2                 0.5
/XREF/3
flat
         0
         1                 0.0                 0.0                 0.0
         2               310.0                 0.0                 0.0
/GRNOD/NODE/6
main
        15
/GRNOD/NODE/7
corners
        12        13        14
/GRNOD/NODE/8
of the bag
         1         2
/NODE
        12               100.0               100.0               500.0
        13               200.0               100.0               500.0
        14               100.0               200.0               500.0
        15               120.0               120.0               520.0
/SH3N/9
         9        12        13        14
/PART/9
plate
         9         9         0
/PROP/TYPE1/9
sheet
         0         0         0
                 0.0                 0.0                 0.0                 0.0                 0.0
         1         0                 1.0
/MAT/ELAST/9
steel
              7.8E-6
               210.0                 0.3
/RBODY/5
body
        15         0         0         0                 1.0         7         0         3         0
              1000.0              1000.0              2000.0
                 0.0                 0.0                 0.0
         0         0         0
/INIVEL/AXIS/1
turn
         Z         0         7
                 0.0                 0.0                -2.0                 0.1
/INIVEL/TRA/2
throw
                 0.0                 1.0                 2.0         8         0
                 0.0         0
/IMPVEL/3
push
        25         Y         0         0         8         0         0
                 1.0                 0.5                 0.0              1.0E30
/BCS/9
rail
   001 000         0         8
/GRAV/1
down
        24         Z         0         0         0                           1.0             -9.8E-3
/END
"""
HYBRID = TETRAHEDRON[TETRAHEDRON.index("*AIRBAG_HYBRID") : TETRAHEDRON.index("*AIRBAG_SHELL_REFERENCE")]
SOURCES = """*DEFINE_VECTOR
11,0,0,0,0,0,1
*NODE
21,130,100,10
22,70,100,10
23,100,130,10
*DEFINE_CURVE
6
0,0.5
100,0.5
"""
AIRBAGS = [
    """*AIRBAG_PARTICLE_MPP_MOLEFRACTION_TIME_ID
2,1,1
7,a bag
0,1e20
1,1,0,0,2,1,0,0
5000,0,1,293,1.01e-4,0,40,1e10
+1e10,1,0.1
1,2,3
3,0,1e-6
1.01e-4,293,0.029,29,0,0
1
6,2,0.028,29,0,0,1
6,2,0.044,37,0,0,1
21,12.5,11,,1
22,12.5,11,,1
23,12.5,11,30,1
""",
    """*AIRBAG_WANG_NEFSKE_JETTING_POP_CM
1,1
718,1005,600,2,1
0.7,,20,,0.1,,3
1.01e-4,1.2e-9,1,0,2e-6,5e-5

3,0,0,9,9,1,0,7
100,100,0,100,100,10,0.3,1
0,0,0,0,0
1
""",
    """*AIRBAG_WANG_NEFSKE_MULTIPLE_JETTING
1,1
0,0,600,0,1
0,6,20
1.01e-4,1.2e-9,1

293,29,1e-3,0.028,8.314,0
100,100,0,100,100,10,6,1
0,0,0,0,0
""",
    """*AIRBAG_ALE
1,1,,,,,0,0
293,1.01e-4,,8.314,1,0,0
4,4,0.1,0.1,0.3,0,2,0.1
0,0,0,0
10,10,10,0,1
-100,-100,-100,400,-100,-100
-100,400,-100,-100,-100,400
15,,0.1,1,1,3,0,2
,,,0.028,1,29,0,0
1,,,0.03,,31,1e-3,0
21,11,12.5
22,11,12.5
23,11,12.5
""",
    """*AIRBAG_ADVANCED_ALE
1,1,1
293,1.01e-4
*DEFINE_ALEBAG_BAG_TITLE
the bag
1,1,PSET,YES,1,0.6,0,1
4,4,0.1,0.1,0.3,0,2,0.1
0,0,1e10
*DEFINE_ALEBAG_HOLE
5,3,1,1,0,0,0,1
*DEFINE_ALEBAG_INFLATOR
2,,,,1,3,0,2
1,,,0.03,,31,1e-3,0
21,11,12.5
22,11,12.5
23,11,12.5
""",
    "*AIRBAG_SIMPLE_AIRBAG_MODEL\n1,1\n718,1005,600,1,0.7,20,1.01e-4,1.2e-9\n",
    "*AIRBAG_ADIABATIC_GAS_MODEL\n1,1\n1,0,1.4,2e-5,1.01e-4,1.2e-9\n",
    "*AIRBAG_SIMPLE_PRESSURE_VOLUME\n1,1\n1e-5,2,0,0\n",
]
"""Other gases of the same bag."""
BELTS = """*ELEMENT_SEATBELT
1,8,2,3,0,7.0
*ELEMENT_DISCRETE
1,7,1,4,0,1.0,0,5.0
*PART
belt
8,8,8
spring
7,7,7
*MAT_SEATBELT
8,6e-5,5
*MAT_SPRING_ELASTIC
7,0.01
*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_MPP_ID
4
0,200
&,0,1,0
1,2,3,3
0.35,0.35
1,1
*RIGIDWALL_GEOMETRIC_CYLINDER_MOTION
0
30,30,900,30,30,1200,0.1
100,300,1
50,20
5,1,0,0,-1
"""
INCLUDED = "/SURF/SEG/9\nmore\n         1         1         3         2\n"
FIELDS = [
    *("", "0", "-1", "1", "3", "7", "nan", "1e999", "1.5D+3", "1.2-5", "&size", "&none", "x", "1" * 300, "\x00", "é"),
]
"""What a column is replaced by."""
LINES = [
    *("*END", "*NODE", "$", "", "*KEYWORD LONG=Y", "*INCLUDE\nbag.k", "*INCLUDE\n/etc/passwd", "1,2,3"),
    *("/END", "/NODE", "#include more.inc", "/UNIT/1", "/MONVOL/AIRBAG1/1", "/PARAMETER/GLOBAL/REAL/9"),
    *("*SET_PART_ADD", "*AIRBAG_PARTICLE", "*PARAMETER_EXPRESSION\nR x       (" + "(" * 400, "*" + "A" * 5000),
]
"""What is put between lines."""
UNNUMBERED = {"E-DCK-001", "E-DCK-009", "E-DCK-017", "E-DCK-160"}
"""Codes of errors that are of the whole deck, or say the line otherwise."""


class NoLineNamed(Exception):
    """A message that names no line."""


def decks(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Decks in standard and LONG format, of all kinds of airbag."""
    place = bench.place / "decks"
    place.mkdir()
    (place / "more.k").write_text(MORE)
    kinds = [TETRAHEDRON.replace(HYBRID, gas + SOURCES + BELTS) for gas in AIRBAGS]
    sound = [TETRAHEDRON]
    for gas in ("uniform-pressure", "corpuscular"):
        bag = {"element_size": 0.1, "diameter": 0.5, "straps": {"count": 0}, "vents": {"count": 1}}
        case = Case.from_dict({"bag": bag, "gas": {"model": gas}, "fabric": {"permeability": 0.1}})
        sound.append(deck_of(case, "kg-mm-ms")[0])
    path = place / "bag.k"
    for number in range(count):
        text = (
            (kinds[number // 4 % len(kinds)] if number % 4 == 3 else sound[0])
            if number % 2
            else sound[1 + number // 2 % 2]
        )
        data = _damaged(text, random)
        path.write_bytes(data)
        options = Options(
            units=random.choice(["auto", "auto", "kg-mm-ms", "lbf-in-s"]),
            parts=random.choice([{}, {}, {3: "fabric"}, {9: "plate"}, {9: "obstacle"}, {4: "ignore"}]),
            close=random.choice([{}, {0: "mouth"}, {0: "vent"}]),
            measure=random.choice(["true", "engineering", "green"]),
        )
        attempt(lambda options=options: _imported(path, options), data, "bag.k")


def starters(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Starter decks of Radioss."""
    place = bench.place / "starters"
    place.mkdir()
    (place / "more.inc").write_text(INCLUDED)
    path = place / "bag_0000.rad"
    for _ in range(count):
        data = _damaged(STARTER, random)
        path.write_bytes(data)
        options = Options(
            units=random.choice(["auto", "auto", "kg-mm-ms"]),
            parts=random.choice([{}, {}, {3: "fabric"}, {4: "mouth"}, {4: "ignore"}]),
            close=random.choice([{}, {0: "mouth"}, {0: "vent"}]),
            measure=random.choice(["true", "engineering", "green"]),
        )
        attempt(lambda options=options: _imported(path, options), data, "bag_0000.rad")


def _imported(path: Path, options: Options) -> None:
    out = path.parent / "case"
    try:
        import_deck(path, out, options)
    except InputError as error:
        of_a_line = error.code.startswith("E-DCK") and error.code not in UNNUMBERED
        if of_a_line and not re.search(r"\.(k|rad|inc):\d+", str(error)):
            raise NoLineNamed(str(error)) from None
        raise
    finally:
        shutil.rmtree(out, ignore_errors=True)


def _damaged(text: str, random: Random) -> bytes:
    if random.random() < 0.15:
        return mutate_bytes(text.encode(), random)
    for _ in range(random.randint(1, 3)):
        lines = text.split("\n")
        at = random.randrange(len(lines))
        match random.randrange(7):
            case 0:
                del lines[at]
            case 1:
                lines.insert(at, random.choice(LINES))
            case 2:
                lines[at] = lines[at][: random.randrange(len(lines[at]) + 1)]
            case 3:
                begin = 10 * random.randrange(8)
                cell = random.choice(FIELDS).rjust(10)
                lines[at] = lines[at].ljust(begin)[:begin] + cell + lines[at][begin + 10 :]
            case 4:
                other = random.randrange(len(lines))
                lines[at], lines[other] = lines[other], lines[at]
            case 5:
                end = min(len(lines), at + random.randrange(1, 40))
                lines[at:end] = lines[at:end] * random.choice([0, 2])
            case _:
                lines[at] = ",".join(lines[at].split())
        text = "\n".join(lines)
    return text.encode("latin-1", "replace")
