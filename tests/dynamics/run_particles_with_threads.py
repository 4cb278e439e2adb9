"""Prints the fingerprint of a short deployment with the corpuscular gas for each number of threads given."""

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
    billow.base.compiled.PARALLEL_FROM = 0  # every kernel with the parallel compilation
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.035, "initial_gap": 0.04},
            "fabric": {"permeability": 0.03},
            "gas": {"model": "corpuscular", "particles": 20_000},  # several chunks of particles from the start
        }
    )
    model = build_model(case)
    for threads in map(int, sys.argv[1:]):
        numba.set_num_threads(threads)
        state = run(model, Schedule(6e-4, 2, 1))
        print(threads, state.step, state.gas.content.gas_step, state.gas.content.particles.count, fingerprint(state))
