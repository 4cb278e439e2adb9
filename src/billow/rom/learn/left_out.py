"""Training runs that were not learned from, and whether leaving them out biases the surrogate."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.stats import mannwhitneyu

from billow.rom.learn.dataset import Dataset

FEWEST = 3
"""Runs left out before a common cause is looked for."""

BIASED = 0.02
"""Part of a design that may be left out without being called a bias."""

REASONS = 3
"""Reasons that are listed; more are rare."""


@dataclass(frozen=True)
class LeftOut:
    """why: run -> reason; part: of all training runs of the design, [-]
    leaning: label of a parameter -> "high" or "low", where the runs left out have other values than the others
    """

    why: dict[str, str]
    part: float
    leaning: dict[str, str]

    @property
    def biased(self) -> bool:
        """True if errors measured on unseen runs may not hold for runs like those left out."""
        return bool(self.leaning) or self.part > BIASED

    def reasons(self) -> str:
        """The most frequent reasons, without their particulars, and how many runs each took."""
        count = Counter(reason.split(";")[0] for reason in self.why.values())
        listed = ", ".join(f"{reason} ({runs})" for reason, runs in count.most_common(REASONS))
        return listed + ", ..." * (len(count) > REASONS)


def left_out(dataset: Dataset, learned: tuple[str, ...]) -> LeftOut:
    """What of a dataset's training design is not among the runs `learned` from, because it is missing or in doubt.

    A parameter leans if ranks differ between the runs left out and the others (Mann-Whitney test, 5 % with the
    Bonferroni correction for the number of parameters).
    """
    why = {run: reason for run, reason in dataset.left_out.items() if run not in learned}
    part = len(why) / max(1, len(dataset.trusted) + len(dataset.left_out))
    if len(why) < FEWEST or not learned:
        return LeftOut(why, part, {})
    lost, kept = np.asarray(dataset.design(list(why))), np.asarray(dataset.design(learned))
    leaning = {}
    for p, ours, theirs in zip(dataset.parameters, lost.T, kept.T, strict=True):
        if mannwhitneyu(ours, theirs).pvalue * len(dataset.parameters) < 0.05:
            leaning[p.label] = "high" if np.median(ours) > np.median(theirs) else "low"
    return LeftOut(why, part, leaning)
