"""Spring, dashpot and slider against twisting that follow from those against sliding, as LAMMPS' twisting marshall computes them:

    k = shear_stiffness a^2/2,  gamma = gt a^2/2,  mu = 2/3 mu_t a,  a the contact radius;  the rest as in twisting_sds

That is the torque of a disc of radius a that sticks, or slips, all over. Behind a linear spring shear_stiffness is the tangential stiffness; behind
Mindlin's, whose stiffness is shear_stiffness a, LAMMPS leaves that a out, and so does this. Energy k t^2/2, which changes with a: closing on a wound
spring gives energy from nothing, (k_2 - k_1) t^2/2 in a cycle. Source: J. S. Marshall, J. Comput. Phys. 228 (2009) 1541,
doi:10.1016/j.jcp.2008.10.020, eq. 32; LAMMPS documentation, pair_style granular, twisting marshall.
"""

MEMORY = {"twisted": 1}


def torque(
    critical_force: float,
    contact_radius: float,
    gt: float,
    twist_rate: float,
    shear_stiffness: float,
    mu: float,
    twisted: float,
    dt: float,
    advance: bool,
) -> tuple[float, float]:
    """Torque on the particle along n, and the new angle of twist."""
    area = 0.5 * contact_radius * contact_radius
    if advance:
        twisted += dt * twist_rate
    moment = -area * (shear_stiffness * twisted + gt * twist_rate)
    limit = 2.0 / 3.0 * mu * contact_radius * critical_force
    if abs(moment) > limit:
        moment = -limit if twist_rate > 0.0 else limit if twist_rate < 0.0 else 0.0
        if shear_stiffness > 0.0:
            twisted = -(moment / area + gt * twist_rate) / shear_stiffness
    return moment, twisted


def energy(contact_radius: float, shear_stiffness: float, twisted: float) -> float:
    """Energy of the spring, k t^2/2."""
    return 0.25 * shear_stiffness * contact_radius * contact_radius * twisted * twisted
