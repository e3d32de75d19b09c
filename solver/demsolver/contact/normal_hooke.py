"""Linear spring: F = kn overlap, E = 1/2 kn overlap^2.

Source: LAMMPS documentation, pair_style gran/hooke and pair_style granular (normal hooke); LIGGGHTS model hooke/stiffness.
Units: kn [force/length]. Not: a stiffness taken from material constants (see normal_impact_hooke).
"""


def force(overlap: float, kn: float) -> float:
    """Elastic normal force, positive when it pushes apart."""
    return kn * overlap


def energy(overlap: float, kn: float) -> float:
    """Elastic energy with force = dE/d(overlap)."""
    return 0.5 * kn * overlap * overlap
