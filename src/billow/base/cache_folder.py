"""Where lies what later processes need not make again: compiled kernels and triangulations."""

from __future__ import annotations

import os


def cache_folder() -> str | None:
    """BILLOW_CACHE, or `billow` in the user's cache; None without a home: "~" would become a folder of that name."""
    own = os.path.expanduser(os.environ.get("BILLOW_CACHE", ""))
    if own and not own.startswith("~"):
        return os.path.abspath(own)
    home = os.environ.get("XDG_CACHE_HOME", "")
    home = home if os.path.isabs(home) else os.path.expanduser("~/.cache")
    return os.path.join(home, "billow") if os.path.isabs(home) else None
