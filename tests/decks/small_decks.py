"""Small decks of our own, each of one form or one keyword, with known truth: name -> text. Nothing is from others."""

from __future__ import annotations

DECKS: dict[str, str] = {}
HEAD, END = "*KEYWORD\n", "*END\n"


def row(*values, width: int = 10) -> str:
    """A card: columns of one width, None for a blank one."""
    out = ""
    for value in values:
        text = "" if value is None else str(value)
        digits = width
        while len(text) > width:
            text, digits = f"{value:.{digits}g}", digits - 1
        out += text.rjust(width)
    return out + "\n"


def curve(number: int, points, sfa: float = 1.0, sfo: float = 1.0) -> str:
    rows = "".join(f"{a:20.8E}{b:20.8E}\n" for a, b in points)
    return "*DEFINE_CURVE\n" + row(number, 0, sfa, sfo, 0.0, 0.0) + rows


def add(name: str, *texts: str, head: str = HEAD) -> None:
    DECKS[name] = head + "".join(texts) + END


# Airbags
CORE = row(1, 1, 0, 1.0, 1.0, 0.0, 0.0, 0.0)
HYBRID = (
    row(293.0, 1.0e-4, 1.2e-9, 8.314, 1.0, 0.0)
    + row(0.7, None, 1.0e-3, None, 0.0, None, 0.0, None)
    + row(0, 0.0, 3, 0, 0, 0)
    + (row(101, 102, None, 0.028, 0.45, 29.0, 1.0e-3, 0.0) + "\n")
    + (row(103, 102, None, 0.018, 0.30, 30.0, 1.0e-2, 0.0) + "\n")
    + (row(104, 102, None, 0.044, 0.25, 24.0, 4.0e-2, -2.0e-5) + "\n")
)
add("hybrid", "*AIRBAG_HYBRID\n", CORE, HYBRID)
add("hybrid_id", "*AIRBAG_HYBRID_ID\n       7driver bag\n", CORE, HYBRID)
WANG_NEFSKE = (
    row(718.0, 1005.0, 600.0, 11, 12, 0.0, 0, 0)
    + row(0.7, None, 1.2e-3, None, 0.0, None, 0.0, None)
    + row(1.013e5, 1.2, 1.0, 0, 0.0, 0.0, 0.0, 0.0)
)
add("wang", "*AIRBAG_WANG_NEFSKE\n", CORE, WANG_NEFSKE)
PARTICLE = (
    row(1, 1, 0, 0, 0, 0, 0.0, 0) + row(100000, 1, 1, 293.0, 1.01325e5, 2, 0.05, 0.03),
    "+" + row(1.0e10, 1.0, 0.1, None, 0, 0, 0.0, 1.0)[1:],
    row(1, 2, 3, 0, 0, 0, 0, 0.0)
    + row(21, 0, 0.7, 0, 0, 0, 0.0)
    + row(22, 0, 0.6, 0, 0, 0, 0.0)
    + row(1.01325e5, 293.0, 0.0288, 28.0, 0.0, 0.0, 0, 0)
    + row(101, 102, 0.028, 29.0, 1.0e-3, 0.0, 1)
    + row(103, 102, 0.044, 24.0, 4.0e-2, -2.0e-5, 1)
    + "".join(row(node, 1.0e-5, 1, 30.0, 1) for node in (1001, 1002, 1003)),
)
add("particle", "*AIRBAG_PARTICLE\n", *PARTICLE)
add("particle4", "*AIRBAG_PARTICLE\n", PARTICLE[0], PARTICLE[2])
REFERENCE = "".join(f"{i:8d}{0.1 * i:16.8f}{0.2 * i:16.8f}{0.0:16.8f}\n" for i in range(1, 6))
add("refgeo", "*AIRBAG_REFERENCE_GEOMETRY\n", REFERENCE)
add("refgeo_birth", "*AIRBAG_REFERENCE_GEOMETRY_BIRTH\n", row(2.0e-3), REFERENCE)
add(
    "shellref",
    "*AIRBAG_SHELL_REFERENCE_GEOMETRY\n",
    *(row(i, 3, 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4, width=8) for i in range(1, 6)),
)

