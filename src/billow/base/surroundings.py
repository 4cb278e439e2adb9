"""What surrounds a process and must not decide how kernels are compiled and run: the variables of numba and OpenMP."""

from __future__ import annotations

import os

MOST_THREADS = 1024
"""Threads that may be asked for; a system may not start more, and numba then ends the process."""


def own_compiler() -> None:
    """Take away what would make numba compile in another way, and what it cannot read; before it is imported.

    The number of threads stays: results do not depend on it. numba reads its environment again whenever that changes,
    so what we ask of it must stand there, too.
    """
    for name in [name for name in os.environ if name.startswith(("NUMBA_", "LLVMLITE_"))]:
        value = os.environ[name]
        if name != "NUMBA_NUM_THREADS" or not (value.isdecimal() and 0 < int(value[:9]) <= MOST_THREADS):
            del os.environ[name]
    # Vector math of another library would change last bits between machines.
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"
    # Threads that have nothing to do sleep, after looking for work 3,000 times, some microseconds. When they spin for
    # long, a run beside other programs costs ten times its processor time: each waits for one that the system has set
    # aside, and keeps a core busy with it. When they sleep at once, waking them between the passes of a step costs what
    # two threads gain. libgomp reads the number, others the policy.
    os.environ["GOMP_SPINCOUNT"] = "3000"
    os.environ["OMP_WAIT_POLICY"] = "passive"
