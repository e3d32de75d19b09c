"""No normal damping. Source: for step laws, whose step holds all of it, and for elastic contacts."""


def coefficient() -> float:
    """Normal damping coefficient gn."""
    return 0.0
