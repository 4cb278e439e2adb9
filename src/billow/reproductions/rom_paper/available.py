"""Which nested designs of an unfinished study are complete enough for a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from billow.results.dataset import Dataset
from billow.rom.judge.unseen import unseen_runs
from billow.rom.learn.dataset import TOO_FEW_RUNS

ENOUGH = 0.9
"""Part of a nested design's runs that must be complete: a few failed runs do no harm."""


@dataclass(frozen=True)
class Available:
    """sizes: N_DOE -> the training runs used, rising; unseen: test runs; notes: sentences about what is missing."""

    sizes: dict[int, tuple[str, ...]]
    unseen: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def largest(self) -> int:
        return max(self.sizes)


def available(dataset: Dataset, train: Sequence[str], test: Sequence[str], sizes: Sequence[int]) -> Available:
    """What of a study can be used.

    Runs with the verdict REVIEW are used, unlike by `billow train`: without them a nested design would be no Latin
    hypercube any more, and the paper's horizon of 50 ms ends before what some of them are reviewed for. A note counts
    them. Runs with the verdict FAIL are not used.

    train, test: runs of its design, also those not made yet, in the order drawn; sizes: of its nested designs, rising
    InputError E-ROM-015 without an unseen run, E-ROM-007 without two training runs.
    """
    usable, notes = {run for run in dataset.train if dataset.verdict(run) != "FAIL"}, []
    found = {size: tuple(run for run in train[:size] if run in usable) for size in sizes}
    whole = {size: runs for size, runs in found.items() if len(runs) >= ENOUGH * size}
    unseen = unseen_runs(dataset)
    if len(usable) < 2:
        raise TOO_FEW_RUNS(title=dataset.title or "dataset", count=len(usable))
    notes += [
        f"N_DOE = {size} is left out: only {len(runs)} of its {size} training runs are complete."
        for size, runs in found.items()
        if size not in whole
    ]
    if not whole:
        runs = tuple(run for run in train if run in usable)
        whole = {len(runs): runs}
        notes.append(f"No nested design is complete; the {len(runs)} training runs so far are used as one.")
    lost = [f"{size - len(runs)} of {size}" for size, runs in whole.items() if len(runs) < size]
    if lost:
        notes.append(f"Missing or failed training runs are left out: {', '.join(lost)}.")
    used = whole[max(whole)]
    reviewed = [run for run in used if dataset.verdict(run) == "REVIEW"]
    if reviewed:
        doubts = Counter(name for run in reviewed for name in dataset.doubts(run))
        named = ", ".join(f"{name} ({count})" for name, count in doubts.most_common())
        notes.append(f"{len(reviewed)} of the {len(used)} training runs used carry the verdict REVIEW: {named}.")
    if len(dataset.test) < len(test):
        notes.append(f"{len(dataset.test)} of {len(test)} unseen runs are complete.")
    notes += unseen.sentences()
    return Available(whole, unseen.runs, tuple(notes))
