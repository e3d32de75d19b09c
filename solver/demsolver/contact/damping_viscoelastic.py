"""Viscoelastic dashpot: gn = gamman meff a, a the contact radius.

Source: N. V. Brilliantov et al., Phys. Rev. E 53 (1996) 5382, doi:10.1103/PhysRevE.53.5382, in the form of the LAMMPS
documentation: pair_style gran/hertz/history, and granular damping viscoelastic; LIGGGHTS hertz/stiffness.
Units: gamman [1/(time length)]. Not: a given restitution.
"""


def coefficient(meff: float, contact_radius: float, gamman: float) -> float:
    """Normal damping coefficient gn."""
    return gamman * meff * contact_radius
