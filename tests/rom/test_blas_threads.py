"""Answers work on one thread, whatever the number of threads that BLAS has otherwise, and leave that as it was."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from billow.base.blas_threads import _openblas

COUNTS = """
import json, threading
from billow.base.blas_threads import _openblas, one_blas_thread
count, found = _openblas().count, []
inside, leave = threading.Barrier(3), threading.Event()

def stay():
    with one_blas_thread():
        inside.wait()
        leave.wait()

@one_blas_thread()
def answer():
    return count()

found.append(count())
found.append(answer())
others = [threading.Thread(target=stay) for _ in range(2)]
for other in others:
    other.start()
inside.wait()
found.append(answer())
found.append(count())
leave.set()
for other in others:
    other.join()
found.append(count())
print(json.dumps(found))
"""

ANSWERS = """
import json, sys, time
from billow.rom.surrogate.surrogate import Surrogate
surrogate = Surrogate.load(sys.argv[1])
middle = [0.5 * (p.low + p.high) for p in surrogate.parameters]
asked = [lambda: surrogate.predict([middle] * 16), lambda: surrogate.coefficients([middle] * 64),
         lambda: list(surrogate.predict_each([middle] * 64))]
shares = []
for ask in asked:
    best = 9.0
    for _ in range(4):  # threads that something else has used wait, spinning, for a while
        whole, mine = time.process_time(), time.thread_time()
        for _ in range(30):
            ask()
        best = min(best, (time.process_time() - whole) / (time.thread_time() - mine))
    shares.append(best)
print(json.dumps(shares))
"""


def told(program: str, *arguments: str) -> list[float]:
    variables = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], env=variables, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


@pytest.mark.skipif(_openblas() is None, reason="NumPy has another BLAS here")
def test_the_number_of_threads_is_one_within_and_as_before_when_all_have_left():
    before, alone, beside, still, after = told(COUNTS)
    assert (alone, beside, still) == (1, 1, 1)
    assert after == before


def test_no_other_thread_works_on_an_answer(surrogate, tmp_path):
    """Processor time of the process is that of the thread that asks."""
    path = surrogate.save(tmp_path / "surrogate.safetensors")
    assert max(told(ANSWERS, str(path))) < 1.1
