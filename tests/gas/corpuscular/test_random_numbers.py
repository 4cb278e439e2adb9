"""Counter-based random numbers: right distributions, no relation between neighbouring names, no history."""

from __future__ import annotations

import numpy as np
import pytest
from numba import prange
from scipy import stats

from billow.base.compiled import kernel
from billow.parts.gas.corpuscular.random_numbers import (
    gamma,
    next_gamma,
    next_normal,
    next_uniform,
    normal,
    stream,
    uniform,
)

N = 200_000
# Fixed names give fixed numbers: a test of level 1e-3 cannot fail by chance from one day to the next.
LEVEL = 1e-3


@kernel
def _draw(n, kind, shape, seed, step, event, out):
    for i in prange(n):
        key = stream(seed, step, i)
        if kind == 0:
            out[i] = uniform(key, event)
        elif kind == 1:
            out[i] = normal(key, event)
        elif kind == 2:
            out[i] = gamma(key, event, shape)
        else:
            for _ in range(event + 1):
                if kind == 3:
                    out[i], key = next_uniform(key)
                elif kind == 4:
                    out[i], key = next_gamma(key, shape)
                else:
                    out[i], key = next_normal(key)


def draw(kind, shape=1.0, seed=7, step=3, event=0, n=N):
    out = np.empty(n)
    _draw(n, kind, shape, seed, step, event, out)
    return out


@pytest.mark.parametrize("kind", [0, 3])
def test_uniform_is_uniform_and_open(kind):
    u = draw(kind)
    assert stats.kstest(u, "uniform").pvalue > LEVEL
    assert u.min() > 0.0
    assert u.max() < 1.0


@pytest.mark.parametrize("kind", [1, 5])
def test_normal_is_normal(kind):
    assert stats.kstest(draw(kind), "norm").pvalue > LEVEL


@pytest.mark.parametrize("kind", [1, 5])
def test_normal_has_its_tails(kind):
    """The numbers beyond 3.4 and 3.5 on each side, where the layers of the ziggurat end at 3.44: binomial."""
    x = draw(kind, n=20 * N)
    for beyond in (2.5, 3.4, 3.5, 4.0):
        share = stats.norm.sf(beyond)
        for count in ((x > beyond).sum(), (x < -beyond).sum()):
            assert abs(count - share * len(x)) < 4.5 * np.sqrt(share * len(x)), beyond


@pytest.mark.parametrize("shape", [0.3, 1.0, 1.001, 1.1, 1.5, 2.7, 8.0])
@pytest.mark.parametrize("kind", [2, 4])
def test_gamma_has_its_shape(kind, shape):
    assert stats.kstest(draw(kind, shape), "gamma", args=(shape,)).pvalue > LEVEL


def test_gamma_of_shape_zero_is_zero():
    assert (draw(2, 0.0, n=10) == 0.0).all()
    assert (draw(4, 0.0, n=10) == 0.0).all()


@pytest.mark.parametrize("other", [{"step": 4}, {"event": 1}, {"seed": 8}, {"step": 3 + 2**32}, {"event": 2}], ids=str)
def test_neighbouring_names_are_independent(other):
    """Correlation of n independent pairs is normal with deviation 1/sqrt(n); also of their high powers."""
    first, second = draw(0), draw(0, **other)
    for power in (1, 4):
        a, b = first**power, second**power
        assert abs(np.corrcoef(a, b)[0, 1]) < 4.0 / np.sqrt(N)


def test_neighbouring_particles_are_independent():
    u = draw(0)
    for lag in (1, 2, 64):
        assert abs(np.corrcoef(u[:-lag], u[lag:])[0, 1]) < 4.0 / np.sqrt(N)


@pytest.mark.parametrize("kind", [0, 3, 5])
def test_events_of_one_particle_fill_the_cube(kind):
    """Triples of successive events fall evenly into 20^3 boxes (chi-square)."""
    evenly = stats.norm.cdf if kind == 5 else np.asarray
    triple = np.stack([(20 * evenly(draw(kind, event=e))).astype(int) for e in range(3)])
    counts = np.bincount(np.ravel_multi_index(tuple(triple), (20, 20, 20)), minlength=8000)
    assert stats.chisquare(counts).pvalue > LEVEL


def test_every_bit_is_even():
    """Each of the 52 bits of a uniform is set half the time: deviation 0.5 sqrt(n)."""
    bits = (draw(0) * 2.0**52).astype(np.uint64)
    for k in range(52):
        ones = int(((bits >> np.uint64(k)) & np.uint64(1)).sum())
        assert abs(ones - N / 2) < 4.5 * 0.5 * np.sqrt(N), k


def test_parallel_and_serial_give_the_same_bits():
    serial, parallel = np.empty(N), np.empty(N)
    _draw.serial(N, 2, 1.3, 7, 3, 0, serial)
    _draw.parallel(N, 2, 1.3, 7, 3, 0, parallel)
    assert np.array_equal(serial, parallel)
