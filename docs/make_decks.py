"""Write docs/decks.md: a guide, and tables of the keywords and fields that are read, from the code that reads them.

`make docs` runs it; a test compares its output with the file and executes the guide's commands.
"""

from __future__ import annotations

from pathlib import Path

from billow.decks import airbag
from billow.decks.fields import ALIASES, CARDS, TARGETS
from billow.decks.radioss.columns import CARDS as RADIOSS
from billow.decks.radioss.columns import TARGETS as RADIOSS_TARGETS
from billow.decks.units import RANGES, SYSTEMS

TARGET = Path(__file__).with_name("decks.md")

GUIDE = """# From your LS-DYNA deck to a running bag in ten minutes

`billow import-deck` reads a keyword file of LS-DYNA, or a starter deck of Radioss (below), and writes a case: the bag's
mesh at the start, its flat cut, curves, `case.toml` with a comment behind each value that says which field it is
from, and a report of **every** field of the airbag, material and contact cards. `billow export-deck` goes the other
way.

## The first run

No deck at hand? Billow writes one from a case:

```
billow check --example > bag.toml
billow export-deck bag.toml --out driver.k --set bag.element_size=0.06
```

From here on, take your own deck in place of `driver.k`.

```
billow import-deck driver.k --out driver
billow check driver/case.toml
billow run driver/case.toml --out driver_run --set run.end_time=0.01
```

Then open `driver/import.md`. It lists each field under one of four words:

| word | meaning |
|---|---|
| mapped | the case says the same; the row has the value in SI and the key of the case |
| approximated | the case says nearly the same; the note says how far |
| ignored | without effect in Billow; the note says why |
| refused | the deck means something that a case cannot say yet; the note says what to do |

A refused field does not stop the import, but the command prints it and ends with exit code 1. `import.json` holds the
same for programs. Keywords that Billow does not read are listed at the end.

## When the command asks

**Units.** No deck says its units. Billow looks for evidence (gas constant, ambient pressure, density, thickness and
modulus of the fabric, size, end time). If all of it fits exactly one system, that is taken; otherwise the command
says what each system would mean and asks: `--units kg-mm-ms`, `t-mm-s`, `kg-m-s`, `g-mm-ms` or `lbf-in-s`.

**Parts.** Parts of *MAT_FABRIC are fabric, rigid parts of the bag its mouth, parts that A23 < 0 or a vent card names
are vents. For others say `--part 7=vent`, `=mouth`, `=fabric` or `=ignore`. Rigid parts that do not belong to the bag
become obstacles; `--part 2=obstacle` and `--part 1=plate` make others obstacles too.

**Open edges.** A bag must be closed. An edge whose nodes all belong to a rigid part beside the bag is closed as the
mouth, one whose nodes all belong to the part that A23 < 0 or a vent card names as that vent. The command lists the
others, the longest first, with place and width; say what closes them: `--close 1=mouth --close 2=vent`. Nodes of a
seam that are there twice are merged: those on open edges that lie within a thousandth of the shortest such edge, or
within `--merge` metres. The command prints the tolerance.

**Normals** may point anywhere: neighbours are made to agree, and the sign of the volume decides. An edge of three
shells is refused with its place and shells.

**Several airbags.** If *AIRBAG_INTERACTION joins them they become chambers of one case, with orifices between them; a
part of both sets is the wall between two, or an opening if the interaction names it and it is no fabric. Otherwise
`--airbag 2` takes the second.

**Several chambers of one *AIRBAG_PARTICLE.** CHM names a *DEFINE_CPM_CHAMBER: the parts of SID1 and SID2 lie around
each chamber, whichever way their normals point, and a part of two chambers is the wall between them. Such a part is an
opening if a vent card or the chamber's own interaction names it; ENH_V 2 is what openings do, which is flow both ways.
CHM_ID of an orifice is the chamber of its inflator. Walls of SID2 without CHM are refused: a bag that lies flat at the
start does not show its chambers.

**A deck of a mesh alone.** What it does not say comes from a case: `--base CASE.toml`, with the bag's parts by
`--part`.

**A mesh of another program**, as STL, OBJ, PLY, VTP, VTU, VTK or VTKHDF, is imported the same way: parts are the
solids or groups of the file, counted from 1. Such files name no units, so `--units` must. Corners of STL facets
become one node where all their bits agree, and on open edges within the tolerance of seams.

**Several fabrics.** The material of most shells is `[fabric]`; each part of another has its own `[fabric.parts.NAME]`.

**Curves of fabric.** A deck does not say whether curves of FORM 4 and 14 hold true, engineering or Green strain:
`--fabric-curves true`, `engineering` or `green`. The report repeats what was taken.

## What is worth knowing

- Walls become plates at any angle. Rigid parts become obstacles of `shape = "mesh"`: their surface, with the mass,
  centre and inertia of *PART_INERTIA or else of their shells. A surface that is open is a sheet as thick as the
  section, at least 2 mm. `--part 3=plate` makes an infinite plate of a part.
- *BOUNDARY_PRESCRIBED_MOTION of a rigid part, or of its nodes, moves the obstacle along a line: velocity as `speed`,
  displacement as `travel`, acceleration by its integral, which is exact where the acceleration is constant. Axes that
  share a curve make one direction. Curves of zeros hold parts, and nodes of the bag. Walls of *RIGIDWALL_..._MOTION
  and _MOVING move too; a rigid part that *MAT_RIGID leaves one axis is `guided`, with the force of *LOAD_RIGID_BODY.
  Rotations are refused.
- Nodes of the bag that *NODE.TC, *BOUNDARY_SPC or curves of zeros hold along x, y or z become `bag.fixed_nodes`, or
  groups of `[[nodes]]`; those with a motion become groups that move along their line and yield across it (DOF -4: that
  do not). Nodes of the mouth do not move, because jets come from there.
- *INITIAL_VELOCITY, _NODE and _GENERATION throw nodes of the bag (`[[nodes]]`), and rigid parts whose nodes they name
  all. A later card counts before an earlier one, a node's before those of sets, *INITIAL_VELOCITY_RIGID_BODY before
  all; that of *PART_INERTIA is kept unless IRIGID resets it.
- Beams (truss, cable), springs and seat belts whose both ends are nodes of the bag become `bag.straps`, which pull
  and never push; others are left out with a word.
- Each gas of *AIRBAG_HYBRID becomes an inflator of one species, because each has its own mass flow and temperature.
- If CP - CV is no gas constant of a gas, which decks in inches and pounds often have, the flow of enthalpy and the
  ratio of heats are kept, with the molar mass of nitrogen. The report says so.
- One keyword switches from uniform pressure to particles or to a mesh: *AIRBAG_HYBRID, *AIRBAG_PARTICLE or *AIRBAG_ALE;
  in a case it is `gas.model`. Cells are cubes of the mean volume of the deck's. *AIRBAG_ADVANCED_ALE is read by the
  *DEFINE_ALEBAG_BAG, _HOLE and _INFLATOR that belong to it; its own columns are refused one by one, so say
  `ambient`, `gas.initial` and `gas.cell` yourself.
- *AIRBAG_ADIABATIC_GAS_MODEL and _SIMPLE_PRESSURE_VOLUME inject nothing: their inflator has a delay of 10 s. The second
  says a gauge pressure; a gas of gamma 1.008 in surroundings of 1 kPa comes close, and the report says how close.
- The jet of HYBRID_JETTING and WANG_NEFSKE_JETTING is taken if it comes out of the mouth within 10 degrees of its axis.
- Files are included from the deck's folder and below; `--allow-outside` allows others. A deck has at most 2 GB,
  includes are at most 16 deep, and expressions of *PARAMETER_EXPRESSION are plain arithmetic.

## The way out

```
billow export-deck driver/case.toml --out again.k --units t-mm-s
```

The deck is in LONG format, so that nothing is rounded: imported again it gives the same bits of the mesh in every
metric system, and every number to 1e-6. Folded bags are written as they lie, with their flat cut; shells whose layers
vary, beside seams, with a thickness of their own. Straps become seat belts; those that pull at the start,
springs. Bodies other than balls become rigid shells of triangles, housings one for each of their boxes. The command
lists what a deck cannot hold: jets of uniform pressure, mixtures and heats of gases beyond A + B T + C T^2, the tension
at which a strap tears. Chambers get parts of their own and become airbags that *AIRBAG_INTERACTION joins, or, with
particles, chambers of *DEFINE_CPM_CHAMBER. Normals point out of the bag, with particles in one chamber into it, as
*AIRBAG_PARTICLE wants them. Refused are bags with covers or seams that tear or that come to rest first,
and, with particles in several chambers, mouths in two of them and inflators without jets away from the mouth.

Results go the other way, too: `billow export-d3plot RUN --out d3plot` writes positions and velocities of all frames as
a d3plot, with the extra `dyna` (pip install 'billow[dyna]'). Its parts are numbered; the command says which is which.

## From a deck of Radioss

`billow import-deck NAME_0000.rad --out bag` reads a starter deck (block format, version 5.1 or later) the same way, by
its first lines. Units are those of `/BEGIN` and `/UNIT`; the end of the run and its frames come from `NAME_0001.rad`
beside it. What differs from decks of LS-DYNA:

- A part of the bag is fabric if it has LAW19 or LAW58, a vent if `surf_IDv` names it, the mouth if `/BCS` holds all its
  nodes. Say others by `--part`.
- Each gas of `/PROP/INJECT1` becomes an inflator. A mass against time (Iflow 0) becomes its slopes.
- A vent opens at dPdef, or at Tstart at the latest; with Tstart 0 it is open from the start, whatever dPdef says.
- LAW19 is linear in Green strain in a case; LAW58 has straight lines or functions, in the measure of `--fabric-curves`,
  and no crimp that couples warp and weft. Damping is Billow's own.
- `/XREF` is the flat cut of each part by nodes, `/EREF` by elements.
- Volumes of `/MONVOL/COMMU1` become chambers of one case, with orifices between them.
- The material of most shells is `[fabric]`; each part of another has its own `[fabric.parts.NAME]`.
- `/RBODY` becomes an obstacle of the shells that belong to it alone, with the mass of its shells and of its main node
  (ICoG); `/BCS` of the main node locks or guides it, `/IMPDISP`, `/IMPVEL` and `/IMPACC` along X, Y or Z move it. Parts
  that stand still are obstacles, too. A body that shares nodes with the bag holds or moves them, and is no obstacle.
- `/INIVEL/TRA` and `/AXIS` throw bodies and nodes of the bag; `/BCS` and motions of nodes become `[[nodes]]`.
- Not read: the other volumes, `/LEAK/MAT`, sensors other than TIME, skews and frames. They are listed, and the mesh of
  such a deck can be taken alone, with `--part` and `--base`.
"""

