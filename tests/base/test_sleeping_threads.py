"""What `import billow` sets before the compiler and its threads start."""

import os
import subprocess
import sys


def test_threads_that_have_nothing_to_do_sleep_after_a_short_look():
    """Spinning threads cost a run beside two busy programs 16 times the processor time of one thread, sleeping ones
    1.05 times (400 steps of 24,096 triangles)."""
    both = "os.environ['OMP_WAIT_POLICY'], os.environ['GOMP_SPINCOUNT']"
    ask = f"import os; from billow.cli.surroundings import settle; settle(); print({both})"
    for asked in ({}, {"OMP_WAIT_POLICY": "active", "GOMP_SPINCOUNT": "999999999"}):
        told = subprocess.run(
            [sys.executable, "-c", ask], env={**os.environ, **asked}, capture_output=True, text=True, check=True
        )
        assert told.stdout.split() == ["passive", "3000"]
