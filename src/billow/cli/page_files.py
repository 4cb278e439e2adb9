"""Where pages go: only an earlier page of Billow's is replaced."""

from __future__ import annotations

from pathlib import Path

from billow.base.errors import InputError

NO_PAGE_NAME = InputError.declare(
    "E-PAG-002",
    "no page can be written as {name!r}",
    where="--out",
    why="pages are HTML",
    remedy="give a name that ends in .html",
)


def check_page_name(out: Path) -> None:
    """InputError E-PAG-002 unless the name is that of a page."""
    if out.suffix.lower() not in (".html", ".htm"):
        raise NO_PAGE_NAME(name=out.name[-40:])


def write_page(out: Path, text: str, quiet: bool = False) -> None:
    """Write a page, whose folder is made, and say so unless `quiet`. Errors as `check_page_name` and `owned_file`."""
    from billow.pages.html import SIGN
    from billow.results.atomic import write_atomically
    from billow.results.ownership import owned_file

    check_page_name(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    with owned_file(out, SIGN):
        write_atomically(out, text)
    if not quiet:
        print(f"{out}: {len(text.encode()) / 1e6:.1f} MB; open it in a browser")
