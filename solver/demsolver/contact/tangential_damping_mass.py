"""Tangential damping proportional to the effective mass: gt = gammat meff.

Source: LAMMPS documentation, pair_style gran/hooke and gran/hooke/history; LIGGGHTS hooke/stiffness. Units: gammat [1/time].
"""


def coefficient(meff: float, gammat: float) -> float:
    """Tangential damping coefficient gt."""
    return gammat * meff
