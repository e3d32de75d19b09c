"""Tangential stiffness as a multiple of the normal one: kt = stiffness_ratio F_elastic/overlap.

Source: LIGGGHTS model hooke, ratio 1, or 0.285714286 (nine digits of 2/7) with ktToKnUser on. Dimensionless.
"""


def stiffness(stiffness: float, stiffness_ratio: float) -> float:
    """Tangential stiffness kt; the parameter `stiffness` is the normal secant F_elastic/overlap."""
    return stiffness_ratio * stiffness
