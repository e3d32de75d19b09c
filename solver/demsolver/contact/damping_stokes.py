"""Linear-spring dashpot whose restitution falls with the impact Stokes number (wet contacts):

    gn = 2 sqrt(meff k) |L| / sqrt(L^2 + pi^2),  L = ln(e_max) + St_c/St,  St = meff vn / (6 pi viscosity reff^2)

St carries the sign of vn (as LIGGGHTS computes it): L falls on approach and rises on separation. At vn = 0, where LIGGGHTS 3.8.0
returns NaN, this is its limit |L| -> infinity, gn = 2 sqrt(meff k). Source: D. Legendre et al., Chem. Eng. Sci. 61 (2006) 6543,
doi:10.1016/j.ces.2006.06.007; M. W. Schmeeckle et al., Water Resour. Res. 37 (2001) 2377; LIGGGHTS model hooke, viscous on.
Units: fluid_viscosity [pressure time]; log_restitution = ln e_max, critical_stokes dimensionless. Not: lubrication forces.
"""

from math import pi, sqrt


def coefficient(
    vn: float,
    reff: float,
    meff: float,
    stiffness: float,
    log_restitution: float,
    critical_stokes: float,
    fluid_viscosity: float,
) -> float:
    """Normal damping coefficient gn; k = `stiffness` is the secant F_elastic/overlap."""
    # L is multiplied by the momentum p, so that vn = 0 needs no division.
    p = meff * vn
    lp = log_restitution * p + critical_stokes * 6.0 * pi * fluid_viscosity * reff * reff
    size = sqrt(lp * lp + pi * pi * p * p)
    if size == 0.0:
        return 0.0
    return 2.0 * sqrt(meff * stiffness) * abs(lp) / size
