"""Linear spring whose mean force over a step keeps the energy, at any step: F = [E(d') - E(d)]/(d' - d), E = 1/2 kn d^2 for d > 0.

d, d' are the overlaps at the begin and the end of the step, negative while apart; s = d' - d. A contact alone has s = approach - compliance F, which
is solved here in closed form; several contacts at once are swept over until all agree (kernel_gradient.py). With q = kn compliance/2:

    apart all the time   F = 0
    apart -> touching    (1 + q) s^2 + (2 q d - approach) s + q d^2 = 0, the larger root;  F = kn d'^2/(2 s)
    touching all along   s = (approach - 2 q d)/(1 + q);                                  F = kn (d + s/2)
    touching -> apart    s = [approach - sqrt(approach^2 + 4 q d^2)]/2;                   F = -kn d^2/(2 s)

Source: the discrete gradient of O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449, doi:10.1007/BF02440162, for particles D. Greenspan, A. Labudde,
J. Comput. Phys. 15 (1974) 134, doi:10.1016/0021-9991(74)90081-3. Units: kn [force/length]. Not: known to LAMMPS or LIGGGHTS.
"""

from math import hypot, sqrt


def force(overlap: float, kn: float) -> float:
    """Force of the spring at one moment, what friction sees; positive when it pushes apart."""
    return kn * overlap


def energy(overlap: float, kn: float) -> float:
    """Elastic energy."""
    return 0.5 * kn * overlap * overlap


def solve(overlap: float, approach: float, compliance: float, kn: float) -> float:
    """Mean force over the step. approach: by how much the overlap would grow without it; compliance: by how much less per unit of force."""
    if overlap <= 0.0 and overlap + approach <= 0.0:
        return 0.0
    q = 0.5 * kn * compliance
    if overlap <= 0.0:
        half = 0.5 * (approach - 2.0 * q * overlap)
        s = (half + sqrt(max(half * half - (1.0 + q) * q * overlap * overlap, 0.0))) / (1.0 + q)
        return 0.5 * kn * (overlap + s) * ((overlap + s) / s)
    s = (approach - 2.0 * q * overlap) / (1.0 + q)
    if overlap + s > 0.0:
        return kn * (overlap + 0.5 * s)
    s = 0.5 * (approach - hypot(approach, 2.0 * sqrt(q) * overlap))
    return -0.5 * kn * overlap * (overlap / s)
