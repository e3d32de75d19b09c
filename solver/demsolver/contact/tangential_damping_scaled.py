"""Tangential damping as a multiple of the normal one: gt = xt gn.

Source: LAMMPS documentation, pair_style granular, x_gamma_t; LIGGGHTS model hooke has xt = 1. Dimensionless.
"""


def coefficient(gn: float, xt: float) -> float:
    """Tangential damping coefficient gt."""
    return xt * gn
