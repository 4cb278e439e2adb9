"""Everything Billow refuses or stops for, as one family.

    BillowError
    ├── InputError       exit 2   what the user wrote cannot be used
    ├── NumericalStop    exit 3   a run became meaningless and was stopped
    ├── ResourceError    exit 4   disk, memory, worker processes
    └── IntegrityError   exit 5   a file is damaged or does not belong to its manifest

Every error answers four questions: what happened, where, why, and what to try. `str(error)` is the text a
user sees; the command line prints it and exits with `exit_code`, without a traceback.

All texts of a code stand in one declaration, in the module that raises it; docs/errors.md is made from the
declarations. A code keeps its meaning, and one that is no longer used is never given to something else.

    UNKNOWN_GAS = InputError.declare("E-GAS-001", "unknown gas {name!r}", remedy="use one of {known}")
    raise UNKNOWN_GAS(where="inflator.gas", why="there are no data for it", name=name, known=", ".join(SPECIES))

A `Concern` says the same of a case that can be run but is probably not what was meant; its codes begin with W.
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from typing import Any

LONGEST_TEXT = 500
"""Characters of one part of a message; longer ones lose their middle."""


@dataclass(frozen=True)
class Code:
    """One error code with all its texts; call it to make the error.

    kind: class of what it makes. what, where, why, remedy: templates; `{name}` stands for a value that the raise gives;
    an empty where or why is given whole by every raise. cause: what usually leads here, for the page only.
    """

    kind: type
    code: str
    what: str
    where: str = ""
    why: str = ""
    remedy: str = ""
    cause: str = ""

    def __call__(self, **given: Any) -> Any:
        """An error or concern.

        given: values of the placeholders, and any of what, where, why and remedy that this raise says better; they are
        not templates, so they may hold what a user wrote. None: the declared text. An exception: its reason.
        """
        given = {name: _reason(value) if isinstance(value, Exception) else value for name, value in given.items()}
        texts = {
            part: getattr(self, part).format(**given) if given.get(part) is None else str(given[part])
            for part in ("what", "where", "why", "remedy")
        }
        return self.kind(self.code, **texts)


_NUMBER_OF_ERROR = re.compile(r"\[Errno -?\d+\] ")
"""What Python puts before the words of the operating system."""

CODES: dict[str, Code] = {}
"""The codes of all modules imported so far."""


class _Message:
    """What errors and concerns share: their codes are declared, and they are printed alike."""

    word = "error"

    @classmethod
    def declare(cls, code: str, what: str, *, remedy: str, where: str = "", why: str = "", cause: str = "") -> Code:
        """A new code (see `Code`). Raises ValueError if another declaration has it."""
        made = Code(cls, code, what, where, why, remedy, cause)
        if CODES.setdefault(code, made) != made:
            raise ValueError(f"{code} is declared twice")
        return made

    def __str__(self) -> str:
        first = f"{self.code} {self.word}: {self.what}"
        return f"{first}\n  where: {self.where}\n  why:   {self.why}\n  try:   {self.remedy}"


class BillowError(_Message, Exception):
    """Base of the family.

    code: stable identifier such as "E-CASE-003"; what, where, why, remedy: one short text each.
    """

    exit_code = 70

    def __init__(self, code: str, what: str, *, where: str, why: str, remedy: str):
        super().__init__(code, what)
        self.code = code
        self.what, self.where, self.why, self.remedy = map(_in_one_line, (what, where, why, remedy))

    def __reduce__(self):
        # Errors travel back from worker processes; keyword-only arguments need telling how.
        texts = {"where": self.where, "why": self.why, "remedy": self.remedy}
        return functools.partial(type(self), self.code, self.what, **texts), ()


@dataclass(frozen=True)
class Concern(_Message):
    """What is odd about a case that can be run: a code, what it is, where, why it matters, and what to try."""

    word = "warning"

    code: str
    what: str
    where: str
    why: str
    remedy: str


def shown(value: object) -> str:
    """A value a user gave as a message shows it: short things as they are, others by their type."""
    # Python refuses to write integers of more than 4,300 digits.
    if isinstance(value, bool):
        return "true" if value else "false"
    plain = isinstance(value, (float, str)) or (isinstance(value, int) and abs(value) < 10**80)
    kinds = {"dict": "a table", "list": "a list", "tuple": "a list", "NoneType": "nothing", "int": "a huge number"}
    name = type(value).__name__
    return repr(value)[:80] if plain else kinds.get(name, f"a {name}")


def _in_one_line(text: str) -> str:
    """Text as it is safe to print: what files and users wrote may hold control characters, and have any length."""
    text = _NUMBER_OF_ERROR.sub("", text)
    if len(text) > LONGEST_TEXT:
        text = f"{text[: LONGEST_TEXT // 2]} ... {text[-LONGEST_TEXT // 2 :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _reason(error: Exception) -> str:
    """Why an exception was raised, without the number and path that Python adds."""
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    if isinstance(error, KeyError):
        return f"a key is missing: {error}"
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


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
