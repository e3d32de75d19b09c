"""Hertz contact of spheres: F = kn a overlap with a = sqrt(reff overlap), E = 2/5 kn a overlap^2.

Source: H. Hertz, J. reine angew. Math. 92 (1882) 156, doi:10.1515/crll.1882.92.156, where kn = 4/3 E* and
1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j. The same law in LAMMPS gran/hertz/history, granular hertz, hertz/material, and in
LIGGGHTS hertz, hertz/stiffness; they differ in where kn comes from. Units: kn [force/length^2]. Not: adhesive (JKR, DMT).
"""


def force(overlap: float, contact_radius: float, kn: float) -> float:
    """Elastic normal force, positive when it pushes apart."""
    return kn * contact_radius * overlap


def energy(overlap: float, contact_radius: float, kn: float) -> float:
    """Elastic energy with force = dE/d(overlap)."""
    return 0.4 * kn * contact_radius * overlap * overlap
