"""Clusters: cells too small for the step are joined with a neighbour, and share one state (docs/mesh_gas.md, Method).

Cells join face by face. A face is a reason to join if it is wide for the smaller of the two volumes that the cell has
at the start and at the end; the neighbour behind the widest such face takes the cell in, if it is larger. A thin layer
is no wider open sideways than it is thick, so a layer of any thickness is left alone. Cells that are inside out, where
fabric lies in itself or in a wall at a fold line, join until all of them together have more room than is inside out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.base.scratch import Scratch
from billow.geometry.cut_cells import NOTHING
from billow.geometry.lattice_clipping import STRIDE

FULL = 0.999
"""Volume of a cell [cells] from which it is never joined."""
WIDE = 2.0
"""Aperture over volume of a cell from which a face is a reason to join, whatever the step."""
OPEN = 1.1
"""The same, for cells that the step is too long for."""
SHRINKS = 0.5
"""Change of a cell's volume in a step, relative, from which the step is too long for it."""
SMALL, CROWDED = 0.1, 1.5
"""A cell smaller than this [cells], and a cluster of any size, whose Courant number is larger than this is taken in by
its widest neighbour."""
LEAST = 1e-4
"""Volume [cells] below which there is no room for gas: such a cluster is adopted by the largest one about it."""
ROUNDS = 300
"""In which a cluster may be adopted, one after the other."""
NOBODY = np.empty(0, np.bool_)


class Clusters(NamedTuple):
    """of: (cells,) int32, number of the cluster of each cell. start: (clusters + 1,) and members: (cells,) int32: the
    cells of cluster c are members[start[c]] to members[start[c + 1]]. before, after: volumes [cells], (clusters,).
    special: how many have walls or several cells; they are the first ones. adopted: how many were taken in by others,
    lost: how many had no room and found nobody."""

    of: np.ndarray
    start: np.ndarray
    members: np.ndarray
    before: np.ndarray
    after: np.ndarray
    special: int
    adopted: int
    lost: int


def find_clusters(
    key: np.ndarray, beside: np.ndarray, volume: np.ndarray, aperture: np.ndarray, walls: np.ndarray, pace: np.ndarray,
    doors: np.ndarray, courant: float, scratch: Scratch, starved: np.ndarray = NOBODY,
) -> Clusters:  # fmt: skip
    """key: of the cells, ascending, (n,). beside: their neighbours, (n, 6). volume: (2, n), at the start and at the
    end [cells]. aperture: mean of each upper face, (n, 3). walls: first patch of each, (n + 1,). pace: |u_d| + c [m/s],
    (n, 3). doors: openings to other rooms in each [faces], (n,). courant: dt/h [s/m]. scratch: lends "slope" meanwhile,
    and what is found lies in it until the next time. starved: cells, (n,) bool, whose clusters would be without mass
    or energy, and are adopted like those without room."""
    n = len(key)
    of, members = scratch.take("of", n, kind=np.int32), scratch.take("members", n, kind=np.int32)
    start = scratch.take("first", n + 2, kind=np.int32)
    before, after = scratch.take("before", n), scratch.take("after", n)
    leaving, first, last, turned, need, widest, *others = scratch.take("slope", 11, n)
    root, chosen, door = (row.view(np.int32)[:n] for row in others[:3])
    room = others[3].view(np.int32)[: n + 1]
    plain, crowded = others[4].view(np.bool_)[: 2 * n].reshape(2, n)
    _choose(n, beside, volume, aperture, pace, doors, courant, leaving, chosen, root, plain, first, last)
    adopted, lost = _join(
        key, beside, volume, aperture, pace, leaving, courant, plain, chosen, root, first, last, turned, need, widest,
        door, room, crowded, starved,
    )  # fmt: skip
    count, special = _number(root, walls, first, last, of, start, members, before, after)
    return Clusters(of, start[: count + 1], members, before[:count], after[:count], special, adopted, lost)


@scalar
def _crossing(pace, i, j, d, aperture, courant):
    """Courant number that a face between cells i and j adds to either."""
    return 0.5 * aperture * max(pace[i, d], pace[j, d]) * courant