BESIDES = """Besides: *NODE, *ELEMENT_SHELL (_THICKNESS, _BETA), *ELEMENT_BEAM, *ELEMENT_DISCRETE and *ELEMENT_SEATBELT
with *MAT_SPRING_ELASTIC, *MAT_CABLE_DISCRETE_BEAM, *MAT_SEATBELT or *MAT_ELASTIC, *PART, *SECTION_SHELL, *SECTION_BEAM,
*SET_PART, *SET_NODE, *SET_SEGMENT, *DEFINE_CURVE, *DEFINE_VECTOR, *AIRBAG_REFERENCE_GEOMETRY,
*AIRBAG_SHELL_REFERENCE_GEOMETRY, *INCLUDE and *PARAMETER."""


RADIOSS_BESIDES = """Besides: /NODE, /SHELL, /SH3N, /PART, /SUBSET, /SURF (PART, SUBSET, MAT, PROP, SEG, SURF, GRSHEL,
GRSH3N), /GRSHEL and /GRSH3N (SHEL, SH3N, PART, SUBSET, MAT, PROP, GENE, groups), /GRNOD (NODE, PART, SUBSET, MAT, PROP,
SURF, GRSHEL, GRSH3N, GENE, GEN_INCR, GRNOD), /FUNCT, /FUNCT_SMOOTH, /MOVE_FUNCT, /XREF, /EREF, /PARAMETER and
#include."""


