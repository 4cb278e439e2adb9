"""Tear seams: pairs of nodes, the length that each stands for, and their strength (docs/theory.md, Tear seams)."""

from __future__ import annotations

import numpy as np

from billow.base.errors import InputError
from billow.case.bag import schema_bag
from billow.geometry.bag_shapes import DOES_NOT_FIT, BagShape, TearLine, joined
from billow.geometry.rectangular_bag import FRONT, REAR
from billow.parts.fabric.membrane import FabricLaw
from billow.parts.tear_seams import TearSeams

NO_SEAM = InputError.declare(
    "E-GEO-060",
    "the tear seam {seam} has no length",
    where="bag.tear_seams, seam {seam}",
    why="force per length of seam has no meaning there; {ties} pairs of nodes were found for it",
    cause="a line outside the bag or shorter than an element, panels whose nodes do not lie over each other there, or "
    "pairs of nodes that lie in one place",
    remedy="make it longer than two elements, reduce bag.element_size, and give pairs of nodes in their order along it",
)

SAME_PLACE = 9
"""Decimals [m] that places along a seam have in common."""
WIDEST = 2.5
"""Elements between neighbours along a seam from which on something else lies between them."""
CLOSEST = 1e-5
"""Distance [m] of two tied nodes below which contact knows no side of them."""


def panel_tear_lines(bag: schema_bag.PanelBag, shape: BagShape) -> tuple[TearLine, ...]:
    """Seams between front and rear, whose nodes are found on the flat bag."""
    seams = []
    for seam in bag.tear_seams:
        ties = joined(shape, FRONT, REAR, np.array([seam.begin, seam.end]), 0.5 * bag.element_size)
        seams.append(tear_line(seam, ties, shape, _along(seam, shape.positions[ties[:, 0], :2], bag.element_size)))
    return tuple(seams)


def _along(seam: schema_bag.PanelTearSeam, places: np.ndarray, element: float) -> np.ndarray:
    """Length [m] that each place (n, 2) in the order along a straight seam stands for. It counts along the seam,
    because a line between two rows of nodes ties both; places beside each other share theirs. element: size [m].
    Raises InputError E-GEO-010 if a part of the seam has no nodes to be tied, such as over a mouth or a vent."""
    way = np.subtract(seam.end, seam.begin)
    along = places @ (way / np.linalg.norm(way))
    _, first, station = np.unique(along.round(SAME_PLACE), return_index=True, return_inverse=True)
    steps = np.diff(along[first])
    if steps.max(initial=0.0) > WIDEST * element:
        gap = int(steps.argmax())
        a, b = (1e3 * places[first[k]] for k in (gap, gap + 1))
        raise DOES_NOT_FIT(
            what=f"the tear seam {seam.name} is interrupted between ({a[0]:.4g}, {a[1]:.4g}) and ({b[0]:.4g}, "
            f"{b[1]:.4g}) mm",
            key="tear_seams",
            why="no nodes of one panel lie over nodes of the other there; ties at the ends would stand for all of it",
            remedy="end it at the mouth or vent that lies there, and write what follows as a seam of its own; or shift "
            "it, if nodes lie beside it there",
        )
    return (_halves(steps) / np.bincount(station))[station]


def _halves(steps: np.ndarray) -> np.ndarray:
    """Half of the steps (n - 1,) on either side of each of n places."""
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def tear_line(
    seam: schema_bag.TearStrength, ties: np.ndarray, shape: BagShape, length: np.ndarray | None = None
) -> TearLine:
    """A tear seam of ties (n, 2) in their order along it. length: [m], that each stands for, (n,); by default half of
    the way to its neighbours on either side. Raises InputError E-GEO-060 if it has no length, E-GEO-010 if nodes to be
    tied lie in one place: contact of layers knows no side of them, and would not let them part."""
    if length is None:
        middle = 0.5 * (shape.positions[ties[:, 0]] + shape.positions[ties[:, 1]])
        length = _halves(np.linalg.norm(np.diff(middle, axis=0), axis=1))
    if not (len(ties) and length.all()):
        raise NO_SEAM(seam=seam.name, ties=len(ties))
    apart = np.linalg.norm(shape.positions[ties[:, 1]] - shape.positions[ties[:, 0]], axis=1)
    if not apart.min() > CLOSEST:
        one, other = ties[apart.argmin()]
        raise DOES_NOT_FIT(
            what=f"nodes of the tear seam {seam.name} lie in one place",
            key="tear_seams",
            why=f"nodes {one} and {other} are {1e3 * apart.min():.3g} mm apart, and contact knows no side of them",
            remedy="leave a slit of a tenth of a millimetre between the rows",
        )
    single = isinstance(seam.strength, float)
    rate, strength = ([0.0], [seam.strength]) if single else (seam.strength.loading_rate, seam.strength.value)
    return TearLine(seam.name, ties, length, np.array(rate), np.array(strength), seam.stiffness or None)


def build_tear_seams(shape: BagShape, fabric: FabricLaw) -> TearSeams | None:
    """The ties of all tear seams; at rest up to the distance at which their nodes start."""
    lines = shape.tear_lines
    if not lines:
        return None
    counts, points = [len(line.ties) for line in lines], max(len(line.rate) for line in lines)
    ties, length = np.concatenate([line.ties for line in lines]), np.concatenate([line.length for line in lines])
    width = np.repeat([line.length.max() for line in lines], counts)  # of a row of elements
    own = fabric.warp_modulus * fabric.thickness / width
    stated = np.repeat([np.nan if line.stiffness is None else line.stiffness for line in lines], counts)
    stiffness = np.where(np.isnan(stated), own, stated) * length
    mass = fabric.density * fabric.thickness * width * length

    def padded(values: np.ndarray, step: float) -> np.ndarray:
        more = points - len(values)
        return np.append(values, values[-1] + step * np.arange(1.0, more + 1.0))

    return TearSeams(
        names=tuple(line.name for line in lines),
        ties=ties.astype(np.int64),
        seam=np.repeat(np.arange(len(lines)), counts),
        length=length,
        rest=np.linalg.norm(shape.positions[ties[:, 1]] - shape.positions[ties[:, 0]], axis=1),
        stiffness=stiffness,
        viscosity=fabric.damping * np.sqrt(stiffness * mass),
        rate=np.array([padded(line.rate, 1.0) for line in lines]),
        strength=np.array([padded(line.strength, 0.0) for line in lines]),
    )
