"""Checkpoints of a run on disk: two slots, written in turn, each with its checksum."""

from __future__ import annotations

from pathlib import Path

import billow
from billow.dynamics.checkpoint import flatten, restore
from billow.dynamics.model import Model, State, start_state
from billow.errors import IntegrityError
from billow.results.tensor_file import read_tensors, write_tensors

SLOTS = ("checkpoint_a.safetensors", "checkpoint_b.safetensors")


def write_checkpoint(path: Path, state: State, case_digest: str, journal_offset: int) -> None:
    """Write a state, and where the journal stood, to one file, atomically."""
    arrays, numbers = flatten(state)
    record = {
        "billow_version": billow.__version__,
        "case_digest": case_digest,
        "journal_offset": journal_offset,
        "numbers": {key: value.hex() if isinstance(value, float) else value for key, value in numbers.items()},
    }
    write_tensors(path, arrays, record)


def read_checkpoint(path: Path, model: Model, case_digest: str) -> tuple[State, int]:
    """State and journal offset of a checkpoint.

    Raises IntegrityError E-RES-031 if it is damaged, of another case, or of another version of Billow.
    """

    def damaged(why: str) -> IntegrityError:
        return IntegrityError(
            "E-RES-031",
            "the checkpoint cannot be used",
            where=str(path),
            why=why,
            remedy="run the case again from the start: billow run CASE.toml --out RUN",
        )

    arrays, record = read_tensors(path, damaged)
    if record["billow_version"] != billow.__version__:
        raise damaged(f"it was written by Billow {record['billow_version']}; the bits would differ")
    if record["case_digest"] != case_digest:
        raise damaged("it belongs to another case")
    numbers = {
        key: float.fromhex(value) if isinstance(value, str) else value for key, value in record["numbers"].items()
    }
    try:
        return restore(start_state(model), arrays, numbers), int(record["journal_offset"])
    except ValueError as error:
        raise damaged(str(error)) from error


def newest_checkpoint(folder: Path, model: Model, case_digest: str) -> tuple[State, int]:
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
        return max(found, key=lambda pair: pair[0].step)
    raise problem or IntegrityError(
        "E-RES-032",
        "there is no checkpoint to resume from",
        where=str(folder),
        why="the run ended before its first checkpoint, or was never started",
        remedy="run the case again: billow run CASE.toml --out RUN",
    )