@kernel
def _choose(
    n, beside, volume, aperture, pace, doors, courant, leaving_out, chosen_out, root_out, plain_out, before_out,
    after_out,
):  # fmt: skip
    """leaving_out: Courant number of the openings to other rooms in each cell. plain_out: whether a cell is full and
    none of its faces inside out. root_out, before_out, after_out: as if nothing joined."""
    for i in prange(n):
        leaving_out[i], chosen_out[i] = doors[i] * max(pace[i, 0], pace[i, 1], pace[i, 2]) * courant, i
        root_out[i], before_out[i], after_out[i] = i, volume[0, i], volume[1, i]
        least, both = min(volume[0, i], volume[1, i]), volume[0, i] + volume[1, i]
        plain_out[i] = least > FULL and min(aperture[i, 0], aperture[i, 1], aperture[i, 2]) >= 0.0
        if least > FULL:
            continue
        need = leaving_out[i]
        for d in range(3):
            up, down = beside[i, 2 * d + 1], beside[i, 2 * d]
            if up >= 0 and aperture[i, d] > 0.0:
                need += _crossing(pace, i, up, d, aperture[i, d], courant)
            if down >= 0 and aperture[down, d] > 0.0:
                need += _crossing(pace, i, down, d, aperture[down, d], courant)
        tight = need > least or abs(volume[1, i] - volume[0, i]) > SHRINKS * least
        widest = 0.0
        for face in range(6):
            j, d = beside[i, face], face // 2
            if j < 0:
                continue
            a = aperture[i, d] if face % 2 else aperture[j, d]
            if a <= widest or not (a > WIDE * least or (tight and a > OPEN * least) or least <= NOTHING):
                continue
            other, other_both = min(volume[0, j], volume[1, j]), volume[0, j] + volume[1, j]
            higher = other > least or (
                other == least and (other_both > both or (other_both == both and j > i))
            )  # an order of all cells, so that no circle of them can form
            if higher:
                widest, chosen_out[i] = a, j


@scalar
def _follow(chosen, i):
    while chosen[i] != i:
        i = chosen[i]
    return i


@scalar
def _settle(some, chosen, volume, root_out, before_out, after_out, turned_out):
    """Roots of some cells, and of their clusters, at the places of the roots, which are among these cells, volumes and
    how much of them is inside out."""
    for i in some:
        root_out[i] = _follow(chosen, i)
        before_out[i] = after_out[i] = turned_out[i] = 0.0
    for i in some:
        before_out[root_out[i]] += volume[0, i]
        after_out[root_out[i]] += volume[1, i]
        turned_out[root_out[i]] += max(-volume[0, i], -volume[1, i], 0.0)


