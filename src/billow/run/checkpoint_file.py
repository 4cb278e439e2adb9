"""Checkpoints of a run on disk: two slots, written in turn, each with its checksum."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import billow
from billow.base.errors import IntegrityError
from billow.results.atomic import CHECKPOINTS as SLOTS
from billow.results.tensor_file import read_tensors, write_tensors
from billow.run.spent import NOTHING, Spent
from billow.solver.checkpoint import flatten, restore
from billow.solver.model import Model, State, start_state

NOT_USABLE = IntegrityError.declare(
    "E-RES-031",
    "the checkpoint cannot be used",
    where="{path}",
    cause="it is damaged, was written by another version of Billow, or case.toml was changed",
    remedy="run the case again from the start: billow run CASE.toml --out RUN",
)
NO_CHECKPOINT = IntegrityError.declare(
    "E-RES-032",
    "there is no checkpoint to resume from",
    where="{folder}",
    why="the run ended before its first checkpoint, or was never started",
    cause="the first checkpoint is written 30 s after the start",
    remedy="run the case again: billow run CASE.toml --out RUN",
)


class Start(NamedTuple):
    """What a run begins with, or goes on from: its state, where its journal stood, and what it had cost."""

    state: State | None = None
    journal_offset: int = 0
    spent: Spent = NOTHING


BEGINNING = Start()


def write_checkpoint(path: Path, start: Start, case_digest: str) -> None:
    """Write what a run goes on from to one file, atomically."""
    arrays, numbers = flatten(start.state)
    record = {
        "billow_version": billow.__version__,
        "case_digest": case_digest,
        "journal_offset": start.journal_offset,
        "spent": list(start.spent),
        "numbers": {key: value.hex() if isinstance(value, float) else value for key, value in numbers.items()},
    }
    write_tensors(path, arrays, record)


def read_checkpoint(path: Path, model: Model, case_digest: str) -> Start:
    """What a checkpoint holds.

    Raises IntegrityError E-RES-031 if it is damaged, of another case, or of another version of Billow.
    """

    def damaged(why: str | Exception) -> IntegrityError:
        return NOT_USABLE(path=path, why=why)

    try:
        arrays, record = read_tensors(path, damaged)
        if record["billow_version"] != billow.__version__:
            raise damaged(f"it was written by Billow {record['billow_version']}; the bits would differ")
        if record["case_digest"] != case_digest:
            raise damaged("it belongs to another case")
        fresh = start_state(model)
        state = restore(fresh, arrays, _numbers(record, fresh))
        return Start(state, int(record["journal_offset"]), Spent(*map(float, record["spent"])))
    except (OSError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise damaged(error) from error


def _numbers(record: dict, fresh: State) -> dict:
    """Numbers of a state from a checkpoint's record, each of the kind it has in a fresh state, or ValueError."""
    kinds = {path: type(number) for path, number in flatten(fresh)[1].items()}
    numbers = {}
    for path, saved in record["numbers"].items():
        number = float.fromhex(saved) if isinstance(saved, str) else saved
        kind = kinds.get(path, type(number))
        if not isinstance(number, (float, int) if kind is float else kind) and kind is not type(None):
            raise ValueError(f"{path} is not of the kind this model needs")
        numbers[path] = number
    return numbers


def newest_checkpoint(folder: Path, model: Model, case_digest: str) -> Start:
    """The usable checkpoint with most steps; a damaged slot is passed over as long as the other can be used.

    Raises IntegrityError E-RES-031 if neither can be, E-RES-032 if there is none.
    """
    found, problem = [], None
    for path in (folder / name for name in SLOTS):
        if path.exists():
            try:
                found.append(read_checkpoint(path, model, case_digest))
            except IntegrityError as error:
                problem = error
    if found:
        return max(found, key=lambda start: start.state.step)
    raise problem or NO_CHECKPOINT(folder=folder)