# Fabric
ELASTIC = row(5, 8.0e-7, 0.4, 0.35, None, 0.2, 0.175)
SHEAR = row(0.01, None, None, 0.0, 0.06, 0.35, 0.1, 0.05)
AXES = row(None, 0.0, 0, 0.0, 0.0, 0.0, 0.0, 1.0) + row(None, None, None, 0.0, 0.0, 0.0, 30.0, 1)
CURVES = row(31, 32, 33, 41, 42, 43, 0.5)


def fabric(form: int, elastic: str = ELASTIC) -> str:
    cards = elastic + SHEAR + row(0.0, 0.02, 1.0, 0.0, 0.0, form, 7, 0.0) + AXES
    if form in (4, 14, -14):
        cards += CURVES
    return cards + (row(34, 35, 0.0, 0, None, 0.1, 0.01, -0.07) if form == -14 else "")


add("fabric0", "*MAT_FABRIC\n", fabric(0))
add("fabric_num", "*MAT_034\n", fabric(0))
add("fabric14", "*MAT_FABRIC_TITLE\nnylon 470\n", fabric(14))
add("fabric14m", "*MAT_FABRIC\n", fabric(-14))
OTHER = row(6, 8.0e-7, 0.4, 0.35, None, 0.2, 0.175)
add("two_mats", "*MAT_FABRIC\n", fabric(0), "*MAT_FABRIC\n", fabric(14, OTHER))
add("poroleak", "*MAT_ADD_AIRBAG_POROSITY_LEAKAGE\n", row(5, 0.02, 1.0, 0.0, 7, 0.0, 1.0))

# Curves
POINTS = [(0, 0), (1, 2), (3, 4)]
add("curve", curve(9, POINTS, 2.0, 3.0))
add("curve_sf0", curve(9, POINTS, 0.0, 0.0))
add("curve_sfblank", "*DEFINE_CURVE_TITLE\nmass flow\n", row(9, 0), *(f"{a:20.8E}{b:20.8E}\n" for a, b in POINTS))


# Nodes in all forms
def nodes(count: int, form: str) -> str:
    return "".join(
        form.format(i=i, x=f"{0.5 * i:.9E}", y=f"{0.25 * i:.9E}", z=f"{-1.0 * i:.9E}") for i in range(1, count + 1)
    )


STANDARD = "{i:8d}{x:>16s}{y:>16s}{z:>16s}       0       7\n"
WIDE = "{i:20d}{x:>20s}{y:>20s}{z:>20s}" + "0".rjust(20) + "7".rjust(20) + "\n"
TEN = "{i:10d}{x:>16s}{y:>16s}{z:>16s}         0         7\n"
SIX = nodes(6, STANDARD)
add("node8_16", "*NODE\n", SIX)
first, others = SIX.split("\n", 1)
add("node_comment", "*NODE\n$  nid x\n", first, "\n$ in the middle\n", others)
add("node_short", "*NODE\n", nodes(3, "{i:8d}{x:>16s}\n"))
add(
    "node_glued",
    "*NODE\n",
    *(f"{i + 12345670:8d}{-0.5 * i:16.9E}{-1.123456789e-05:16.9E}{-1.0 * i:16.9E}\n" for i in range(1, 4)),
)
add("node_comma", "*NODE\n", nodes(3, "{i},{x},{y},{z}\n"))
add("node_long", "*NODE\n", nodes(3, WIDE), head="*KEYWORD LONG=Y\n")
add("node_plus", "*NODE +\n", nodes(3, WIDE))
add("node_i10", "*NODE\n", nodes(3, TEN), head="*KEYWORD I10=Y\n")
add("node_pct", "*NODE %\n", nodes(3, TEN))
add("node_fortran", "*NODE\n", *(f"{i:8d}{'1.5D+3':>16s}{'1.234-5':>16s}{'-2.E0':>16s}\n" for i in range(1, 4)))
DECKS["node_lower"] = "*keyword\n*node\n" + SIX.lower() + "*end\n"
DECKS["node_crlf"] = (HEAD + "*NODE\n" + SIX + END).replace("\n", "\r\n")

