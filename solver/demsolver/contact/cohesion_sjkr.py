"""Attraction over the area of overlap: F = -k A, E = -k V, with A the area of the circle in which the two surfaces meet and V the volume of
the overlap, a lens between spheres and a cap at a plane wall.

    A = pi d (2 R - d) (2 - c d) (2 + c (2 R - d)) / (4 (1 + c (R - d))^2)
    V = pi d^2 (12 R - 4 d - 4 c R d + c d^2) / (12 (1 + c (R - d)))          d the overlap, R the radius, c the partner's curvature

With c = 1/R_j, times R_j, these are the circle and the lens of two spheres whose centres are r = R + R_j - d apart,
A = pi (r + R - R_j)(r - R + R_j)(-r + R + R_j)(r + R + R_j)/(4 r^2); with c = 0 those of a plane, A = pi (R^2 - (R - d)^2). dV/dd = A.

A is 0 at the first touch and at the last, so a contact takes and gives back the same energy, and nothing pulls from afar. Units: k, the
cohesion energy density, [energy/volume] = [force/area].

Source: LIGGGHTS documentation, gran cohesion sjkr ("simplified JKR"), 3.8.0; measured, test_rolling_liggghts.py. Not: JKR, whose area follows from
the elastic contact and which holds on beyond touching; LIGGGHTS' sjkr2, which takes 2 pi R d, twice the area.
"""

from math import pi


def force(overlap: float, radius: float, partner_curvature: float, cohesion_energy_density: float) -> float:
    """Force along the normal, negative: it pulls."""
    width = 2.0 * radius - overlap
    distance = 1.0 + partner_curvature * (radius - overlap)
    area = 0.25 * pi * overlap * width * (2.0 - partner_curvature * overlap) * (2.0 + partner_curvature * width) / (distance * distance)
    return -cohesion_energy_density * area


def energy(overlap: float, radius: float, partner_curvature: float, cohesion_energy_density: float) -> float:
    """Energy of the bond, negative, with force = dE/d(overlap)."""
    depth = 12.0 * radius - 4.0 * overlap - partner_curvature * overlap * (4.0 * radius - overlap)
    volume = pi * overlap * overlap * depth / (12.0 * (1.0 + partner_curvature * (radius - overlap)))
    return -cohesion_energy_density * volume
