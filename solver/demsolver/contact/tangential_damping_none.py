"""No tangential damping: gt = 0 (LAMMPS dampflag 0, LIGGGHTS tangential_damping off)."""


def coefficient() -> float:
    """Tangential damping coefficient gt."""
    return 0.0
