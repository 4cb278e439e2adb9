"""Billow: airbag deployment and the reduced-order model learned from it.

    import billow
    case = billow.Case.load("driver.toml")
    result = billow.simulate(case, "runs/driver")      # or billow.Run.load("runs/driver")
    result.plot("pressure")
    study = billow.Study.open("my_study")
    surrogate = billow.train(study.dataset())

More of each: help(billow.Case), help(billow.simulate), and so on; commands: python -m billow --help.

Names are imported on first use, so that `import billow` loads neither compiled kernels nor torch. It takes numba's
variables out of the environment: kernels are compiled in one way only.
"""

from billow.base.surroundings import own_compiler

own_compiler()

__version__ = "0.1.0"

_HOME = {
    "Case": "billow.case.schema",
    "simulate": "billow.run.simulate",
    "Result": "billow.results.result",
    "Run": "billow.results.result",
    "Study": "billow.study.study",
    "Dataset": "billow.results.dataset",
    "Surrogate": "billow.rom.surrogate.surrogate",
    "Recipe": "billow.rom.learn.train",
    "train": "billow.rom.learn.train",
    "ResponseSurfaces": "billow.design.surfaces",
    "BillowError": "billow.base.errors",
}


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'billow' has no attribute {name!r}")
    import importlib

    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value  # a function named like its module must win over the submodule
    return value


def __dir__():
    return sorted([*globals(), *_HOME])
