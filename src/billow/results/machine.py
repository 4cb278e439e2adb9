"""The machine numbers were taken on."""

from __future__ import annotations

import os
import platform


def machine() -> dict[str, str | int]:
    """What a timing may depend on: processor, architecture, cores, system, Python."""
    return {
        "processor": _processor(),
        "machine": platform.machine(),
        "cores": os.cpu_count() or 1,
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"
