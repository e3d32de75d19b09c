"""The case of `penetration.py` as a LAMMPS deck and a LIGGGHTS deck, and its state as a data file that both read."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BED = Path(__file__).parent / "data" / "penetration-25k.txt.gz"
GRAVITY, STEP = 9.81, 5e-7
BEAD, BALL = 0.001, 0.01  # radii
DENSITY = {1: 2500.0, 2: 7200.0}
YOUNG, POISSON = {1: 1.0e9, 2: 210.0e9}, 0.2
PAIRS = ((1, 1), (1, 2), (2, 1), (2, 2))
RESTITUTION = {(1, 1): 0.5, (1, 2): 0.4, (2, 1): 0.4, (2, 2): 0.6}  # steel never meets steel; the value is MercuryDPM's
FRICTION = {(1, 1): 0.3, (1, 2): 0.2, (2, 1): 0.2, (2, 2): 0.5}
PLANES = {"x": (-0.049, 0.049), "y": (-0.03, 0.03), "z": (-0.0902431, None)}

LIGGGHTS = """\
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
hard_particles yes
read_data data
{materials}
pair_style gran model hertz tangential history
pair_coeff * *
{walls}
neighbor 0.001 bin
"""
LAMMPS = """\
units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
read_data data
pair_style granular
{pairs}
{walls}
neighbor 0.0004 multi
"""
SHOT = f"""\
neigh_modify every 1 delay 0
timestep {STEP}
group shot type 2
fix down all gravity {GRAVITY} vector 0.0 0.0 -1.0
fix move all nve/sphere
compute z shot reduce sum z
compute vz shot reduce sum vz
compute fz shot reduce sum fz
thermo_style custom step atoms c_z c_vz c_fz
thermo_modify norm no format float %.17g
thermo ${{rows}}
run ${{steps}}
"""


def start() -> tuple[Floats, float]:
    """Centres (25001, 3) of the beads and, last, the ball, 0.1 mm above the bead that it meets first; and its speed there."""
    with gzip.open(BED, "rt", encoding="utf-8") as stream:
        rows = [line.split() for line in stream][1:]
    beads = np.array([row[1:] for row in rows if len(row) == 4], dtype=float)
    aside = np.hypot(beads[:, 0], beads[:, 1])
    under = aside < BEAD + BALL
    z = float((beads[under, 2] + np.sqrt((BEAD + BALL) ** 2 - aside[under] ** 2)).max()) + 1e-4
    return np.vstack([beads, [[0.0, 0.0, z]]]), float(np.sqrt(25.0 + 2.0 * GRAVITY * (0.06 - z)))


def data_file(x: Floats, speed: float) -> str:
    """The state, to the last bit."""
    n = len(x)
    sizes = [f"1 {2 * BEAD} {DENSITY[1]}"] * (n - 1) + [f"2 {2 * BALL} {DENSITY[2]}"]
    atoms = [f"{i} {size} {' '.join(map(repr, place))}" for i, (size, place) in enumerate(zip(sizes, x.tolist(), strict=True), 1)]
    velocities = [f"{i} 0 0 0 0 0 0" for i in range(1, n)] + [f"{n} 0 0 {-speed!r} 0 0 0"]
    faces = "-0.05 0.05 xlo xhi\n-0.031 0.031 ylo yhi\n-0.0912 0.02 zlo zhi\n"
    head = f"beads and a ball; made by benchmarks/penetration_decks.py\n\n{n} atoms\n2 atom types\n\n{faces}"
    return "\n".join([head, "Atoms\n", *atoms, "\nVelocities\n", *velocities]) + "\n"


def decks() -> dict[str, str]:
    """Both decks, by dialect. Lists as each engine is fastest with them: LIGGGHTS' style multi finds no contacts, so its cells are the ball's."""
    materials = [
        f"fix E all property/global youngsModulus peratomtype {YOUNG[1]} {YOUNG[2]}",
        f"fix nu all property/global poissonsRatio peratomtype {POISSON} {POISSON}",
    ]
    for name, table in (("coefficientRestitution", RESTITUTION), ("coefficientFriction", FRICTION)):
        materials.append(f"fix {name} all property/global {name} peratomtypepair 2 {' '.join(str(table[pair]) for pair in PAIRS)}")
    planes = [(axis, k, place) for axis, places in PLANES.items() for k, place in enumerate(places) if place is not None]
    their_walls = [f"fix {axis}{k} all wall/gran model hertz tangential history primitive type 2 {axis}plane {place}" for axis, k, place in planes]
    pairs = [f"pair_coeff {i} {j} {_law(i, j)}" for i, j in PAIRS if i <= j]
    walls = [f"fix {axis} all wall/gran granular {_law(1, 2)} {axis}plane {lo} {'NULL' if hi is None else hi}" for axis, (lo, hi) in PLANES.items()]
    return {
        "liggghts": LIGGGHTS.format(materials="\n".join(materials), walls="\n".join(their_walls)) + SHOT,
        "lammps": LAMMPS.format(pairs="\n".join(pairs), walls="\n".join(walls)) + SHOT,
    }


def _law(i: int, j: int) -> str:
    """The law of LIGGGHTS' hertz in LAMMPS' words.

    LAMMPS takes both bodies for alike: they get the Young's modulus at which like bodies meet as these two do. All have one Poisson's
    ratio, so the shear moduli follow. The tangential damping is to the tangential stiffness (8 G) as the normal one to the normal one (2 E).
    """
    young = 2.0 / (1.0 / YOUNG[i] + 1.0 / YOUNG[j])
    ratio = float(np.sqrt(2.0 * (1.0 - POISSON**2) / ((2.0 - POISSON) * (1.0 + POISSON))))
    return f"hertz/material {young!r} {RESTITUTION[i, j]} {POISSON} tangential mindlin NULL {ratio!r} {FRICTION[i, j]} damping coeff_restitution"
