"""Sentences chosen by the numbers: what the surrogate achieves and where it is weak."""

from __future__ import annotations

import numpy as np
from scipy.stats import spearmanr

from billow.rom.judge.errors import accuracy
from billow.rom.judge.evaluate import Evaluation
from billow.rom.learn.simple_answers import BASELINES, MEAN_TRAJECTORY
from billow.rom.surrogate.basis import COMPONENTS, Z

MILLI = 1e3


def strongest_baseline(evaluation: Evaluation, component: int) -> str:
    """The baseline with the lowest mean RMSE of a component."""
    return min(BASELINES, key=lambda name: evaluation.summary(name, component).mean)


def gain(evaluation: Evaluation, baseline: str, component: int) -> float:
    """By how much the surrogate's mean RMSE is below a baseline's: [-], negative if the baseline is better. 0 in a
    component that never moves, which every baseline predicts without error."""
    known = evaluation.summary(baseline, component).mean
    return 1.0 - evaluation.summary("surrogate", component).mean / known if known else 0.0


def less_or_more(gained: float) -> str:
    """A gain [-] as people say it: "12 % less", "10 % more"."""
    return f"{_percent(abs(gained))} {'less' if gained >= 0.0 else 'more'}"


def acceptance(evaluation: Evaluation) -> str:
    """Whether the surrogate may be used, and which simple answer won where it did not, in one sentence."""
    lost = evaluation.judgement.lost
    on = _runs(len(evaluation.test), "unseen")
    if lost:
        winners = " and ".join(f"the {one.answer} ({one.other:.3g} mm against {one.own:.3g} mm)" for one in lost)
        return f"Not accepted: on {on}, nodes are predicted better by {winners}."
    beaten = [
        f"in {axis} the {name} is better" for c, axis in enumerate(COMPONENTS) for name in BASELINES
        if 0.0 < evaluation.summary(name, c).mean <= evaluation.summary("surrogate", c).mean
    ]  # fmt: skip
    least = f"Accepted: on {on} it is off by less than every simple answer, all directions together"
    return f"{least}; but {', and '.join(beaten)}." if beaten else f"{least}, and in each direction alone."


def verdict(evaluation: Evaluation) -> list[str]:
    """What the surrogate achieves, in two or three sentences."""
    timing, error = evaluation.timing, evaluation.summary("surrogate", Z)
    best = strongest_baseline(evaluation, Z)
    lead = gain(evaluation, best, Z)
    against = f"{_percent(abs(lead))} {'below' if lead > 0 else 'ABOVE'} the strongest simple answer, the {best}"
    answer = f"One deployment takes {timing.inference.whole * MILLI:.2g} ms"
    faster = f"{answer} instead of {timing.simulation:.3g} s, {timing.speed_up:,.0f} times faster."
    sentences = [
        f"On {_runs(len(evaluation.test), 'unseen')} the surrogate misses z by {_mm(error.mean)} on average (root mean "
        f"square over nodes; 10 % of snapshots are below {_mm(error.p10)}, 10 % above {_mm(error.p90)}, the worst is "
        f"at {_mm(error.maximum)}). That is {against} ({_mm(evaluation.summary(best, Z).mean)}).",
        faster if timing.simulation else f"{answer}; how long the runs took is not known.",
        *_floor(evaluation),
    ]
    if not timing.simulation:
        return sentences
    if timing.break_even is None:
        sentences.append("The solver is so fast here that the surrogate never pays.")
    else:
        making = f"{_runs(len(evaluation.surrogate.runs), 'training')} and {timing.training:.2g} s of learning"
        sentences.append(f"Counting its {making}, it pays from {timing.break_even} deployments on.")
    return sentences


def _floor(evaluation):
    if (times := evaluation.over_floor(Z)) is not None:
        floor = evaluation.floor
        changes = ", ".join(f"{key} = {value}" for key, value in floor.changes.items())
        yield (
            f"No model could miss z by less than {_mm(floor.means[Z])}: so far are "
            f"{_runs(len(floor.runs), 'repeated')} from their mean when made again with {changes}. "
            f"The error is {times:.1f} floors."
        )


def weaknesses(evaluation: Evaluation) -> list[str]:
    """What a user should know before trusting the surrogate, most important first."""
    return [
        *_lost_comparisons(evaluation),
        *_left_out(evaluation),
        _worst_run(evaluation),
        *_worst_moments(evaluation),
        _source_of_error(evaluation),
        *_flattering_accuracy(evaluation),
        *_learning_curve(evaluation),
        *_coverage(evaluation),
        _spread(evaluation),
        *_intervals(evaluation),
        *_unseen(evaluation),
    ]


