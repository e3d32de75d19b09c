"""Tangential damping proportional to effective mass and contact radius a: gt = gammat meff a.

Source: LAMMPS documentation, pair_style gran/hertz/history; LIGGGHTS hertz/stiffness. Units: gammat [1/(time length)].
"""


def coefficient(meff: float, contact_radius: float, gammat: float) -> float:
    """Tangential damping coefficient gt."""
    return gammat * meff * contact_radius
