"""Constant tangential stiffness: kt = shear_stiffness.

Source: LAMMPS documentation, pair_style gran/hooke/history, and granular tangential linear_history; LIGGGHTS hooke/stiffness.
Units: shear_stiffness [force/length].
"""


def stiffness(shear_stiffness: float) -> float:
    """Tangential stiffness kt."""
    return shear_stiffness
