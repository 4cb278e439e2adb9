"""Which test runs a model is judged by."""

from __future__ import annotations

from dataclasses import dataclass

from billow.base import quality
from billow.base.errors import InputError
from billow.rom.learn.dataset import Dataset

NO_UNSEEN_RUNS = InputError.declare(
    "E-ROM-015",
    "there are no unseen runs to compare with",
    where="{title}",
    cause="the test runs of the study are not made yet, or failed",
    remedy="ask for test runs in study.toml, or finish the study: billow study STUDY.toml --out FOLDER",
)


@dataclass(frozen=True)
class UnseenRuns:
    """runs: what a model is judged by, in the order drawn
    left_out: completed test runs whose verdict is FAIL -> why: what they hold is no truth to compare with
    reviewed: those of `runs` whose verdict is REVIEW -> why; without them an evaluation would leave out hard cases
    """

    runs: tuple[str, ...]
    left_out: dict[str, str]
    reviewed: dict[str, str]

    def sentences(self) -> list[str]:
        """For people: which completed runs are out or in doubt, and why."""
        told = []
        for count, what in ((self.left_out, "not compared with"), (self.reviewed, "compared with, but in doubt")):
            if count:
                named = "; ".join(f"{run} ({why})" for run, why in list(count.items())[:5]) + "; ..." * (len(count) > 5)
                told.append(f"{len(count)} unseen run{'s' * (len(count) != 1)} {what}: {named}.")
        return told


def unseen_runs(dataset: Dataset) -> UnseenRuns:
    """The completed test runs of a dataset, sorted by verdict. InputError E-ROM-015 if none can be compared with."""
    left_out, reviewed = {}, {}
    for run in dataset.test:
        verdict, why = _doubt(dataset.result(run).record.get("quality") or {})
        if verdict != "PASS":
            (left_out if verdict == "FAIL" else reviewed)[run] = f"{verdict}: {why}"
    runs = tuple(run for run in dataset.test if run not in left_out)
    if not runs:
        why = "the dataset has no completed test run"
        if left_out:
            run, reason = next(iter(left_out.items()))
            why = f"all {len(left_out)} completed test runs have the verdict FAIL; run {run}: {reason}"
        raise NO_UNSEEN_RUNS(title=dataset.title or "dataset", why=why)
    return UnseenRuns(runs, left_out, reviewed)


def _doubt(told: dict) -> tuple[str, str]:
    """Verdict of a run and the names of what speaks against it. told: quality of its run.json, empty without a verdict.
    As in training, it is nothing against a run that it ends early (`quality.SHORT`)."""
    lines = [line for line in told.get("criteria", ()) if line["name"] != quality.SHORT]
    if not told.get("criteria"):
        return told.get("verdict") or "PASS", "no reason is given"
    verdict = max((line["verdict"] for line in lines), key=quality.VERDICTS.index, default="PASS")
    return verdict, ", ".join(line["name"] for line in lines if line["verdict"] != "PASS")
