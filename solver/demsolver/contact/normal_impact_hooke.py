"""Linear spring as stiff as a Hertz contact hit at a characteristic velocity V: F = kn overlap,
kn = 16/15 sqrt(reff) yeff [15 meff V^2 / (16 sqrt(reff) yeff)]^(1/5).

At impact speed V the spring and the Hertz contact reach the same greatest overlap. yeff is the effective Young's modulus E* of
normal_hertz [pressure]. Source: LIGGGHTS documentation, gran model hooke; measured, test_against_liggghts.py.
Not: a material stiffness; it depends on the masses of the pair and on V.
"""

from math import pow, sqrt  # noqa: A004  (what the compiled law calls)


def force(overlap: float, reff: float, meff: float, yeff: float, characteristic_velocity: float) -> float:
    """Elastic normal force, positive when it pushes apart."""
    hertz = 16.0 / 15.0 * sqrt(reff) * yeff
    kn = hertz * pow(meff * characteristic_velocity * characteristic_velocity / hertz, 0.2)
    return kn * overlap


def energy(overlap: float, reff: float, meff: float, yeff: float, characteristic_velocity: float) -> float:
    """Elastic energy with force = dE/d(overlap)."""
    hertz = 16.0 / 15.0 * sqrt(reff) * yeff
    kn = hertz * pow(meff * characteristic_velocity * characteristic_velocity / hertz, 0.2)
    return 0.5 * kn * overlap * overlap
