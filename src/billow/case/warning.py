"""What a user is told of a case that is allowed but probably not meant."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Warning:
    """One finding: a stable code, what is odd, where, why it matters, and what to try."""

    code: str
    what: str
    where: str
    why: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.code} warning: {self.what}\n  where: {self.where}\n  why:   {self.why}\n  try:   {self.remedy}"
