"""Dashpot: gn = gamman.

Source: LAMMPS documentation, pair_style granular, damping velocity; LIGGGHTS hooke/stiffness with absolute_damping on.
Units: gamman [force time/length]. Not: scaled by mass or contact size.
"""


def coefficient(gamman: float) -> float:
    """Normal damping coefficient gn."""
    return gamman
