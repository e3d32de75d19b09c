"""Adding a contact law touches one file: a new file in the folder is a word of the deck and acts in the force sum."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from demsolver import contact
from demsolver.reference import forces
from demsolver.scene import Box, Particles, Scene
from demverify.deck import materials_lammps
from demverify.engines.base import Job
from demverify.errors import InputError
from demverify.runs import execute
from tests.support.contact_cases import setup_of

QUARTIC = '''"""Hardening spring: F = k2 overlap^2 + k4 overlap^4. Source: this test."""


def force(overlap: float, k2: float, k4: float) -> float:
    """Elastic normal force."""
    return k2 * overlap**2 + k4 * overlap**4


def energy(overlap: float, k2: float, k4: float) -> float:
    """Elastic energy."""
    return k2 * overlap**3 / 3.0 + k4 * overlap**5 / 5.0
'''
DECK = ["pair_style granular", "pair_coeff * * hardening 3e6 5e10 40.0 damping velocity tangential linear_nohistory 0.0 0.0"]


@pytest.fixture
def hardening(tmp_path: Path) -> Iterator[None]:
    """The folder of contact laws with one more file in it, for the length of a test."""
    (tmp_path / "normal_hardening.py").write_text(QUARTIC)
    contact.__path__.append(str(tmp_path))
    importlib.invalidate_caches()
    yield
    contact.__path__.remove(str(tmp_path))
    sys.modules.pop("demsolver.contact.normal_hardening", None)


@pytest.mark.usefixtures("hardening")
def test_a_new_file_is_a_new_word() -> None:
    """The deck's numbers are the coefficients of force() in the order of its signature, then the damping coefficient."""
    law = materials_lammps.pair_law(setup_of(DECK, "lammps", ntypes=1))
    assert law is not None
    assert law.normal == "hardening"
    assert {name: float(law.coefficients[name][0, 0]) for name in ("k2", "k4", "gamman")} == {
        "k2": 3e6,
        "k4": 5e10,
        "gamman": 40.0,
    }


@pytest.mark.usefixtures("hardening")
def test_a_new_law_acts() -> None:
    """Two spheres of radius 1 cm, overlapping by 1 mm, approaching at 0.1 m/s: F = 3e6 1e-6 + 5e10 1e-12 + 40 0.1 = 7.05 N."""
    x = np.array([[0.0, 0, 0], [0.019, 0, 0]])
    v = np.array([[0.0, 0, 0], [-0.1, 0, 0]])
    ones, still = np.ones(2, int), np.zeros((2, 3))
    particles = Particles(np.array([1, 2]), ones, x, v, still, np.full(2, 0.01), np.full(2, 1e-3), ones, np.zeros((2, 3), int))
    law = materials_lammps.pair_law(setup_of(DECK, "lammps", ntypes=1))
    scene = Scene(Box(np.full(3, -1.0), np.full(3, 1.0), ("ff", "ff", "ff")), particles, 1, 1e-6, pair=law)
    force, torque, _ = forces(scene, x, v, still, {}, True)
    assert force == pytest.approx(np.array([[-7.05, 0, 0], [7.05, 0, 0]]), rel=1e-12)
    assert not torque.any()


def test_without_the_file_the_word_is_unknown() -> None:
    """The error lists the laws that exist."""
    with pytest.raises(InputError, match=r"normal model 'hardening' is not one of .*hertz, hooke"):
        materials_lammps.pair_law(setup_of(DECK, "lammps", ntypes=1))


@pytest.mark.usefixtures("hardening")
def test_a_new_law_runs_compiled_from_a_deck(tmp_path: Path) -> None:
    """Undamped, the spheres part as fast as they met and the budget's elastic energy at the turning point is what they brought:
    the compiled loop has the force and the energy of the new file."""
    deck = tmp_path / "in.lammps"
    pair = DECK[1].replace(" 40.0 ", " 0.0 ")
    deck.write_text(f"""units si
atom_style sphere
boundary f f f
region box block -0.1 0.1 -0.1 0.1 -0.1 0.1
create_box 1 box
create_atoms 1 single -0.0101 0 0
create_atoms 1 single 0.0101 0 0
set type 1 diameter 0.02 density 2500
set atom 1 vx 0.1
set atom 2 vx -0.1
{DECK[0]}
{pair}
timestep 1e-6
fix n all nve/sphere
run 20000
""")
    run = execute("native", "native", Job(deck, tmp_path / "out", every=20), keep=True, budget=True)
    v = np.array([frame.columns["vx"] for frame in run.frames])
    elastic, kinetic = (np.array([getattr(b, name) for _, _, b in run.budgets]) for name in ("elastic_normal", "kinetic"))
    assert v[-1] == pytest.approx([-0.1, 0.1], rel=1e-4)
    assert elastic.max() == pytest.approx(kinetic[0], rel=1e-4)
    assert elastic + kinetic == pytest.approx(kinetic[0], rel=1e-6)  # of order dt^2: some 5,000 steps a contact
