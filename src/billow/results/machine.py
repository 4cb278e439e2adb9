"""The machine numbers were taken on."""

from __future__ import annotations

import contextlib
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


def peak_memory() -> float:
    """Most memory [MB] that this process has held since it began; 0 where the system does not say."""
    with contextlib.suppress(OSError, StopIteration), open("/proc/self/status", encoding="utf-8") as file:
        return 1.024e-3 * next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    with contextlib.suppress(ImportError):
        import resource  # not on Windows

        return 1e-6 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # [bytes] on macOS
    return 0.0
