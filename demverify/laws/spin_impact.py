"""A spinning sphere hits a plane, or a sphere too heavy to move, and slides throughout: rigid-body impulse with P_t = mu P_n.

    v_n' = e v_n;  v_t' = v_t - P;  omega' = omega + 5/2 P/R;  P = mu (1 + e) v_n sign(v_t - R omega)

Exact for gross sliding, |slip| >= mu (1 + e)/2 (7 - 1/kappa) v_n (Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0, tests 6 and 8; Maw et al.
1976), as long as the friction follows the whole normal force and that never pulls. A partner of mass M takes a share m/M of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.laws.oblique_mindlin import rebound, state


def measure(frames: Sequence[Frame], restitution: float, friction: float) -> list[Measured]:
    """Rebound of the first particle, which comes down along z, moves along x and spins about y."""
    _, _, vn, slip = state(frames[0])
    return rebound(frames, restitution * vn, copysign(friction * (1.0 + restitution) * vn, slip))