def render() -> str:
    """The whole page."""
    lines = [GUIDE, "## Units", "", "| system | mass | length | time |", "|---|---|---|---|"]
    lines += [f"| `{u.name}` | {u.mass:.9g} kg | {u.length:g} m | {u.time:g} s |" for u in SYSTEMS.values()]
    lines += ["", "A system passes if the SI value of each piece of evidence lies in its range:", ""]
    lines += ["| evidence | from | to | unit |", "|---|---|---|---|"]
    lines += [f"| {kind} | {low:g} | {high:g} | {unit} |" for kind, (_, low, high, unit) in RANGES.items()]
    lines += ["", "## Keywords and fields", "", "Columns of each card, in their order; a dot is one that is not used."]
    others = {name: [alias for alias, meant in ALIASES.items() if meant == name] for name in CARDS}
    for keyword, cards in CARDS.items():
        also = f" (also {', '.join(f'*{alias}' for alias in others[keyword])})" if others[keyword] else ""
        lines += ["", f"### *{keyword}{also}", "", "| card | columns |", "|---|---|"]
        lines += [f"| {card} | {columns} |" for card, columns in cards.items()]
    lines += ["", BESIDES]
    lines += [
        "",
        "## Keywords and fields of Radioss",
        "",
        "Columns are 10 characters wide, or as many as stand behind a colon.",
    ]
    for keyword, cards in RADIOSS.items():
        lines += ["", f"### /{keyword}", "", "| card | columns |", "|---|---|"]
        lines += [f"| {card} | {columns} |" for card, columns in cards.items()]
    lines += ["", RADIOSS_BESIDES]
    lines += ["", "## Airbags that are refused by name", "", "| keyword | because |", "|---|---|"]
    lines += [f"| *{name} | {why} |" for name, why in airbag.WHY_NOT.items()]
    lines += ["", "## Where fields go", "", "| field | key of the case |", "|---|---|"]
    lines += [f"| {name} | `{key}` |" for name, key in sorted((TARGETS | RADIOSS_TARGETS).items())]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    TARGET.write_text(render(), encoding="utf-8")
