"""Spring, dashpot and slider against twisting, as LAMMPS' twisting sds computes it. With the twist rate q = (w - w_partner).n:

    t += dt q                                                    (only when advance)
    M = -k t - gamma q
    |M| > mu |Fn|:  M = -mu |Fn| sign q,  t = -(M + gamma q)/k    (also at set-up; M = 0 where q = 0)

k, gamma, mu: twisting_stiffness [torque], twisting_damping [torque time], twisting_friction [length]. Energy k t^2/2; the dashpot takes energy, and
so does the slider while it slips the way the spring is wound. It looks at q and not at M, so as it turns back on a spring wound beyond a limit that
has fallen, or where gamma |q| alone exceeds the limit, the spring jumps to the other side; the energy there is never more than was stored, or than
(gamma q)^2/(2 k). t is of equal sign seen from either particle. Source: J. S. Marshall, J. Comput. Phys. 228 (2009) 1541,
doi:10.1016/j.jcp.2008.10.020, eqs. 30, 34, 44; LAMMPS documentation, pair_style granular, twisting sds. Not: at k = 0, where LAMMPS divides by zero,
t is left alone.
"""

MEMORY = {"twisted": 1}


def torque(
    critical_force: float,
    twist_rate: float,
    twisting_stiffness: float,
    twisting_damping: float,
    twisting_friction: float,
    twisted: float,
    dt: float,
    advance: bool,
) -> tuple[float, float]:
    """Torque on the particle along n, and the new angle of twist."""
    if advance:
        twisted += dt * twist_rate
    moment = -twisting_stiffness * twisted - twisting_damping * twist_rate
    limit = twisting_friction * critical_force
    if abs(moment) > limit:
        moment = -limit if twist_rate > 0.0 else limit if twist_rate < 0.0 else 0.0
        if twisting_stiffness > 0.0:
            twisted = -(moment + twisting_damping * twist_rate) / twisting_stiffness
    return moment, twisted


def energy(twisting_stiffness: float, twisted: float) -> float:
    """Energy of the spring, k t^2/2."""
    return 0.5 * twisting_stiffness * twisted * twisted
