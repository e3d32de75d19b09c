"""Tangential dashpot: gt = gammat.

Source: LIGGGHTS hooke/stiffness with absolute_damping on. Units: gammat [force time/length].
"""


def coefficient(gammat: float) -> float:
    """Tangential damping coefficient gt."""
    return gammat
