"""Locked obstacles of a study, whose size and place may depend on the design: for pictures of what a surrogate says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

EXACT = 1e-9
"""Of the largest value: how exactly the numbers of an obstacle must be affine functions of the design."""
MOST = 64
"""Obstacles of a file."""


@dataclass(frozen=True, eq=False)
class LockedObstacle:
    """An obstacle whose numbers are affine functions of the design.

    like: as run.json describes it (`billow.results.obstacles`), for one design
    affine: (numbers, 1 + parameters) float64, of the numbers of the description in the order of `numbers_of`, in SI;
        parameters in their own units
    """

    like: dict
    affine: np.ndarray

    @property
    def name(self) -> str:
        return self.like["name"]

    @property
    def varies(self) -> bool:
        """Whether it depends on the design."""
        return bool(self.affine[:, 1:].any())

    def at(self, design: np.ndarray) -> dict:
        """Its description for a design, (parameters,)."""
        numbers = iter((self.affine @ np.concatenate([[1.0], design])).tolist())
        return {
            name: value if not _is_numeric(value) else _shaped(numbers, np.shape(value))
            for name, value in self.like.items()
        }

    def rows(self, name: str) -> np.ndarray:
        """Of `affine`, those of one entry of the description: (numbers of the entry, 1 + parameters)."""
        start = 0
        for entry, value in self.like.items():
            count = np.size(value) if _is_numeric(value) else 0
            if entry == name:
                return self.affine[start : start + count]
            start += count
        raise KeyError(name)

    def require_whole(self, design: np.ndarray) -> None:
        """ValueError or KeyError unless it has a name, a kind and a place. Whether there is such a shape is a question
        to the geometry of the solver, which answers do without."""
        if not all(isinstance(text, str) and text.isprintable() for text in (self.name, self.like["kind"])):
            raise ValueError("the name or kind of an obstacle is no text in one line")
        there = self.at(design)
        if np.shape(there["center"]) != (3,) or np.shape(there["rotation"]) != (3, 3):
            raise ValueError(f"the obstacle {self.name} has no place")


def locked_obstacles(described: Sequence[Sequence[dict]], designs: np.ndarray) -> tuple[LockedObstacle, ...]:
    """Those that every run has, locked, and whose numbers are affine in the design.

    described: of each run, the obstacles of its run.json; designs: (runs, parameters)
    An obstacle that is not of this kind is left out: there is no picture of it.
    """
    found = []
    for like in described[0] if described else ():
        each = [next((o for o in run if _alike(o, like)), None) for run in described]
        if not like.get("locked", True) or any(one is None for one in each):
            continue
        affine = _affine(np.array([numbers_of(one) for one in each]), designs)
        if affine is not None:
            found.append(LockedObstacle(like, affine))
    return tuple(found)


def numbers_of(described: dict) -> list[float]:
    """The numbers of a description, one after the other."""
    return [float(x) for value in described.values() if _is_numeric(value) for x in np.ravel(value)]


def _affine(values: np.ndarray, designs: np.ndarray) -> np.ndarray | None:
    """Values (runs, numbers) as affine functions of the design, (numbers, 1 + parameters); None if they are not."""
    if not np.ptp(values, axis=0).any():
        return np.column_stack([values[0], np.zeros((values.shape[1], designs.shape[1]))])
    rows = np.column_stack([np.ones(len(designs)), designs])
    scale = np.abs(rows).max(axis=0)
    scale[scale == 0.0] = 1.0
    affine, _, rank, _ = np.linalg.lstsq(rows / scale, values, rcond=None)
    if rank < rows.shape[1] or len(rows) <= rows.shape[1]:
        return None  # the runs do not tell which parameter does it
    off = np.abs(rows / scale @ affine - values).max()
    affine[np.abs(affine) < EXACT * np.abs(values).max()] = 0.0
    return (affine / scale[:, None]).T if off <= EXACT * np.abs(values).max() else None


def _alike(one: dict, other: dict) -> bool:
    """Whether two descriptions differ in numbers alone."""
    return list(one) == list(other) and all(
        np.shape(one[k]) == np.shape(other[k]) if _is_numeric(one[k]) and _is_numeric(other[k]) else one[k] == other[k]
        for k in one
    )


def _is_numeric(value: object) -> bool:
    return not isinstance(value, bool | str | dict) and np.asarray(value).dtype.kind in "if"


def _shaped(numbers, shape: tuple[int, ...]) -> float | list:
    taken = np.array([next(numbers) for _ in range(int(np.prod(shape)))])
    return taken.reshape(shape).tolist() if shape else float(taken[0])
