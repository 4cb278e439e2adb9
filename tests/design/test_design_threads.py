"""Surfaces and optima have the same bits on one thread of BLAS and on two."""

import os
import subprocess
import sys

ASKED = """
import hashlib
import numpy as np
from billow.design.gaussian_process import Axes, GaussianProcess
from billow.design.surfaces import ResponseSurfaces
from trust.small_surfaces import small_table

surfaces = ResponseSurfaces.learn(small_table(40, noise=1.0))
best = surfaces.optimise(minimise="hard", below={"pressure": 50.0}, seed=1)
parts = [list(best.design.values()), best.generations, surfaces.sensitivity("hard", samples=64).total]
parts += [surface.factors for surface in surfaces.surfaces] + [surfaces.surfaces[1].process.log_lengths]
random = np.random.default_rng(0)  # of so many runs BLAS uses its threads
points = random.random((250, 3))
values = np.sin(3.0 * points[:, 0]) + points[:, 1] * points[:, 2] + 0.05 * random.standard_normal(250)
process = GaussianProcess.fit(Axes((0, 0, 0)), points, values)
parts += [process.log_lengths, *process.predict(random.random((500, 3)))]
print(*(hashlib.sha256(np.array(part, float).tobytes()).hexdigest() for part in parts))
"""


def test_one_and_two_threads_give_the_same_bits():
    told = []
    for threads in ("1", "2"):
        count = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), threads)
        done = subprocess.run([sys.executable, "-c", ASKED], env=os.environ | count, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        told.append(done.stdout)
    assert told[0] == told[1]
