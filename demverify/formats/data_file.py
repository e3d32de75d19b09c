"""Data files that hand a state over to LAMMPS or LIGGGHTS (`read_data`), every number exactly.

Atoms rows are `id type diameter density x y z ix iy iz`, Velocities rows `id vx vy vz wx wy wz`: atom_style sphere in LAMMPS,
granular or sphere in LIGGGHTS (its 3.8.0 reads image flags too). What a data file cannot carry: contact history, forces,
the step, molecule ids and groups.

Mass goes over as a density, from which both engines compute rmass = (4 pi/3 R R R) density, left to right. The rounded quotient
is the best density there is: a mass that was made so comes back exactly, any other misses by one unit in the last place where no
density gives it (about one in ten).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demsolver.scene import Box
from demverify.deck.setup import Atoms, Dialect
from demverify.errors import InputError
from demverify.formats.atomic import atomic_write
from demverify.formats.columns import volume
from demverify.formats.printf import format_rows


def write_data(path: Path, atoms: Atoms, box: Box, ntypes: int, dialect: Dialect, dimension: int = 3) -> None:
    """Writes `atoms` (n >= 0 rows) in an orthogonal box. Read back, positions, velocities, spins, radii and images keep every bit
    (for particles inside a periodic box; LAMMPS zeroes the images of other axes), masses at most one unit in the last place.

    Raises InputError for a particle whose numbers are not finite, or whose mass or radius is not positive.
    """
    _check(atoms)
    disc = dialect == "liggghts" and dimension == 2  # LAMMPS takes a sphere's volume in two dimensions too
    density = atoms.mass / volume(atoms.radius, 2 if disc else 3)
    head = f"demverify state for {dialect}\n\n{atoms.n} atoms\n{ntypes} atom types\n\n"
    bounds = "".join(f"{lo:.17g} {hi:.17g} {a}lo {a}hi\n" for lo, hi, a in zip(box.lo, box.hi, "xyz", strict=True))
    rows = _rows(atoms.id, atoms.type, 2.0 * atoms.radius, density, *atoms.x.T, *atoms.image.T)
    speeds = _rows(atoms.id, *atoms.v.T, *atoms.omega.T)
    sections = [b"\nAtoms\n\n", rows, b"\nVelocities\n\n", speeds] if atoms.n else []
    with atomic_write(path) as temporary:
        temporary.write_bytes(b"".join([head.encode(), bounds.encode(), *sections]))


def _rows(*columns: NDArray[np.generic]) -> bytes:
    line = " ".join("%d" if np.issubdtype(column.dtype, np.integer) else "%.17g" for column in columns) + "\n"
    return format_rows(line, [column.tolist() for column in columns])


def _check(atoms: Atoms) -> None:
    for name in ("x", "v", "omega", "radius", "mass"):
        values = getattr(atoms, name).reshape(atoms.n, 3 if name in ("x", "v", "omega") else 1)
        good = np.isfinite(values).all(axis=1)
        if name in ("radius", "mass"):
            good &= (values > 0).all(axis=1)
        if not good.all():
            i = int(np.flatnonzero(~good)[0])
            message = f"particle {atoms.id[i]} cannot go into a data file: {name} {' '.join(f'{v:g}' for v in values[i])}"
            raise InputError(message)
