"""Ellipsoids of LAMMPS: the energy that `compute erotate/asphere` prints comes back from a dump. There shapex is a diameter."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from demsolver.computes import erotate_superquadric
from demsolver.computes.erotate import erotate
from demsolver.computes.population import Population
from demverify.frames import Frame
from tests.support.engines import EngineRun, run_lammps

# Dump and table hold 17 digits; an energy is some 50 operations of 1e-16 each and a total four terms above zero.
ROUNDING = 1e-14
FREE = "pair_style zero 4.0\npair_coeff * *"
TOUCHING = "pair_style gayberne 1.0 3.0 1.0 4.0\npair_coeff * * 1.0 1.0 1 1 1 1 1 1 4"
SHAPES = ("1 2 3", "1.2 0.7 2.1", "2 2 0.5", "1 1 1", "0 0 0")  # three ellipsoids, one of them a disc; a sphere; a point
DECK = """units si
atom_style {style}
atom_modify map array sort 0 0
boundary f f f
region box block -10 10 -10 10 -10 10
create_box 5 box
create_atoms 1 single 0.2 0.1 -0.1
create_atoms 2 single 2.1 0.2 0
create_atoms 3 single 4.1 0.3 0.3
create_atoms 4 single -2 0 0
create_atoms 5 single 7 0 0
{shapes}
set type 1*4 density 1.7
set type 5 mass 2
set type 1 quat 1 2 3 40
set type 2 quat 1 -2 0.3 140
set type 3 quat 0 1 0.3 75
set type 4 quat 1 0 0.3 10
set type 1 angmom 1 2 3
set type 2 angmom -1 0.2 0.3
set type 3 angmom 0.1 -2 0.3
set type 4 angmom 0.1 0.2 0.3
{spins}
group bodies type 1 2 3 4
{pair}
timestep 0.005
fix turn bodies nve/asphere
compute rot bodies erotate/asphere
compute form all property/atom shapex shapey shapez quatw quati quatj quatk
thermo_style custom step c_rot
thermo_modify format float %.17g norm no
thermo 50
dump d all custom 50 out.dump id mass angmomx angmomy angmomz {columns} c_form[*]
dump_modify d sort id format float %.17g
run 500
"""


def run(folder: Path, pair: str = FREE, style: str = "ellipsoid", spins: str = "", columns: str = "") -> EngineRun:
    """Four bodies that turn for 500 steps, and a point."""
    shapes = "\n".join(f"set type {number} shape {shape}" for number, shape in enumerate(SHAPES, 1))
    return run_lammps(DECK.format(style=style, shapes=shapes, spins=spins, pair=pair, columns=columns), folder)


def population(frame: Frame) -> Population:
    """What the dump says, with half the diameters as semi-axes."""
    columns = frame.columns
    return Population(
        id=columns["id"].astype(np.int64),
        mass=columns["mass"],
        shape=frame.vectors("c_form[1]", "c_form[2]", "c_form[3]") / 2,
        quat=np.column_stack([columns[f"c_form[{number}]"] for number in (4, 5, 6, 7)]),
        angmom=frame.vectors("angmomx", "angmomy", "angmomz"),
    )


@pytest.mark.lammps
@pytest.mark.parametrize("pair", [FREE, TOUCHING], ids=["free", "touching"])
def test_the_printed_energy_comes_back(pair: str, tmp_path: Path) -> None:
    """Law: the sum of L_k^2 / (2 I_k), I = m/5 (b^2 + c^2) with half of shapex..z, is what LAMMPS prints at every step."""
    done = run(tmp_path, pair)
    table = dict(zip(done.thermo[0]["Step"], done.thermo[0]["c_rot"], strict=True))
    for frame in done.frames:
        assert_allclose(erotate(population(frame)), table[frame.step], rtol=ROUNDING)
    assert len(done.frames) == 11
    first, last = population(done.frames[0]), population(done.frames[-1])
    assert np.abs(last.quat - first.quat)[:4].max(axis=1).min() > 0.1  # everything with a shape has turned
    assert (table[500] == pytest.approx(table[0], rel=1e-2)) == (pair == FREE)  # and, touching, has taken up or given off energy


@pytest.mark.lammps
def test_a_particle_without_a_shape_is_dumped_as_a_ball_of_diameter_1(tmp_path: Path) -> None:
    """Law: points, and spheres of a hybrid style, come with shape 1 1 1, quaternion 1 0 0 0 and no angmom: as ellipsoids they count nothing."""
    done = run(tmp_path, style="hybrid ellipsoid sphere", spins="set type 5 omega 1 2 3", columns="radius omegax omegay omegaz")
    last = done.frames[-1]
    bodies = population(last)
    assert_array_equal(bodies.shape[4], [0.5, 0.5, 0.5])
    assert_array_equal(bodies.quat[4], [1, 0, 0, 0])
    assert erotate_superquadric.energies(bodies, bodies.id == 5).total == 0
    assert_array_equal(last.vectors("omegax", "omegay", "omegaz")[4], [1, 2, 3])


@pytest.mark.lammps
def test_the_omega_of_an_ellipsoid_is_stale(tmp_path: Path) -> None:
    """Law: with atom_style hybrid ellipsoid sphere, LAMMPS leaves omega as it was set and prints the energy of angmom."""
    done = run(tmp_path, style="hybrid ellipsoid sphere", spins="set type 1*4 omega 0.1 0.2 0.3", columns="omegax omegay omegaz")
    last = done.frames[-1]
    bodies = replace(population(last), omega=last.vectors("omegax", "omegay", "omegaz"))
    assert_array_equal(bodies.omega[:4], np.tile([0.1, 0.2, 0.3], (4, 1)))
    assert_allclose(erotate(bodies), done.thermo[0]["c_rot"][-1], rtol=ROUNDING)
