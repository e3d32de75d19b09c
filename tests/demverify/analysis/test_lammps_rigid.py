"""LAMMPS' fix rigid: its `compute erotate/rigid` from the dump of its spheres."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from demsolver.computes import Population, ke
from demsolver.computes.erotate import erotate_by_shape
from demverify.analysis.clumps import rigid_bodies
from demverify.analysis.meanings import Meanings
from demverify.frames import Frame
from tests.support.engines import EngineRun, run_lammps

pytestmark = pytest.mark.lammps
ROUNDING = 1e-12  # numbers in full precision; positions up to 5, arms of 0.5
CLUMPS = (
    np.array([[0.0, 0, 0, 0.5], [0.6, 0, 0, 0.4], [0, 0.5, 0.3, 0.3], [-0.2, 0.3, -0.4, 0.35]]),
    np.array([[0.0, 0, 0, 0.5], [0.7, 0.1, 0, 0.4], [0.2, 0.5, 0.1, 0.3]]),
    np.array([[0.0, 0, 0, 0.5], [0.5, 0, 0.2, 0.4], [1.0, 0, 0, 0.3]]),
)
DECK = """units lj
atom_style hybrid sphere bond
boundary p p p
newton off
comm_modify vel yes
read_data data.clumps
pair_style gran/hooke/history 1000 NULL 10 NULL 0.5 1
pair_coeff * *
neighbor 0.3 bin
timestep 0.002
group members molecule > 0
group free molecule 0
neigh_modify exclude molecule/intra members
fix r members {rigid} molecule
fix n free nve/sphere
compute er all erotate/rigid r
compute kr all ke/rigid r
compute es free erotate/sphere
thermo_style custom step c_er c_kr c_es
thermo_modify norm no format float %.17g
thermo 100
dump d all custom 100 out.dump id mol type x y z vx vy vz omegax omegay omegaz radius mass
dump_modify d sort id format float %.17g
run 1000
"""


def write_data(folder: Path) -> None:
    """27 clumps of three kinds in their own orientation, tumbling, some across the faces of the box; three free spheres."""
    rng = np.random.default_rng(5)
    atoms, velocities = [], []
    for molecule in range(1, 28):
        clump = CLUMPS[molecule % 3]
        arms = Rotation.random(random_state=molecule).apply(clump[:, :3])
        at = 3.3 * np.array([molecule % 3, molecule // 3 % 3, molecule // 9 % 3]) - 4.9 + rng.uniform(-0.1, 0.1, 3)
        speeds = rng.normal(size=3) + np.cross(rng.normal(size=3), arms)
        density = 1.5 + molecule % 2
        atoms += [f"1 {_words(at + arm)} {2 * r:.17g} {density} {molecule}" for arm, r in zip(arms, clump[:, 3], strict=True)]
        velocities += [_words([*v, 0, 0, 0]) for v in speeds]
    for i in range(3):
        atoms.append(f"1 {_words([1.65, 1.65, 3.3 * i - 3.2])} 0.8 2.0 0")
        velocities.append(_words([-1, i, 1, 2, i, 0]))
    head = f"clumps\n\n{len(atoms)} atoms\n1 atom types\n" + "".join(f"-5 5 {a}lo {a}hi\n" for a in "xyz")
    text = "\n\n".join([head, "Atoms # hybrid", _numbered(atoms), "Velocities", _numbered(velocities)])
    (folder / "data.clumps").write_text(text + "\n")


def _words(values) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def _numbered(rows: list[str]) -> str:
    return "\n".join(f"{i} {row}" for i, row in enumerate(rows, 1))


@pytest.fixture(scope="module", params=["rigid", "rigid/small"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> EngineRun:
    """The deck with either fix."""
    folder = tmp_path_factory.mktemp("rigid")
    write_data(folder)
    return run_lammps(DECK.format(rigid=request.param), folder)


def population(frame: Frame) -> Population:
    """Everything in the dump."""
    ids, body = (frame.columns[name].astype(np.int64) for name in ("id", "mol"))
    omega, x, v = (frame.vectors(*names) for names in (("omegax", "omegay", "omegaz"), ("x", "y", "z"), ("vx", "vy", "vz")))
    return Population(ids, frame.columns["mass"], frame.columns["radius"], omega, x, v, body=body)


@pytest.mark.parametrize("omega", [True, False], ids=["omega", "velocities"])
def test_rotational_and_translational_energy(run: EngineRun, omega: bool) -> None:
    """Law: erotate/rigid and ke/rigid are those of bodies with inertia by seed eq. (5), whose omega the members carry, or whose
    velocities tell it, none of them in line; erotate/sphere is what the spheres without a molecule have."""
    printed = run.thermo[0].values
    assert len(printed) == len(run.frames) == 11
    assert np.ptp(printed[:, 1]) > 0.01 * printed[0, 1]  # clumps hit each other
    crossed = 0
    for frame, (step, rotation, motion, spheres) in zip(run.frames, printed, strict=True):
        assert frame.step == step
        everything = population(frame)
        given = everything if omega else replace(everything, omega=None)
        bodies = rigid_bodies(given, frame, Meanings(dialect="lammps", rigid="molecule"))
        energies = dict(erotate_by_shape(replace(everything, bodies=bodies)))
        assert_allclose(energies["multisphere"].total, rotation, rtol=ROUNDING)
        assert_allclose(energies["sphere"].total, spheres, rtol=ROUNDING)
        assert bodies.mass is not None
        assert bodies.v is not None
        assert_allclose(ke(bodies.mass, bodies.v), motion, rtol=ROUNDING)
        crossed += sum(np.ptp(everything.x[everything.body == body], axis=0).max() > 5 for body in bodies.id)
    assert crossed > 20  # bodies in two pieces, at opposite faces


def test_members_carry_the_angular_velocity_of_their_body(run: EngineRun) -> None:
    """Law: fix rigid sets omega of each sphere to that of the body, bit by bit."""
    for frame in run.frames:
        everything = population(frame)
        for body in np.unique(everything.body[everything.body > 0]):
            assert np.ptp(everything.omega[everything.body == body], axis=0).max() == 0.0
