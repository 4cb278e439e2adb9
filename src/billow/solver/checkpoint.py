"""A state as arrays and numbers, and back: what a checkpoint file holds.

`flatten` names every leaf by its path; `restore` writes leaves into a state freshly made for the same model, so that a
checkpoint cannot bring in anything a run would not have. Fields with the metadata "constant" are left out; arrays below
a field with the metadata "varying" may have any number of rows. Every float goes through as it is.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from billow.solver.model import State

Leaf = np.ndarray | float | int | bool | None


def flatten(state: State) -> tuple[dict[str, np.ndarray], dict[str, float | int | bool | None]]:
    """Arrays by path, for example "gas.masses", and numbers by path, for example "ledger.energies.strain"."""
    arrays, numbers = {}, {}
    for path, leaf, *_ in _leaves("", state):
        if isinstance(leaf, np.ndarray):
            arrays[path] = leaf
        else:
            numbers[path] = leaf.item() if isinstance(leaf, np.generic) else leaf
    return arrays, numbers


def restore(fresh: State, arrays: dict[str, np.ndarray], numbers: dict[str, Any]) -> State:
    """The saved state, written into `fresh`, a state at time zero of the same model.

    Raises ValueError, with a sentence for the user, if the leaves do not fit the model.
    """
    leaves = list(_leaves("", fresh))
    odd = sorted({path for path, *_ in leaves} ^ (set(arrays) | set(numbers)))
    if odd:
        raise ValueError(f"it does not have the parts of this model; the first that differs is {odd[0]}")
    for path, leaf, varies, holder in leaves:
        if isinstance(leaf, np.ndarray):
            saved, own = arrays.get(path), 1 if varies else 0  # the number of rows of what varies is its own
            needed = leaf.dtype, leaf.ndim, leaf.shape[own:]
            if saved is None or (saved.dtype, saved.ndim, saved.shape[own:]) != needed:
                raise ValueError(f"{path} does not have the shape this model needs")
            saved = np.array(saved)
        elif path not in numbers:
            raise ValueError(f"{path} is not a number")
        else:
            saved = numbers[path]
        name = path.rpartition(".")[2]
        if isinstance(holder, tuple):  # arrays inside a tuple are overwritten where they are
            leaf[...] = saved
        elif isinstance(holder, dict):
            holder[name] = saved
        else:
            setattr(holder, name, saved)
    return fresh


def _leaves(path: str, value: Any, varies: bool = False, holder: Any = None) -> Iterator[tuple[str, Leaf, bool, Any]]:
    """Path, value, whether it may have another number of rows, and what holds it, of every array and number."""
    if dataclasses.is_dataclass(value):
        inner = [
            (field.name, getattr(value, field.name), varies or "varying" in field.metadata)
            for field in dataclasses.fields(value)
            if "constant" not in field.metadata
        ]
    elif isinstance(value, (tuple, dict)):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        inner = [(str(key), item, varies) for key, item in items]
    else:
        yield path, value, varies, holder
        return
    for name, item, item_varies in inner:
        yield from _leaves(f"{path}.{name}" if path else name, item, item_varies, value)
