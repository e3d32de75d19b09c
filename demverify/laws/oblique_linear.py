"""A sphere hits a plane obliquely, at any angle: elastic linear springs, the tangential one cut at mu Fn, integrated as an ODE.

    m d'' = -kn d;  m w' = -7/2 Ft,  Ft = kt s, s' = w,  s cut so that |Ft| <= mu Fn          (w: slip of the contact point)

(MFIX-DEM V&V, DEM-05, after Di Renzo & Di Maio 2004, doi:10.1016/j.ces.2003.09.037; sliding throughout: P_t = mu P_n.)
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import pi, sqrt

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.laws.oblique_mindlin import STEPS, impact, rebound, state


def measure(frames: Sequence[Frame], kn: float, kt: float, friction: float) -> list[Measured]:
    """Rebound of the first particle from a plane z = const, moving along x, spinning about y. kn, kt: spring constants."""
    _, mass, vn, slip = state(frames[0])
    return rebound(frames, *_linear(kn / mass, kt / mass, friction, vn, slip))


@lru_cache(maxsize=64)
def _linear(kn: float, kt: float, friction: float, vn: float, slip: float) -> tuple[float, float]:
    return impact(lambda d, _: kn * d, lambda _: kt, friction, vn, slip, pi / sqrt(kn) / STEPS, True)
