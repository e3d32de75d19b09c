"""Dashpot proportional to the effective mass: gn = gamman meff.

Source: LAMMPS documentation, pair_style gran/hooke, and granular damping mass_velocity; LIGGGHTS hooke/stiffness.
Units: gamman [1/time]. Not: a given restitution.
"""


def coefficient(meff: float, gamman: float) -> float:
    """Normal damping coefficient gn."""
    return gamman * meff
