"""What a dictionary says of columns, against files that the engines wrote from the same deck."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demverify.deck.dictionary import read_dictionary
from demverify.formats.dump import read_dump
from demverify.frames import Frame
from tests.support.engines import run_lammps, run_liggghts

LAMMPS = """units si
atom_style hybrid sphere molecular
boundary f f f
newton off
comm_modify vel yes
region r block 0 1 0 1 0 1
create_box 3 r
create_atoms 1 single 0.50 0.50 0.50
create_atoms 1 single 0.52 0.50 0.50
create_atoms 1 single 0.51 0.53 0.51
create_atoms 2 single 0.10 0.10 0.10
set atom 1*3 mol 7
set type 1*2 diameter 0.04 density 2000
set type 2 density 100 diameter 0.01
group clump type 1
set group all omega 1 2 3
velocity all set 0.1 0.2 0.3
velocity clump set 0.1 NULL NULL sum yes
pair_style gran/hooke/history 1e5 NULL 50 NULL 0.5 0
pair_coeff * *
neighbor 0.01 bin
neigh_modify exclude molecule/intra all
fix 1 clump rigid/small molecule
compute m all property/atom mass
compute p all property/atom radius omegax vy tqz mol
compute b all rigid/local 1 mol mass x y z vx vy vz omegax omegay omegaz angmomx angmomy angmomz quatw quati quatj quatk inertiax inertiay inertiaz
compute e all erotate/rigid 1
variable d atom c_p[1]
variable mine atom mass
thermo_style custom step c_e
thermo_modify format float %.17g
dump plain all custom 1 plain.*.txt id type mass radius omegax vy tqz mol
dump named all custom 1 named.*.txt id c_m c_p[*] v_d v_mine
dump_modify named colname c_p[2] spin colname 2 heavy colname -1 mine
dump bodies all local 1 bodies.*.txt index c_b[*]
dump_modify bodies colname 1 number format float %.17g
dump whole all atom 1 whole.*.txt
dump_modify whole scale no image yes
fix 2 all setforce 0.1 0.2 0.3
run 1
write_dump all custom written.txt id c_p[*4] modify colname id tag
"""

LIGGGHTS = """atom_style sphere
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
region reg block -0.3 0.3 -0.3 0.3 0 0.5 units box
create_box 1 reg
neighbor 0.004 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hertz tangential history
pair_coeff * *
timestep 1e-5
fix gravi all gravity 9.81 vector 0 0 -1
fix pts all particletemplate/multisphere 15485863 atom_type 1 density constant 2500 nspheres 3 ntry 100000 &
    spheres 0 0 0 0.012 0.012 0 0 0.01 0 0.012 0 0.008 type 1
fix pdd all particledistribution/discrete 32452867 1 pts 1.0
region bc block -0.1 0.1 -0.1 0.1 0.2 0.4 units box
fix ins all insert/pack seed 32452843 distributiontemplate pdd vel constant 0 0 -1 omega constant 5 -3 8 insert_every once &
    overlapcheck yes orientation random region bc ntry_mc 10000 particles_in_region 5
fix integr all multisphere
compute e all erotate/multisphere
thermo_style custom step c_e
thermo_modify lost ignore norm no format float %.17g
{computes}
run 1
dump plain all custom 1 plain.*.txt id type type x radius density id_multisphere
dump bodies all local 1 bodies.*.txt {columns}
dump_modify bodies format "{formats}"
run 10
"""
SCALARS = ("id_multisphere", "masstotal", "clumptype", "atomtype", "nrigid")
VECTORS = ("xcm", "vcm", "fcm", "torque", "angmom", "omega", "inertia", "ex_space", "ey_space", "ez_space", "quat")


def header(path: Path) -> tuple[str, ...]:
    """The columns that the first frame of a text dump names."""
    line = next(line for line in path.read_text().splitlines() if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")))
    return tuple(line.split()[2:])


def spin_energy(bodies: Frame, names: dict[str, str]) -> float:
    """Sum of 1/2 I (R^T omega)^2 over bodies, with R from the quaternion w x y z."""
    column = {names.get(name, name): values for name, values in bodies.columns.items()}
    w, *v = (column[f"quat[{i}]"] for i in (1, 2, 3, 4))
    axis = np.array(v)
    omega = np.array([column[f"omega[{i}]"] for i in (1, 2, 3)])
    twice = 2.0 * np.cross(axis, omega, axis=0)
    inside = omega - w * twice + np.cross(axis, twice, axis=0)  # turned by the inverse of the quaternion
    return float(0.5 * sum(column[f"inertia[{i}]"] @ inside[i - 1] ** 2 for i in (1, 2, 3)))


@pytest.mark.lammps
def test_columns_of_lammps(tmp_path: Path) -> None:
    """Law: headers are as told, each named column holds what it is named, and the bodies have the energy that LAMMPS prints."""
    run = run_lammps(LAMMPS, tmp_path)
    found = read_dictionary(tmp_path / "in.deck")
    names = dict(found.meanings.names)
    assert [header(tmp_path / dump.file.replace("*", "1")) for dump in found.meanings.dumps] == [dump.columns for dump in found.meanings.dumps]
    plain, named, bodies = (next(read_dump(tmp_path / f"{name}.1.txt")) for name in ("plain", "named", "bodies"))
    meant = {name: names[name] for name in named.columns if name in names}
    assert sorted(meant.values()) == ["mass", "mol", "omegax", "radius", "tqz", "vy"]  # v_d is c_p[1] and mine is heavy once more
    for name, what in meant.items():
        np.testing.assert_array_equal(named.columns[name], plain.columns[what])
    assert set(bodies.columns) <= set(names)
    np.testing.assert_allclose(spin_energy(bodies, names), run.thermo[0]["c_e"][-1], rtol=1e-12)  # 17 digits on both sides
    assert found.meanings.rigid == "molecule"
    volume = 4.0 / 3.0 * np.pi * plain.columns["radius"] ** 3
    np.testing.assert_allclose(plain.columns["mass"][:3], volume[:3] * found.meanings.density[1], rtol=2e-5)  # 6 digits, radius cubed
    assert 2 not in found.meanings.density


@pytest.mark.liggghts
def test_columns_of_liggghts(tmp_path: Path) -> None:
    """Law: LIGGGHTS has every property that is told, of that length, and the bodies have the energy that it prints."""
    names = {f"c_{p}": p for p in SCALARS} | {f"c_{p}[{i}]": f"{p}[{i}]" for p in VECTORS for i in range(1, 5 if p == "quat" else 4)}
    computes = "\n".join(f"compute {p} all multisphere property {p}" for p in SCALARS + VECTORS)
    text = LIGGGHTS.format(computes=computes, columns=" ".join(names), formats=" ".join(["%.17g"] * len(names)))
    run = run_liggghts(text, tmp_path)
    found = read_dictionary(tmp_path / "in.deck")
    assert dict(found.meanings.names) == names
    assert [header(tmp_path / dump.file.replace("*", "11")) for dump in found.meanings.dumps] == [dump.columns for dump in found.meanings.dumps]
    bodies = next(read_dump(tmp_path / "bodies.11.txt"))
    np.testing.assert_allclose(spin_energy(bodies, names), run.thermo[-1]["e"][-1], rtol=1e-12)  # 17 digits on both sides
    np.testing.assert_array_equal(np.sort(bodies.columns["c_id_multisphere"]), np.arange(1.0, len(bodies.columns["c_masstotal"]) + 1))
    assert found.meanings.rigid == "multisphere"
    assert found.meanings.templates[0].density == 2500.0
    assert found.passed_over == []
