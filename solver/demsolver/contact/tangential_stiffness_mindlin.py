"""Mindlin's no-slip stiffness: kt = shear_stiffness a, a the contact radius.

Source: R. D. Mindlin, J. Appl. Mech. 16 (1949) 259, where shear_stiffness = 8 G* and
1/G* = 2 (2 - nu_i)(1 + nu_i)/E_i + 2 (2 - nu_j)(1 + nu_j)/E_j; LAMMPS gran/hertz/history and granular tangential mindlin,
LIGGGHTS hertz and hertz/stiffness. Units: shear_stiffness [force/length^2]. Not: rescaled when the contact unloads
(mindlin_rescale), so the spring energy jumps with the contact radius.
"""


def stiffness(contact_radius: float, shear_stiffness: float) -> float:
    """Tangential stiffness kt."""
    return shear_stiffness * contact_radius
