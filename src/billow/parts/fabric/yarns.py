"""Woven fabric as two families of yarns that may turn against each other: how kernels see it.

Yarn vectors a = F a0 and b = F b0 with stretches la and lb, c the cosine between them, c0 in the flat cut. Stress is
written in the yarns' own basis, P = (s_aa a + s_ab b) (x) a0 + (s_ab a + s_bb b) (x) b0, which needs no directions
and thereby no division by a length that may vanish.

The angle of slack yarns means nothing: a crumpled or collapsed triangle has any angle, and a shear force T/l would have
no bound. The measure of shear is therefore

    z = w(la) w(lb) (c - c0),   w(l) = 2 l / (1 + l^2),

which is sin(gamma) for orthogonal yarns of flat length (0.5 % less with both 5 % longer), fades as yarns go slack, and
is smooth through zero length and through inversion (c -> +-1).
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar


@scalar
def shortened(below, strain):
    """(stress s_aa [Pa], energy [J/m^3]) of a yarn of Green strain below zero, nothing above.

    below: modulus [Pa], zero for yarns that go slack; s = below E is smooth through zero length.
    """
    pressed = min(strain, 0.0)
    return below * pressed, 0.5 * below * pressed * pressed


@scalar
def shear_measure(c0, aa, bb, ab):
    """z and its gradient in the yarns' basis, (z, z_aa, z_bb, z_ab): dz/da = z_aa a + z_ab b.

    aa, bb, ab: products of the yarn vectors.
    """
    both = 1.0 / ((1.0 + aa) * (1.0 + bb))
    z = 4.0 * both * ab
    if c0 == 0.0:
        return z, -2.0 * z * both * (1.0 + bb), -2.0 * z * both * (1.0 + aa), 4.0 * both
    lengths = np.sqrt(aa * bb)
    z -= 4.0 * both * c0 * lengths
    # Without length the stress on z vanishes, and with it whatever stands here.
    over = 4.0 * both * c0 / lengths if lengths > 0.0 else 0.0
    return z, -2.0 * z * both * (1.0 + bb) - over * bb, -2.0 * z * both * (1.0 + aa) - over * aa, 4.0 * both


@scalar
def stretch_bound(aa, bb, ab, cot, csc):
    """Gershgorin's bound of the largest squared stretch; cot, csc: of the yarns' angle in the flat cut."""
    if cot == 0.0:
        return max(aa, bb) + abs(ab)
    c12 = csc * ab - cot * aa
    return max(aa, csc * csc * bb - 2.0 * csc * cot * ab + cot * cot * aa) + abs(c12)
