"""What is known of pairs goes over from one list to the next."""

from __future__ import annotations

from numba import prange

from billow.base.compiled import kernel


@kernel
def carry_over(n, begin, key, old_begin, old_key, old_gap, old_impulse, old_normal, gap_out, impulse_out, normal_out):
    """Gap, impulse and normal of the pairs that the old list has too, in n groups of which the keys ascend."""
    for t in prange(n):
        j, last = old_begin[t], old_begin[t + 1]
        for i in range(begin[t], begin[t + 1]):
            while j < last and old_key[j] < key[i]:
                j += 1
            if j < last and old_key[j] == key[i]:
                gap_out[i], impulse_out[i] = old_gap[j], old_impulse[j]
                for k in range(3):
                    normal_out[i, k] = old_normal[j, k]
