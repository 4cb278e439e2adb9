"""Everything Billow refuses or stops for, as one family.

    BillowError
    ├── InputError       exit 2   what the user wrote cannot be used
    ├── NumericalStop    exit 3   a run became meaningless and was stopped
    ├── ResourceError    exit 4   disk, memory, worker processes
    └── IntegrityError   exit 5   a file is damaged or does not belong to its manifest

Every error answers four questions: what happened, where, why, and what to try. `str(error)` is the text a
user sees; the command line prints it and exits with `exit_code`, without a traceback.
"""

from __future__ import annotations

from dataclasses import dataclass

LONGEST_TEXT = 500
"""Characters of one part of a message; longer ones lose their middle."""


class BillowError(Exception):
    """Base of the family.

    code: stable identifier such as "E-CASE-003"; what, where, why, remedy: one short text each.
    """

    exit_code = 70

    def __init__(self, code: str, what: str, *, where: str, why: str, remedy: str):
        super().__init__(code, what)
        self.code = code
        self.what, self.where, self.why, self.remedy = map(_in_one_line, (what, where, why, remedy))

    def __str__(self) -> str:
        return f"{self.code} error: {self.what}\n  where: {self.where}\n  why:   {self.why}\n  try:   {self.remedy}"

    def __reduce__(self):
        # Errors travel back from worker processes; keyword-only arguments need telling how.
        return (_rebuild, (type(self), self.code, self.what, self.where, self.why, self.remedy))


def shown(value: object) -> str:
    """A value a user gave as a message shows it: short things as they are, others by their type."""
    # Python refuses to write integers of more than 4,300 digits.
    plain = isinstance(value, (float, str)) or (isinstance(value, int) and abs(value) < 10**80)
    return repr(value)[:80] if plain else type(value).__name__


def _in_one_line(text: str) -> str:
    """Text as it is safe to print: what files and users wrote may hold control characters, and have any length."""
    if len(text) > LONGEST_TEXT:
        text = f"{text[: LONGEST_TEXT // 2]} ... {text[-LONGEST_TEXT // 2 :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _rebuild(kind, code, what, where, why, remedy):
    return kind(code, what, where=where, why=why, remedy=remedy)


class InputError(BillowError):
    """What the user wrote cannot be used."""

    exit_code = 2


class NumericalStop(BillowError):
    """A run became meaningless and was stopped. nodes: indices of the first bad nodes, if it has a place."""

    exit_code = 3
    nodes: tuple[int, ...] = ()


class ResourceError(BillowError):
    """Disk, memory or worker processes ran out."""

    exit_code = 4


class IntegrityError(BillowError):
    """A file is damaged or does not belong to its manifest."""

    exit_code = 5


@dataclass(frozen=True)
class Concern:
    """What is allowed but probably not meant: a stable code, what is odd, where, why it matters, and what to try."""

    code: str
    what: str
    where: str
    why: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.code} warning: {self.what}\n  where: {self.where}\n  why:   {self.why}\n  try:   {self.remedy}"
