"""Powers for loops that become vector instructions, which a call to the C library would keep from it."""

from __future__ import annotations

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from billow.base.compiled import spliced

SMALLEST = 1e-300
"""Least number that a power is taken of."""

_LN2 = math.log(2.0)
_SQRT_HALF = 0x3FE6A09E667F3BCD
"""sqrt(1/2) as a processor keeps it."""
_MANTISSA = 52
"""Bits of a number after its exponent."""
_BIAS = 1023
"""Exponent of 1."""
_LAST_DIGIT = 1.5 * 2.0**_MANTISSA
"""Added to a number, it leaves the nearest integer in the last bits of the sum."""
_MOST = 1000.0
"""Power of two that the answer may have at most, and its negative at least."""


@intrinsic
def _bits(typing_context, number):
    """The 64 bits of a float as an integer."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def _of_bits(typing_context, bits):
    """The float that 64 bits are."""

    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate


@spliced
def power(x, p):
    """x^p for x from SMALLEST on, within 2^-1000 to 2^1000, to rounding times 1 + |p log x|.

    2^(p (k + log2 m)) with x = 2^k m and m near 1: log m = 2 artanh((m - 1)/(m + 1)), by its series, and the series of
    the exponential for what is left beside a whole power of two.
    """
    bits = _bits(x)
    k = (bits - _SQRT_HALF) >> _MANTISSA
    m = _of_bits(bits - (k << _MANTISSA))
    s = (m - 1.0) / (m + 1.0)
    w = s * s
    w2 = w * w
    w4 = w2 * w2
    low = (1.0 / 3.0 + w * (1.0 / 5.0)) + w2 * (1.0 / 7.0 + w * (1.0 / 9.0))
    high = (1.0 / 11.0 + w * (1.0 / 13.0)) + w2 * (1.0 / 15.0 + w * (1.0 / 17.0))
    rest = 1.0 / 19.0 + w * (1.0 / 21.0)
    binary = (2.0 / _LN2) * (s + s * w * (low + w4 * (high + w4 * rest)))
    t = p * (float(k) + binary)
    t = t if t > -_MOST else -_MOST
    t = t if t < _MOST else _MOST
    shifted = t + _LAST_DIGIT
    r = (t - (shifted - _LAST_DIGIT)) * _LN2
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 / 2.0 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0))
    high = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0))
    rest = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0)
    part = 1.0 + (r + r2 * (low + r4 * (high + r4 * rest)))
    return part * _of_bits((_bits(shifted) + _BIAS) << _MANTISSA)
