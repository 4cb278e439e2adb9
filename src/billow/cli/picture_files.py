"""Where pictures go: the format follows the name, and only an earlier picture of Billow's is replaced."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from billow.base.errors import InputError

UNKNOWN_FORMAT = InputError.declare(
    "E-PIC-008",
    "no picture can be written as {name!r}",
    where="billow {command} --out",
    why="the name says the format; it may end in {known}",
    remedy="give a name with one of these endings",
)

STILLS, FILMS = ("png", "svg", "pdf"), ("gif", "mp4")
SIGN = b"Billow"
"""What the files of all these formats hold."""


def picture_kind(out: Path, command: str, known: Sequence[str] = STILLS) -> str:
    """The format of a picture, by the end of its name. InputError E-PIC-008."""
    kind = out.suffix.lower().removeprefix(".")
    if kind not in known:
        raise UNKNOWN_FORMAT(name=out.name[-40:], command=command, known=", ".join(f".{end}" for end in known))
    return kind


@contextlib.contextmanager
def picture_at(out: Path) -> Iterator[None]:
    """Where a picture is made and written to `out`, whose folder is made. Errors as `owned_file`."""
    from billow.results.ownership import owned_file

    out.parent.mkdir(parents=True, exist_ok=True)
    with owned_file(out, SIGN):
        yield
