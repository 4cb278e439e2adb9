"""How many processor cores this process may use."""

from __future__ import annotations

import contextlib
import math
import os
from pathlib import Path

GROUPS, OWN_GROUPS = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def available_cores() -> int:
    """Cores that this process may run on, or as many as the processor time its container is given makes up."""
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(allowed, math.floor(_quota())))


def _quota() -> float:
    """Seconds of processor time per second, the least of the process's control groups (Linux, versions 1 and 2) and all
    groups around them; without a limit, more than any machine has."""
    found = [math.inf]
    with contextlib.suppress(OSError):  # another system
        for line in OWN_GROUPS.read_text(encoding="utf-8").splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers and "cpu" not in controllers.split(","):
                continue
            top = GROUPS / "cpu" if controllers else GROUPS
            group = top / path.lstrip("/")
            found += [_limit(folder) for folder in (group, *group.parents) if folder.is_relative_to(top)]
    least = min(found)
    return least if least < math.inf else 1e9


def _limit(group: Path) -> float:
    """Of one control group: cpu.max holds "quota period" or "max period"; version 1 has a file for each, -1 without."""
    with contextlib.suppress(OSError, ValueError):
        if (group / "cpu.max").is_file():
            quota, period = (group / "cpu.max").read_text(encoding="utf-8").split()
            return math.inf if quota == "max" else float(quota) / float(period)
        quota, period = ((group / f"cpu.cfs_{which}_us").read_text(encoding="utf-8") for which in ("quota", "period"))
        return float(quota) / float(period) if float(quota) > 0.0 else math.inf
    return math.inf