@scalar
def _find(key, wanted):
    """Place of a key among ascending ones, or -1."""
    low, high = 0, len(key)
    while low < high:
        middle = (low + high) // 2
        if key[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low if low < len(key) and key[low] == wanted else -1


@scalar
def _take_in_crowded(
    some, beside, volume, aperture, pace, leaving, courant, chosen, root, before, after, need, widest, door, crowded_out
):  # fmt: skip
    """Clusters through whose faces more flows than they hold join the one behind their widest face; those for
    which that is no help are marked. Returns how many joined. need, widest, door: scratch."""
    joined = 0
    for i in some:
        need[i], widest[i], door[i] = 0.0, 0.0, -1
    for i in some:
        r = root[i]
        alone = before[r] == volume[0, r] and after[r] == volume[1, r]
        if alone and min(before[r], after[r]) > SMALL:
            continue
        need[r] += leaving[i]
        for face in range(6):
            j, d = beside[i, face], face // 2
            if j < 0 or root[j] == r:
                continue
            a = aperture[i, d] if face % 2 else aperture[j, d]
            if a > 0.0:
                need[r] += _crossing(pace, i, j, d, a, courant)
                if a > widest[r]:
                    widest[r], door[r] = a, j
    for r in some:
        least = min(before[r], after[r])
        crowded_out[r] = False
        if root[r] != r or door[r] < 0 or not need[r] > CROWDED * least:
            continue
        k = _follow(chosen, door[r])
        if k != r and min(before[k], after[k]) > least:
            chosen[r] = k
            joined += 1
        else:
            crowded_out[r] = True
    return joined


@scalar
def _join_across(some, beside, aperture, starved, chosen):
    """Cells on both sides of a face join if it is open by less than nothing, or if both are starved: these are to be
    adopted as one. Returns how many clusters did."""
    joined = 0
    for i in some:
        for d in range(3):
            j = beside[i, 2 * d + 1]
            if j >= 0 and (aperture[i, d] < 0.0 or (len(starved) > 0 and starved[i] and starved[j])):
                a, b = _follow(chosen, i), _follow(chosen, j)
                if a != b:
                    chosen[a] = b
                    joined += 1
    return joined


@scalar
def _adopt(some, key, chosen, root, before, after, turned, crowded, starved, best, at):
    """Clusters without room, or with less of it than of them is inside out, and crowded or starved ones, join the
    largest one among the cells about them. Returns how many did, and how many without room found none. best, at:
    scratch."""
    adopted, lost = 0, 0
    for i in some:
        best[i], at[i] = 0.0, -1
    if len(starved) > 0:
        for i in some:
            if starved[i]:
                starved[root[i]] = True
    for i in some:
        r = root[i]
        hungry = len(starved) > 0 and starved[r]
        room = max(LEAST, turned[r])
        if before[r] > room and after[r] > room and not crowded[r] and not hungry:
            continue
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                for dz in range(-1, 2):
                    j = _find(key, key[i] + dx * STRIDE[0] + dy * STRIDE[1] + dz * STRIDE[2])
                    if j >= 0 and root[j] != r and not (hungry and starved[root[j]]):
                        least = min(before[root[j]], after[root[j]])
                        if least > max(best[r], LEAST):
                            best[r], at[r] = least, root[j]
    for r in some:
        if at[r] >= 0:
            k = _follow(chosen, at[r])
            hungry = len(starved) > 0 and starved[r]
            if k != r and (hungry or not crowded[r] or min(before[k], after[k]) > min(before[r], after[r])):
                chosen[r] = k
                adopted += 1
        elif root[r] == r and not (before[r] > LEAST and after[r] > LEAST) and (before[r] != 0.0 or after[r] != 0.0):
            lost += 1
    return adopted, lost


@scalar
def _not_plain(plain, chosen, some_out):
    """Cells that are not plain, in their order, and those that take others in, which are plain no more; returns their
    number."""
    for i in range(len(plain)):
        if chosen[i] != i:
            plain[chosen[i]] = False
    m = 0
    for i in range(len(plain)):
        some_out[m] = i
        m += not plain[i]
    return m


@scalar
def _join(
    key, beside, volume, aperture, pace, leaving, courant, plain, chosen, root_out, before_out, after_out, turned,
    need, widest, door, room, crowded, starved,
):  # fmt: skip
    """Join clusters until all of them have room; returns how many were taken in, and how many found nobody. turned to
    crowded: scratch."""
    for i in range(len(key)):
        crowded[i] = False
    for i in range(len(starved)):
        plain[i] = plain[i] and not starved[i]
    some = room[: _not_plain(plain, chosen, room)]
    joined, lost = _join_across(some, beside, aperture, starved, chosen), 0
    if joined > 0:
        some = room[: _not_plain(plain, chosen, room)]
    _settle(some, chosen, volume, root_out, before_out, after_out, turned)
    for _ in range(ROUNDS):  # what is inside out by more than a cell needs several neighbours
        taken = _take_in_crowded(
            some, beside, volume, aperture, pace, leaving, courant, chosen, root_out, before_out, after_out, need,
            widest, door, crowded,
        )  # fmt: skip
        if taken > 0:
            some = room[: _not_plain(plain, chosen, room)]
            _settle(some, chosen, volume, root_out, before_out, after_out, turned)
        adopted, lost = _adopt(
            some, key, chosen, root_out, before_out, after_out, turned, crowded, starved, widest, door
        )  # fmt: skip
        starved = starved[:0]  # who has adopted them is not
        joined += taken + adopted
        if taken + adopted == 0:
            break
        some = room[: _not_plain(plain, chosen, room)]
        _settle(some, chosen, volume, root_out, before_out, after_out, turned)
    return joined, lost


@scalar
def _number(root, walls, first, last, of_out, start_out, members_out, before_out, after_out):
    """Number the clusters and list their cells; returns how many there are, and how many of them are special. first,
    last: volumes, at the places of the roots."""
    n = len(root)
    is_special = np.zeros(n, np.bool_)
    for i in range(n):
        if root[i] != i or walls[i + 1] > walls[i]:
            is_special[root[i]] = True
    count, special = 0, 0
    for others in range(2):
        for i in range(n):
            if root[i] == i and is_special[i] != (others == 1):
                of_out[i], before_out[count], after_out[count] = count, first[i], last[i]
                count += 1
        if others == 0:
            special = count
    for c in range(count + 2):
        start_out[c] = 0
    for i in range(n):  # sizes, two places on, become where clusters begin, one place on, and then where they end
        of_out[i] = of_out[root[i]]
        start_out[of_out[i] + 2] += 1
    for c in range(1, count + 1):
        start_out[c + 1] += start_out[c]
    for i in range(n):
        c = of_out[i] + 1
        members_out[start_out[c]] = i
        start_out[c] += 1
    return count, special
