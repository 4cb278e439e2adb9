"""The verdict on a learned model: its errors on runs it had not seen, beside those of answers that need no learning.

Every model carries the latest one in its file, and says it with every answer. A model that loses a comparison does not
answer until it is told to.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from billow.base.errors import InputError

WORSE = InputError.declare(
    "E-ROM-023",
    "the model is worse than an answer that needs no learning",
    where="{model}",
    cause="too few training runs for what the design changes",
    remedy="learn from more runs, or insist: --despite-verdict, in Python model.despite_verdict()",
)

HELD_OUT, UNSEEN = "training runs, each held out in turn", "unseen runs"
"""What a model was judged on."""


@dataclass(frozen=True)
class Comparison:
    """One measure of the model (`own`) and of a simple answer (`other`).

    measure: what is compared, with its unit; answer: name of the simple answer; ignores_design: True if that is the
    same for every design; higher: True if larger is better
    """

    measure: str
    answer: str
    own: float
    other: float
    ignores_design: bool
    higher: bool = False

    @property
    def lost(self) -> bool:
        """True if the model is not better; no model can be better than an answer without any error."""
        if self.higher:
            return not self.own > self.other
        return not (self.own < self.other or self.other == 0.0)


@dataclass(frozen=True)
class Judgement:
    """How a model did on runs it had not seen: `runs` of them, `on` `HELD_OUT` or `UNSEEN`."""

    on: str
    runs: int
    comparisons: tuple[Comparison, ...]

    @property
    def lost(self) -> tuple[Comparison, ...]:
        """Comparisons that the model did not win."""
        return tuple(comparison for comparison in self.comparisons if comparison.lost)

    def __str__(self) -> str:
        lost = self.lost
        worse = "ignoring the design" if any(one.ignores_design for one in lost) else ", ".join(o.answer for o in lost)
        on = self.on.replace("runs", "run", 1) if self.runs == 1 else self.on
        told = f"judged on {self.runs} {on}: " + (f"worse than {worse}" if lost else "better than simple answers")
        numbers: dict[tuple[str, float], list[str]] = {}
        for one in lost or self.comparisons:
            numbers.setdefault((one.measure, one.own), []).append(f"{one.other:.3g} ({one.answer})")
        return "; ".join([told, *(f"{m} {own:.3g} against {', '.join(of)}" for (m, own), of in numbers.items())])

    def record(self) -> dict:
        """Plain JSON, as `judgement_of` reads it."""
        return {"on": self.on, "runs": self.runs, "comparisons": [asdict(one) for one in self.comparisons]}


def judgement_of(record: object) -> Judgement | None:
    """What `record` says, None if it is None. TypeError, KeyError or ValueError if it is no judgement."""
    if record is None:
        return None
    comparisons = tuple(Comparison(**entry) for entry in record["comparisons"])
    found = Judgement(record["on"], record["runs"], comparisons)
    kinds = {"own": float, "other": float, "measure": str, "answer": str, "ignores_design": bool, "higher": bool}
    fits = all(type(getattr(one, name)) is kind for one in comparisons for name, kind in kinds.items())
    if found.on not in (HELD_OUT, UNSEEN) or type(found.runs) is not int or not comparisons or not fits:
        raise ValueError("its judgement cannot be read")
    if not all(math.isfinite(number) for one in comparisons for number in (one.own, one.other)):
        raise ValueError("its judgement is not finite")
    return found


def require_won(judgement: Judgement | None, model: object) -> None:
    """InputError E-ROM-023 if the model lost a comparison. A model that nobody judged may answer; it says so."""
    if judgement is not None and judgement.lost:
        raise WORSE(model=repr(model), why=judgement)
