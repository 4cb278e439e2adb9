"""Histories of LS-DYNA in ASCII files: abstat, nodout, rbdout and rcforc, with the names that binout has for them.

Their layout is that of LSTC's own translator of binout (l2a): columns of fixed width, in which numbers may touch.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.input_file import require_file

LARGEST = 2_000_000_000
"""Bytes of a file."""
_NUMBER = r"[+-]?\d*\.\d+(?:[EeDd][+-]?\d{1,3}|[+-]\d{3})"
_NUMBERS = re.compile(_NUMBER)
_NODOUT_TIME = re.compile(rf"n o d a l   p r i n t .*\( at time\s*({_NUMBER})\s*\)")
_NODE = re.compile(r"\s*(\d+)[ +-]")
_RBDOUT_TIME = re.compile(rf"b o d y   m o t i o n .*time=\s*({_NUMBER})")
_BODY = re.compile(r"\s*(?:nodal )?rigid body\s*(\d+)\s*$")
_RCFORC = re.compile(
    rf"\s*(?:slave|master|surfa|surfb)\s*(\d+)\s+time\s*({_NUMBER})"
    rf"\s+x\s*({_NUMBER})\s+y\s*({_NUMBER})\s+z\s*({_NUMBER})"
)
_ABSTAT_HEAD = re.compile(
    r"\s*time\s+airbag/cv #\s+volume\s+pressure\s+internal energy\s+dm/dt in\s+density\s+dm/dt out\s+total mass"
    r"\s+gas temp\.?\s+surface area"
)
_ABSTAT = re.compile(rf"\s*({_NUMBER})\s*(\d+)\s(.*)")
VARIABLES = {
    "nodout": tuple(f"{x}_{q}" for q in ("displacement", "velocity", "acceleration", "coordinate") for x in "xyz"),
    "rbdout": tuple(f"global_{letter}{x}" for letter in "dv" for x in "xyz"),
    "rcforc": ("x_force", "y_force", "z_force"),
    "abstat": (
        "volume", "pressure", "internal_energy", "dm_dt_in", "density", "dm_dt_out", "total_mass", "gas_temp",
        "surface_area", "reaction",
    ),
}  # fmt: skip
"""File -> what its numbers are, in their order."""


@dataclass(frozen=True)
class TextHistory:
    """time: in the unit of the file, (times,). ids: of nodes, bodies, contacts or airbags; values: of each variable,
    (times, ids)."""

    time: np.ndarray
    ids: list[int]
    values: dict[str, np.ndarray]


Row = tuple[float, int, list[float]]


def read_text(path: Path) -> TextHistory:
    """One of the four files, by its name. OSError; ValueError, with a sentence that names the line."""
    require_file(path, LARGEST)
    names = VARIABLES[path.name]
    blocks: list[tuple[float, dict[int, list[float]]]] = []
    with open(path, encoding="latin-1") as file:
        for line, (time, number, values) in READERS[path.name](file):
            if len(values) < len(names):
                raise ValueError(f"{path.name}, line {line}: {len(values)} numbers; {len(names)} were expected")
            if not blocks or time != blocks[-1][0]:
                if blocks and not time > blocks[-1][0]:
                    raise ValueError(f"{path.name}, line {line}: time {time:g} follows {blocks[-1][0]:g}")
                blocks.append((time, {}))
            blocks[-1][1].setdefault(number, values)  # of the two sides of a contact the first counts
    if not blocks:
        raise ValueError(f"{path.name} holds no state in a layout that is known")
    ids = list(blocks[0][1])
    for time, found in blocks:
        if list(found) != ids:
            other = next(iter(set(ids).symmetric_difference(found)), ids[0])
            raise ValueError(f"{path.name}: the state at {time:g} is not that of the others, for example of {other}")
    table = np.array([[found[number][: len(names)] for number in ids] for _, found in blocks])
    return TextHistory(np.array([time for time, _ in blocks]), ids, {n: table[:, :, k] for k, n in enumerate(names)})


def _numbers(text: str) -> list[float]:
    found = []
    for one in _NUMBERS.findall(text):
        one = one.replace("D", "E").replace("d", "E")
        found.append(float(one if "E" in one.upper() else one[:-4] + "E" + one[-4:]))
    return found


def _nodout(lines) -> Iterator[tuple[int, Row]]:
    time, in_table = None, False
    for k, line in enumerate(lines, 1):
        if head := _NODOUT_TIME.search(line):
            time, in_table = _numbers(head[1])[0], False
        elif "nodal point" in line:
            in_table = "x-disp" in line  # another table, of rotations, follows
        elif in_table and time is not None and (row := _NODE.match(line)):
            yield k, (time, int(row[1]), _numbers(line[row.end() - 1 :]))
        elif in_table and line.strip():
            in_table = False


def _rbdout(lines) -> Iterator[tuple[int, Row]]:
    time, body, moves = None, None, []
    for k, line in enumerate(lines, 1):
        if head := _RBDOUT_TIME.search(line):
            time, body = _numbers(head[1])[0], None
        elif (head := _BODY.match(line)) and time is not None:
            body, moves = int(head[1]), []
        elif body is None:
            continue
        elif line.startswith((" displacements:", "    velocities:")):
            moves += _numbers(line)[:3]
            if len(moves) == 6:  # in the axes of space; those of the body follow
                yield k, (time, body, moves)
                body = None


def _rcforc(lines) -> Iterator[tuple[int, Row]]:
    for k, line in enumerate(lines, 1):
        if row := _RCFORC.match(line):
            yield k, (_numbers(row[2])[0], int(row[1]), [_numbers(text)[0] for text in row.groups()[2:]])


def _abstat(lines) -> Iterator[tuple[int, Row]]:
    in_table = False
    for k, line in enumerate(lines, 1):
        if "airbag/cv" in line:
            in_table = _ABSTAT_HEAD.match(line) is not None
            if not in_table:
                raise ValueError(f"abstat, line {k}: columns that are not known")
        elif in_table and (row := _ABSTAT.match(line)):
            yield k, (_numbers(row[1])[0], int(row[2]), _numbers(row[3]))


READERS: dict[str, Callable] = {"nodout": _nodout, "rbdout": _rbdout, "rcforc": _rcforc, "abstat": _abstat}
"""What reads each file: line, time, id and numbers of each row."""
