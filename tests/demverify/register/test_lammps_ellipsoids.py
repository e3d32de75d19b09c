"""Register entries on LAMMPS' ellipsoids, as a dump shows them to whoever computes their energy."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from tests.support.deviations import assert_deviates
from tests.support.engines import EngineRun, run_lammps

pytestmark = pytest.mark.lammps

DIAMETERS, DENSITY = np.array([1.0, 2.0, 3.0]), 1.5
DECK = f"""units si
atom_style {{style}}
boundary f f f
region box block -10 10 -10 10 -10 10
create_box 2 box
create_atoms 1 single 0 0 0
create_atoms 2 single 5 0 0
set type 1 shape 1 2 3
set type 1 density {DENSITY}
set type 1 quat 1 2 3 40
set type 1 angmom 1 2 3
{{spin}}
set type 2 mass 2
pair_style none
timestep 0.01
group body type 1
fix n body nve/asphere
compute r body erotate/asphere
compute f all property/atom shapex shapey shapez quatw quati quatj quatk
thermo_style custom step c_r
thermo_modify norm no
dump d all custom 100 out.dump id mass angmomx angmomy angmomz {{columns}} c_f[*]
dump_modify d sort id format float %.17g
run 100
"""


def run(folder: Path, *, hybrid: bool = False) -> EngineRun:
    """A free ellipsoid and a particle without a shape: a point, or in a hybrid style a sphere."""
    if not hybrid:
        return run_lammps(DECK.format(style="ellipsoid", spin="", columns=""), folder)
    return run_lammps(DECK.format(style="hybrid ellipsoid sphere", spin="set group all omega 1 2 3", columns="omegax omegay omegaz"), folder)


@pytest.mark.parametrize("hybrid", [False, True], ids=["point", "sphere"])
def test_what_has_no_shape_is_shown_as_a_ball(hybrid: bool, tmp_path: Path) -> None:
    """Law: a particle without a shape has none to show, 0 0 0, and no orientation. compute property/atom shows a ball of diameter 1."""
    columns = run(tmp_path, hybrid=hybrid).frames[-1].columns
    shown = np.array([[columns[f"c_f[{i}]"][particle] for i in range(1, 8)] for particle in (0, 1)])
    assert shown[0, :3].tolist() == DIAMETERS.tolist()
    assert_deviates("lammps-shape-of-shapeless", shown[1], engine_rule=[1, 1, 1, 1, 0, 0, 0], law=[0] * 7, rtol=1e-12)


def test_the_omega_of_an_ellipsoid_is_never_updated(tmp_path: Path) -> None:
    """Law: omega is I^-1 L. In a hybrid style fix nve/asphere turns the ellipsoid by its angmom, and its omega stays as it was set."""
    end = run(tmp_path, hybrid=True).frames[-1]
    w, *axis = (end.columns[f"c_f[{i}]"][0] for i in (4, 5, 6, 7))
    body_to_space = _rotation(w, np.array(axis))
    squares = (DIAMETERS / 2) ** 2
    moments = end.columns["mass"][0] / 5 * (squares.sum() - squares)
    angmom, omega = (end.vectors(name + "x", name + "y", name + "z")[0] for name in ("angmom", "omega"))
    assert_deviates(
        "lammps-ellipsoid-omega", omega, engine_rule=[1, 2, 3], law=body_to_space @ (body_to_space.T @ angmom / moments), rtol=1e-12
    )


def _rotation(w: float, v: np.ndarray) -> np.ndarray:
    """Matrix of a unit quaternion w, v."""
    across = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * across + 2 * across @ across


def test_density_of_an_ellipsoid_in_a_hybrid_style(tmp_path: Path) -> None:
    """Law: density times the volume of the ellipsoid, as in atom_style ellipsoid. In a hybrid with spheres `set density` takes the radius that
    the particle has as a sphere, 0.5 unless it is set."""
    alone, hybrid = (run(tmp_path / name, hybrid=name == "hybrid").frames[0].columns["mass"][0] for name in ("alone", "hybrid"))
    ellipsoid = DENSITY * pi / 6 * DIAMETERS.prod()
    assert alone == pytest.approx(ellipsoid, rel=1e-12)
    assert_deviates("lammps-hybrid-ellipsoid-density", hybrid, engine_rule=DENSITY * pi / 6, law=ellipsoid, rtol=1e-12)
