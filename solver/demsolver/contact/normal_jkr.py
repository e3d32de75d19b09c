"""Adhesive contact of Johnson, Kendall and Roberts. With the contact radius a, g = surface_energy, E* = yeff, R* = reff:

    overlap = a^2/R* - 2 sqrt(pi g a/E*)                       a: the largest root, in closed form
    F = 4 E* a^3/(3 R*) - 4 sqrt(pi g E* a^3)
    E = 8 E* a^5/(15 R*^2) - 8 sqrt(pi g E*) a^(7/2)/(3 R*) + 2 pi g a^2 + E0,    E0 = 6 pi g a0^2/5,  a0^3 = 4 pi g R*^2/E*

A contact begins at overlap 0 with a = a0, F = -8 pi g R*/3, E = 0, and goes on beyond touch up to where the pull is greatest: F = -3 pi g R*,
a^3 = 9 pi g R*^2/(4 E*), gap a^2/(3 R*) = [3 pi^2 R* g^2/(16 E*^2)]^(1/3). There it snaps off, and the energy of that point, 0.655 pi g a0^2, is
taken from the motion; a contact stretched by hand would hold on up to 2.08 times that gap. Friction's limit is mu |F + 2 (3 pi g R*)|.

Source: K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324 (1971) 301, doi:10.1098/rspa.1971.0141; LAMMPS documentation, pair_style
granular, jkr, whose end of the contact this is; E is the integral of F d(overlap); a solves the quartic (a^2 - R* overlap)^2 = 4 pi g R*^2 a/E*,
and loses digits as g -> 0 (1e-9 where the gap is 1e-10 of the overlap; at g = 0 it is Hertz's). Units: yeff [pressure], surface_energy
[energy/area], of which the work of adhesion is twice. Not: a pull before first touch.
"""

from math import pi, pow, sqrt  # noqa: A004  (what the compiled law calls)


def contact_radius(overlap: float, reff: float, yeff: float, surface_energy: float) -> float:
    """Radius a of the contact area."""
    if surface_energy == 0.0:
        return sqrt(reff * max(overlap, 0.0))
    square = reff * overlap
    pull = surface_energy * surface_energy * reff * reff * reff * reff * yeff
    t1 = 27.0 * pi * pi * pull
    t2 = 8.0 * square * square * square * yeff * yeff * yeff
    t4 = pow(t1 + t2 + 3.0 * sqrt(3.0) * pi * sqrt(max(pull * (t1 + 2.0 * t2), 0.0)), 1.0 / 3.0)
    t5 = 4.0 * square * square * yeff / t4 + t4 / yeff
    t6 = sqrt(max(2.0 * square + t5, 0.0))
    rest = 4.0 * square - t5 + 6.0 * sqrt(6.0) * surface_energy * pi * reff * reff / (yeff * t6)
    return (t6 + sqrt(max(rest, 0.0))) / sqrt(6.0)


def force(contact_radius: float, reff: float, yeff: float, surface_energy: float) -> float:
    """Normal force, positive when it pushes apart."""
    cube = contact_radius * contact_radius * contact_radius
    return 4.0 / 3.0 * yeff * cube / reff - 4.0 * sqrt(pi * surface_energy * yeff * cube)


def energy(contact_radius: float, reff: float, yeff: float, surface_energy: float) -> float:
    """Energy with force = dE/d(overlap), 0 where the contact began."""
    square = contact_radius * contact_radius
    elastic = 8.0 / 15.0 * yeff * square * square * contact_radius / (reff * reff)
    mixed = 8.0 / 3.0 * sqrt(pi * surface_energy * yeff * contact_radius) * square * contact_radius / reff
    first = pow(4.0 * pi * surface_energy * reff * reff / yeff, 2.0 / 3.0)
    return elastic - mixed + 2.0 * pi * surface_energy * (square + 0.6 * first)


def critical_force(normal_elastic: float, reff: float, surface_energy: float) -> float:
    """What the friction coefficients multiply."""
    return abs(normal_elastic + 2.0 * (3.0 * pi * surface_energy * reff))


def reach(reff: float, yeff: float, surface_energy: float) -> float:
    """Gap up to which a contact that has touched goes on."""
    return pow(0.1875 * pi * pi * reff * surface_energy * surface_energy / (yeff * yeff), 1.0 / 3.0)