def _lost_comparisons(evaluation):
    for c, axis in enumerate(COMPONENTS):
        own = evaluation.summary("surrogate", c).mean
        for name in BASELINES:
            mean = evaluation.summary(name, c).mean
            if mean and own >= mean:
                yield f"In {axis} the surrogate does not beat the {name}: {_mm(own)} against {_mm(mean)}."


def _worst_run(evaluation):
    parameters, by_run = evaluation.surrogate.parameters, _z(evaluation).mean(axis=1)
    worst = int(by_run.argmax())
    design = zip(parameters, evaluation.design[worst], strict=True)
    values = ", ".join(f"{p.label} {value:.4g} {p.unit}".rstrip(" -") for p, value in design)
    if len(by_run) == 1:
        return f"There is one unseen run, {evaluation.test[0]}: nothing shows how much errors differ between runs."
    text = (
        f"The worst unseen run is {evaluation.test[worst]} with a mean z RMSE of {_mm(by_run[worst])}, "
        f"{by_run[worst] / np.median(by_run):.1f} times the median run ({values})."
    )
    if len(by_run) < 8:
        return text
    ranks = [spearmanr(column, by_run) for column in evaluation.design.T]
    leading = min(range(len(ranks)), key=lambda k: ranks[k].pvalue)
    # The strongest of several correlations is chosen, so chance has as many tries (Bonferroni).
    if ranks[leading].pvalue * len(ranks) > 0.05:
        return text + f" {len(by_run)} unseen runs do not show a single parameter to be the cause."
    side = "high" if ranks[leading].statistic > 0 else "low"
    correlation = f"rank correlation {ranks[leading].statistic:.2f}"
    return text + f" Errors are larger where {parameters[leading].label} is {side} ({correlation})."


def _worst_moments(evaluation):
    z = _z(evaluation)
    by_time = z.mean(axis=0)
    worst = int(by_time.argmax())
    yield (
        f"The worst moment is {_ms(evaluation, worst)}: the mean z RMSE is {_mm(by_time[worst])} there, "
        f"{by_time[worst] / by_time.mean():.1f} times its average over time."
    )
    run, step = np.unravel_index(z.argmax(), z.shape)
    yield (
        f"Means hide a tail: the worst snapshot (run {evaluation.test[run]} at {_ms(evaluation, step)}) has a z RMSE "
        f"of {_mm(z.max())}, {z.max() / z.mean():.1f} times the mean."
    )


def _source_of_error(evaluation):
    advice = {"more runs would help, more modes would not": [], "both matter": [], "more modes would help": []}
    shares = {axis: evaluation.regression_share(c) for c, axis in enumerate(COMPONENTS)}
    parts = [f"{_percent(share)} in {axis}" for axis, share in shares.items()]
    for axis, share in shares.items():
        list(advice.values())[0 if share > 0.75 else 1 if share > 0.25 else 2].append(axis)
    told = "; ".join(f"in {', '.join(axes)} {what}" for what, axes in advice.items() if axes)
    return f"Part of the squared error that is regression, not truncation: {', '.join(parts)}. So {told}."


def _flattering_accuracy(evaluation):
    length = evaluation.reference_length
    if length > 0.0:
        own, still = (accuracy(evaluation.summary(n, Z).mean, length) for n in ("surrogate", MEAN_TRAJECTORY))
        yield (
            f"The paper's accuracy (l_ref - RMSE) / l_ref with l_ref = {length:g} m is {_percent(own, 1)} in z, but "
            f"it flatters: the {MEAN_TRAJECTORY}, which ignores the design, reaches {_percent(still, 1)}."
        )


def _learning_curve(evaluation):
    curve, now = evaluation.learning_curve(Z), len(evaluation.surrogate.runs)
    if curve is not None:
        text = f"From {curve.runs[0]} to {curve.runs[-1]} training runs the mean z RMSE went from "
        text += f"{_mm(curve.errors[0])} to {_mm(curve.errors[-1])}"
        gained = curve.per_doubling
        if not curve.tells:
            yield text + ". So few runs do not show what more of them would bring."
        elif gained > 0.1:
            text += f": with every doubling it fell by {_percent(gained)}. "
            yield text + f"If this continues, {2 * now} runs instead of {now} would bring about {_mm(curve.doubled)}."
        elif gained > 0.0:
            yield text + f": with every doubling it fell by only {_percent(gained, 1)}. More runs would help little."
        else:
            yield text + ": more runs did not lower it. Look for another cause than their number."
    if now < 100:
        axes = len(evaluation.surrogate.parameters)
        yield f"{now} training runs in {axes} dimensions are few; the ROM paper used 100 to 400."


