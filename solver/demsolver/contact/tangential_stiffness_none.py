"""No tangential spring: kt = 0, for friction without history."""


def stiffness() -> float:
    """Tangential stiffness kt."""
    return 0.0
