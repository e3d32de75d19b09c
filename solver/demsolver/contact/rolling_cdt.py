"""Rolling friction of constant size against the relative spin w, as LIGGGHTS' "constant directional torque" computes it:

    T = -rolling_friction R* F_elastic w/|w|;   torsion 0: less its part along n, so |T| = rolling_friction R* F_elastic |w_t|/|w|

F_elastic is the spring force: damping, a limit on the total force, and cohesion do not count. Stores nothing. Its power
-rolling_friction R* F_elastic |w_t|^2/|w| (torsion 1: |w|) is never positive. In steps of dt it overshoots: a spin s below T dt/I is not stopped
but turned round, to s - T dt/I, and back by the next step, and so on; of every two such steps one gives energy, at most (T dt)^2/(2 I). Where
contacts do that side by side, rounding grows. Units: rolling_friction, torsion [1].

Source: J. Ai et al., Powder Technol. 206 (2011) 269, doi:10.1016/j.powtec.2010.09.030, model A (there F is the whole normal force, and the
motion plane); LIGGGHTS documentation, gran rolling_friction cdt, 3.8.0; measured, test_rolling_liggghts.py.
"""

from math import sqrt

MEMORY: dict[str, int] = {}
RANGES = {"torsion": (0.0, 1.0)}


def torque(
    normal_elastic: float, reff: float, rolling_friction: float, torsion: float, nx: float, ny: float, nz: float, wx: float, wy: float, wz: float
) -> tuple[float, float, float]:
    """Torque on the particle."""
    spin = sqrt(wx * wx + wy * wy + wz * wz)
    if spin == 0.0:
        return 0.0, 0.0, 0.0
    resistance = rolling_friction * reff * normal_elastic / spin
    along = (1.0 - torsion) * (wx * nx + wy * ny + wz * nz)
    return -resistance * (wx - along * nx), -resistance * (wy - along * ny), -resistance * (wz - along * nz)


def energy() -> float:
    """Nothing is stored."""
    return 0.0
