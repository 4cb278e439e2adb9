"""Prints the fingerprint of a short deployment for each number of threads given; a test runs this in a process."""

from __future__ import annotations

import sys
import warnings

import numba
from free_scene import fingerprint

import billow.base.compiled
from billow.case.build import build_model
from billow.case.schema import Case
from billow.solver.run import Schedule, run

if __name__ == "__main__":
    warnings.simplefilter("ignore", numba.NumbaPerformanceWarning)
    billow.base.compiled.PARALLEL_FROM = 0  # every kernel with the parallel compilation, however small the mesh
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.02},  # several chunks of triangles and of nodes
            "fabric": {"permeability": 0.03},
            "obstacles": [
                {"shape": "plate"},
                {
                    "shape": "super-ellipsoid",
                    "clearance": 0.003,
                    "degree": 3.0,
                    "locked": False,
                    "velocity": [0, 0, -20],
                },
            ],
        }
    )
    model = build_model(case)
    for threads in map(int, sys.argv[1:]):
        numba.set_num_threads(threads)
        state = run(model, Schedule(4e-4, 2, 1))
        print(threads, state.step, state.bodies.contact.deepest[1] > 0.0, fingerprint(state))
