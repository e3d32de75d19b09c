"""A state handed over as a data file is the state, bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from demsolver.scene import Box
from demverify.deck.setup import Atoms, Dialect
from demverify.errors import InputError
from demverify.formats.columns import volume
from demverify.formats.data_file import write_data
from demverify.formats.dump import read_dump
from demverify.formats.reading import Reading
from tests.support.engines import run_lammps, run_liggghts

BOX = Box(np.array([-1.0, 0.0, 0.1]), np.array([1.0, 1.0 / 3.0, 1.1]), ("pp", "ff", "ss"))
COLUMNS = ["id", "type", "x", "y", "z", "ix", "iy", "iz", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "radius", "mass"]
DECKS: dict[Dialect, str] = {
    "lammps": "units si\natom_style sphere\nnewton off\ncomm_modify vel yes\nread_data state.data\n"
    "pair_style gran/hooke/history 2000.0 NULL 50.0 NULL 0.5 0\npair_coeff * *\n",
    "liggghts": """units si
atom_style granular
atom_modify map array
newton off
communicate single vel yes
read_data state.data
neighbor 0.002 bin
fix m1 all property/global youngsModulus peratomtype 5.e6 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
pair_style gran model hertz
pair_coeff * *
""",
}  # fmt: skip


def atoms(n: int = 300, seed: int = 1) -> Atoms:
    """Random particles with masses that owe nothing to a density, ids with gaps, images along x."""
    rng = np.random.default_rng(seed)
    image = np.column_stack([rng.integers(-3, 4, n), np.zeros(n, int), np.zeros(n, int)])
    return Atoms(
        id=rng.permutation(np.arange(1, 3 * n + 1, 3)), type=rng.integers(1, 3, n), x=rng.uniform(BOX.lo, BOX.hi, (n, 3)),
        v=rng.normal(size=(n, 3)), omega=rng.normal(scale=1e3, size=(n, 3)), radius=rng.uniform(1e-3, 1e-2, n),
        mass=rng.lognormal(0, 3, n), mask=np.ones(n, int), image=image, molecule=np.zeros(n, int),
    )  # fmt: skip


@pytest.mark.parametrize(
    "dialect", [pytest.param("lammps", marks=pytest.mark.lammps), pytest.param("liggghts", marks=pytest.mark.liggghts)]
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_engine_reads_back_the_state(dialect: Dialect, dimension: int, tmp_path: Path) -> None:
    """Law: positions, images, velocities, spins and radii come back bit for bit, arbitrary masses within one unit in the last
    place, masses made from a density exactly."""
    state, box = atoms(), BOX
    disc = dialect == "liggghts" and dimension == 2
    state.mass[::2] = volume(state.radius[::2], 2 if disc else 3) * 2500.0
    if dimension == 2:
        box = Box(np.array([-1.0, 0.0, -0.1]), np.array([1.0, 1.0 / 3.0, 0.1]), ("pp", "ff", "pp"))
        state.x[:, 2] = state.v[:, 2] = 0.0
    write_data(tmp_path / "state.data", state, box, 2, dialect, dimension)
    head = f"dimension {dimension}\nboundary {' '.join(flags[0] for flags in box.boundary)}\n"
    dump = f"fix 1 all nve/sphere\ntimestep 1e-9\ndump d all custom 1 d.bin {' '.join(COLUMNS)}\nrun 0\n"
    (run_lammps if dialect == "lammps" else run_liggghts)(head + DECKS[dialect] + dump, tmp_path)
    (got,) = read_dump(tmp_path / "d.bin", Reading(columns=tuple(COLUMNS)))
    order = np.argsort(state.id)
    vectors = {"": state.x, "v": state.v, "omega": state.omega}
    expected: dict[str, NDArray[Any]] = {"id": state.id, "type": state.type, "ix": state.image[:, 0], "radius": state.radius}
    expected |= {prefix + axis: array[:, i] for prefix, array in vectors.items() for i, axis in enumerate("xyz")}
    for name, values in expected.items():
        np.testing.assert_array_equal(got.columns[name], values[order], err_msg=name)
    off = np.abs(got.columns["mass"] - state.mass[order]) / np.spacing(state.mass[order])
    assert off.max() <= 1.0
    assert off[(order % 2) == 0].max() == 0.0


def test_the_quotient_is_the_best_density() -> None:
    """Law: no neighbouring double gives a mass nearer to the one wanted, and nine masses in ten come back exactly."""
    state = atoms(5000)
    space = volume(state.radius)
    density = state.mass / space
    off = np.abs(density * space - state.mass)
    for other in (np.nextafter(density, 0), np.nextafter(density, np.inf)):
        assert (off <= np.abs(other * space - state.mass)).all()
    assert (off <= np.spacing(state.mass)).all()
    assert (off == 0).mean() > 0.85


def test_discs_of_liggghts_have_areas(tmp_path: Path) -> None:
    """Law: in two dimensions LIGGGHTS takes pi R^2 density, LAMMPS a sphere's volume; the file follows."""
    state = atoms(1)
    state.radius[:], state.mass[:] = 0.5, 7.0
    for dialect, space in (("liggghts", np.pi / 4), ("lammps", np.pi / 6)):
        write_data(tmp_path / "d", state, BOX, 2, dialect, dimension=2)  # type: ignore[arg-type]
        row = (tmp_path / "d").read_text().split("Atoms\n\n")[1].split()
        assert float(row[3]) == pytest.approx(7.0 / space, rel=1e-15)


def test_no_particles_is_a_file_too(tmp_path: Path) -> None:
    """Law: an empty box has a head and no sections."""
    write_data(tmp_path / "d", atoms(0), BOX, 2, "lammps")
    assert (tmp_path / "d").read_text().endswith("zlo zhi\n")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mass", np.nan, "mass nan"),
        ("mass", 0.0, "mass 0"),
        ("radius", -1.0, "radius -1"),
        ("x", np.inf, "x inf inf inf"),
        ("omega", np.nan, "omega nan"),
    ],
)
def test_states_that_no_engine_takes_are_refused(tmp_path: Path, name: str, value: float, message: str) -> None:
    """Law: a particle without mass or with numbers that are none is named, and no file is left."""
    state = atoms(3)
    getattr(state, name)[1] = value
    with pytest.raises(InputError, match=f"particle {state.id[1]} cannot go into a data file: {message}"):
        write_data(tmp_path / "d", state, BOX, 2, "lammps")
    assert not list(tmp_path.iterdir())