# Shells
SHELLS = "".join(row(i, 3, i, i + 1, i + 2, i + 2 if i % 2 else i + 3, width=8) for i in range(1, 6))
THICK = "".join(
    row(i, 3, i, i + 1, i + 2, i + 3, width=8) + "".join(f"{0.3:16.6E}" for _ in range(4)) + f"{30.0 * i:16.6E}\n"
    for i in range(1, 4)
)
add("shell", "*ELEMENT_SHELL\n", SHELLS)
add("shell_thick", "*ELEMENT_SHELL_THICKNESS\n", THICK)
add("shell_beta", "*ELEMENT_SHELL_BETA\n", THICK)
FURTHER = "".join(row(i + 100, 4, i, i + 1, i + 2, i + 3, width=8) for i in range(1, 6))
add("shell_two", "*ELEMENT_SHELL\n", SHELLS, "*ELEMENT_SHELL\n", FURTHER)

# Sets, parts, sections, parameters, includes
HEAD_OF_SET = row(0.0, 0.0, 0.0, 0.0)
add("setpart", "*SET_PART_LIST_TITLE\nbag\n", row(1, 0.0, 0.0), row(1, 2, 3, 4, 5, 6, 7, 8), row(9, 10))
add("setnode", "*SET_NODE_LIST\n", row(4, 0.0, 0.0), row(1, 2, 3, 4, 5, 6, 7, 8), row(9, 10, 11))
add("setseg", "*SET_SEGMENT\n", row(2, 0.0), *(row(i, i + 1, i + 2, i + 3, 0.0, 0.0) for i in range(1, 4)))
add("setgen", "*SET_NODE_LIST_GENERATE\n", row(4, 0.0), row(1, 10, 21, 25))
add("part2", "*PART\nplate\n", row(1, 11, 21, 0, 0, 0, 0, 0), "bag\n", row(3, 13, 23, 0, 0, 0, 0, 0))
SECTION = row(13, 9, 1.0, 3, 1.0, 0, 0, 1)
add("section", "*SECTION_SHELL_TITLE\nfabric\n", SECTION, row(0.3, 0.3, 0.3, 0.3))
add(
    "param",
    "*PARAMETER\nR thick         0.25I nid            12\n*PARAMETER_EXPRESSION\nR  dbl    2*thick\n*SECTION_SHELL\n",
    SECTION,
    "&thick    &thick    &dbl      &dbl          0.0\n",
)
add("include_main", "*INCLUDE\nnode8_16.k\n*ELEMENT_SHELL\n", SHELLS)
add(
    "include_tr",
    "*INCLUDE_TRANSFORM\nnode8_16.k\n",
    row(1000, 0, 0, 0, 0, 0, 0) + row(0) + row(1.0, 0.001, 1.0, 1.0, 0) + row(0),
)

# Contact, walls, motion
add(
    "contact",
    "*CONTACT_AIRBAG_SINGLE_SURFACE_ID\n         1self\n",
    row(1, 0, 2, 0, 0, 0, 0, 0) + row(0.25, 0.2, 0.0, 0.0, 20.0, 0, 0.0, 1.0e20) + row(*[1.0] * 8),
)
add(
    "rigidwall",
    "*RIGIDWALL_PLANAR_ID\n         1wall\n",
    row(0, 0, 0, 0.0, 0.0) + row(0.0, 0.0, -1.0, 0.0, 0.0, 5.0, 0.2),
)
add(
    "rigidsphere",
    "*RIGIDWALL_GEOMETRIC_SPHERE_ID\n         1head\n",
    row(0, 0, 0, 0.0) + row(0.0, 0.0, 300.0, 0.0, 0.0, 301.0, 0.2) + row(82.5),
)
add("inivel", "*INITIAL_VELOCITY_GENERATION\n", row(2, 2, 0.0, 0.0, 0.0, -5.0, 0, 0), row(0.0))
add("term", "*CONTROL_TERMINATION\n", row(0.05, 0, 0.0))
