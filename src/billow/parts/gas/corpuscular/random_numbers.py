"""Random numbers that depend on names, not on history: (seed, step, particle, event) in, number out.

    key = stream(seed + PURPOSE, step, particle)      # PURPOSE: so that no two uses share numbers within a step
    u, w = uniform(key, 0), normal(key, 1)            # event 0, 1, 2, ...: independent numbers

Many numbers of one name, such as those of all collisions in a cell, are cheaper as a sequence:

    u, key = next_uniform(key)                        # the key becomes the state of SplitMix64

The bits are the same for any number of threads, in any order, and after a restart. The hash is the finalizer of
SplitMix64 (Steele, Lea, Flood, OOPSLA 2014, with the constants of Stafford's variant 13), once per part of the name.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S12 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(12)
_ONE = np.uint64(1)
_UNIT = 2.0**-52

_LAYER = np.uint64(127)
_AREA = 9.91256303526217e-3
"""Of each of 128 layers below exp(-x^2/2): the lowest one holds the tail beyond 3.4426, too (Doornik 2005)."""


def _edges() -> np.ndarray:
    """Right ends of the layers, from the lowest up, (129,)."""
    edges = [0.0, 3.442619855899]
    edges[0] = _AREA * math.exp(0.5 * edges[1] ** 2)
    while len(edges) < 128:
        edges.append(math.sqrt(-2.0 * math.log(_AREA / edges[-1] + math.exp(-0.5 * edges[-1] ** 2))))
    return np.array([*edges, 0.0])


_EDGE = _edges()
_RATIO = _EDGE[1:] / _EDGE[:-1]


@scalar
def _mix(z):
    z = (z ^ (z >> _S30)) * _FIRST
    z = (z ^ (z >> _S27)) * _SECOND
    return z ^ (z >> _S31)


@scalar
def stream(seed, step, particle):
    """Key (uint64) of one particle in one step; all arguments are non-negative integers below 2^63."""
    z = _mix(np.uint64(seed) + _GOLDEN)
    z = _mix((z ^ np.uint64(step)) + _GOLDEN)
    return _mix((z ^ np.uint64(particle)) + _GOLDEN)


@scalar
def _bits(key, event, draw):
    """64 random bits; one event may need several draws."""
    return _mix(_mix(key ^ (np.uint64(event) * _GOLDEN + _ONE)) + np.uint64(draw) * _GOLDEN)


@scalar
def _open_unit(bits):
    """The 52 highest bits as a number in the open interval (0, 1), so that its logarithm is finite."""
    return (np.float64(bits >> _S12) + 0.5) * _UNIT


@scalar
def uniform(key, event):
    """Uniform on the open interval (0, 1)."""
    return _open_unit(_bits(key, event, 0))


@scalar
def _normal(key, event, draw):
    radius = math.sqrt(-2.0 * math.log(_open_unit(_bits(key, event, draw))))
    return radius * math.cos(2.0 * math.pi * _open_unit(_bits(key, event, draw + 1)))


@scalar
def normal(key, event):
    """Standard normal (Box and Muller 1958)."""
    return _normal(key, event, 0)


@scalar
def gamma(key, event, shape):
    """Gamma distributed with unit scale and any real shape >= 0; shape 0 gives 0.

    Marsaglia and Tsang, "A simple method for generating gamma variables", ACM TOMS 26 (2000); shapes below one by
    Gamma(a) = Gamma(a + 1) U^(1/a).
    """
    if shape <= 0.0:
        return 0.0
    raised = shape if shape >= 1.0 else shape + 1.0
    d = raised - 1.0 / 3.0
    c = 1.0 / math.sqrt(9.0 * d)
    draw = 0
    while True:
        x = _normal(key, event, draw)
        u = _open_unit(_bits(key, event, draw + 2))
        draw += 3
        v = (1.0 + c * x) ** 3
        if v > 0.0 and u < 1.0 - 0.0331 * x**4:  # a cheap test; whenever it is true, so is the exact one below
            break
        if v > 0.0 and math.log(u) < 0.5 * x * x + d - d * v + d * math.log(v):
            break
    if shape < 1.0:
        return d * v * _open_unit(_bits(key, event, draw)) ** (1.0 / shape)
    return d * v


@scalar
def next_uniform(state):
    """Uniform on the open interval (0, 1), and the next state: one hash a number."""
    state = state + _GOLDEN
    return _open_unit(_mix(state)), state


@scalar
def next_normal(state):
    """Standard normal, and the next state: one hash, one product and one comparison for 99 of 100.

    Ziggurat of 128 layers of equal area, Marsaglia and Tsang, J. Stat. Softw. 5 (2000), in the variant of Doornik
    (2005), whose layer and place within it come from bits that nothing else uses.
    """
    while True:
        state = state + _GOLDEN
        bits = _mix(state)
        layer, u = bits & _LAYER, 2.0 * _open_unit(bits) - 1.0
        x = u * _EDGE[layer]
        if abs(u) < _RATIO[layer]:
            return x, state
        if layer == 0:
            break
        v, state = next_uniform(state)
        outer = math.exp(0.5 * (x * x - _EDGE[layer] ** 2))
        inner = math.exp(0.5 * (x * x - _EDGE[layer + _ONE] ** 2))
        if outer + v * (inner - outer) < 1.0:
            return x, state
    while True:  # the tail: Marsaglia, Technometrics 6 (1964)
        one, state = next_uniform(state)
        other, state = next_uniform(state)
        beyond = -math.log(one) / _EDGE[1]
        if -2.0 * math.log(other) >= beyond * beyond:
            return math.copysign(_EDGE[1] + beyond, u), state


@scalar
def next_gamma(state, shape):
    """As `gamma`, from `next_normal` and `next_uniform`, and the next state: no logarithm for 98 of 100 if shape >=
    1."""
    if shape <= 0.0:
        return 0.0, state
    d = (shape if shape >= 1.0 else shape + 1.0) - 1.0 / 3.0
    c = 1.0 / math.sqrt(9.0 * d)
    while True:
        x, state = next_normal(state)
        u, state = next_uniform(state)
        v = 1.0 + c * x
        v, square = v * v * v, x * x
        if v > 0.0 and u < 1.0 - 0.0331 * square * square:
            break
        if v > 0.0 and math.log(u) < 0.5 * square + d - d * v + d * math.log(v):
            break
    if shape >= 1.0:
        return d * v, state
    one, state = next_uniform(state)
    return d * v * one ** (1.0 / shape), state
