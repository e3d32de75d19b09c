"""Hertz contact with a constant pull, of Derjaguin, Muller and Toporov: F = kn a overlap - P, P = 4 pi surface_energy reff, while spheres overlap.

E = 2/5 kn a overlap^2 - P overlap, which is 0 at touch: the force jumps there, the energy does not, so a contact gives back what it took and
only the step loses track of the jump (of order dt). Friction's limit is that of a contact pressed by the pull as well, mu |F + 2 P|.

Source: B. V. Derjaguin, V. M. Muller, Yu. P. Toporov, J. Colloid Interface Sci. 53 (1975) 314, doi:10.1016/0021-9797(75)90018-1; LAMMPS
documentation, pair_style granular, dmt. kn = 4/3 E* as in normal_hertz. Units: kn [force/length^2], surface_energy [energy/area], of which the
work of adhesion is twice. Not: a force beyond touch.
"""

from math import pi


def force(overlap: float, contact_radius: float, reff: float, kn: float, surface_energy: float) -> float:
    """Elastic and adhesive normal force, positive when it pushes apart."""
    return kn * contact_radius * overlap - 4.0 * pi * surface_energy * reff


def energy(overlap: float, contact_radius: float, reff: float, kn: float, surface_energy: float) -> float:
    """Energy with force = dE/d(overlap), negative at small overlaps."""
    return 0.4 * kn * contact_radius * overlap * overlap - 4.0 * pi * surface_energy * reff * overlap


def critical_force(normal_elastic: float, reff: float, surface_energy: float) -> float:
    """What the friction coefficients multiply."""
    return abs(normal_elastic + 2.0 * (4.0 * pi * surface_energy * reff))