def _coverage(evaluation):
    coverage = evaluation.coverage
    far = int((coverage.nearest > coverage.between).sum())
    yield (
        f"{far} of {len(coverage.nearest)} unseen designs are farther from the nearest training design than training "
        f"designs are on average (the farthest {coverage.nearest.max() / coverage.between:.1f} times as far). Every "
        "unseen design lies inside the trained ranges; the behaviour outside is not measured."
    )
    ranges = zip(evaluation.surrogate.parameters, coverage.ranges, strict=True)
    narrow = [f"{p.label} ({_percent(part)})" for p, part in ranges if part < 0.9]
    if narrow:
        yield f"Training designs do not cover the whole range of {', '.join(narrow)}: its ends are extrapolations."


def _spread(evaluation):
    if evaluation.spread is None:
        return "This recipe has one network per coefficient, so its uncertainty is not known."
    error = np.square(evaluation.errors["surrogate"]).sum(axis=2)
    expected = np.square(evaluation.spread).sum(axis=2) + np.square(evaluation.errors["truncation"]).sum(axis=2)
    ratio = np.sqrt(error.mean() / expected.mean())
    size = "too small" if ratio > 1 else "too large"
    text = f"The ensemble's own spread, with truncation, is {size} as an error bar: the true error is "
    text += f"{ratio:.1f} times as large."
    if len(error) >= 8:
        rank = spearmanr(error.mean(axis=1), expected.mean(axis=1)).statistic
        text += f" It ranks unseen runs by error with a rank correlation of {rank:.2f}."
    return text


def _intervals(evaluation):
    for check in evaluation.intervals:
        if np.isclose(check.level, 0.9):
            parts = ", ".join(
                f"{_percent(part)} in {axis} (± {_mm(width)} on average)"
                for part, width, axis in zip(check.covered, check.half_width, COMPONENTS, strict=True)
            )
            yield (
                f"Intervals of nominally 90 % hold {parts} of the unseen values. They are a "
                f"statement about all values together: of the worst run they hold {_percent(check.worst_run[Z])} in z."
            )


def _unseen(evaluation):
    by_run = _z(evaluation).mean(axis=1)
    if len(by_run) > 1:
        error = _mm(by_run.std(ddof=1) / np.sqrt(len(by_run)))
        yield f"With {len(by_run)} unseen runs the mean z RMSE itself is known to ±{error} (standard error over runs)."
    yield from evaluation.unseen.sentences()
    missing = [run for run in evaluation.missing if run not in evaluation.left_out.why]
    if missing:
        named = ", ".join(missing[:5]) + ", ..." * (len(missing) > 5)
        yield (
            f"{_runs(len(missing), 'unseen')} of the design are missing ({named}). "
            "If they failed for a reason of physics, the errors above leave out the hardest cases."
        )


def _left_out(evaluation):
    lost = evaluation.left_out
    if lost.why:
        count, part = _runs(len(lost.why), "training"), _percent(lost.part, 1)
        text = f"Not learned from: {count}, {part} of the design, because {lost.reasons()}."
        if lost.leaning:
            where = " and ".join(f"{label} is {side}" for label, side in lost.leaning.items())
            text += f" They lie where {where}: the surrogate is biased, and may be wrong exactly there."
        elif lost.biased:
            text += " What remains is not the design that was drawn: the surrogate may be biased."
        yield text


def _z(evaluation) -> np.ndarray:
    """RMSE in z of the surrogate: [m], (runs, times)."""
    return evaluation.errors["surrogate"][:, :, Z]


def _ms(evaluation, step) -> str:
    return f"{evaluation.surrogate.times[step] * MILLI:.3g} ms"


def _runs(count, kind):
    return f"{count} {kind} run{'s' * (count != 1)}"


def _percent(part, digits=0) -> str:
    return f"{100 * part:.{digits}f} %"


def _mm(metres) -> str:
    return f"{metres * MILLI:.3g} mm"
