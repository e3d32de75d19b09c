"""The MDAnalysis analysis class: every backend gives what `demverify.erotate` gives of the same dump, within MDAnalysis' float32."""

from __future__ import annotations

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import demverify
from demverify.errors import InputError

mda = pytest.importorskip("MDAnalysis")
pytestmark = pytest.mark.filterwarnings("ignore:.*:UserWarning", "ignore:.*:DeprecationWarning")

SUPERQUADRICS = Path(__file__).parents[1] / "data" / "superquadric" / "free.dump.gz"
HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\nITEM: ATOMS {columns} \n"
COLUMNS = "id type x y z vx vy vz omegax omegay omegaz radius mass"
DECK = """atom_style granular
units si
timestep 0.25
region b block 0 1 0 1 0 1
create_box 1 b
create_atoms 1 single 0.5 0.5 0.5
set type 1 density 2500
compute w all property/atom omegax
compute s all property/atom omegay omegaz
dump d all custom 100 d.dump id ${unknown}
"""
FLOAT32 = 2.0**-22  # squares of numbers that are rounded to float32
BACKENDS: list[dict[str, Any]] = [
    {},
    {"backend": "multiprocessing", "n_workers": 2},
    {"backend": "multiprocessing", "n_workers": 2, "n_parts": 5},
    {"backend": "dask", "n_workers": 2},
]


def written(path: Path, columns: str = COLUMNS, frames: int = 7, n: int = 5, *, bad: bool = False) -> Path:
    """A dump as LIGGGHTS writes it, all digits, rows in any order, of steps 0, 100, ... bad: one spin of step 300 is nan."""
    rng = np.random.default_rng(3)
    with path.open("w") as stream:
        for k in range(frames):
            stream.write(HEAD.format(step=100 * k, n=n, columns=columns))
            for i in (rng.permutation(n) + 1).tolist():
                values = {name: f"{value:.17g}" for name, value in zip(columns.split(), rng.uniform(0.1, 0.9, 40), strict=False)}
                values |= {"id": str(i), "type": "1"} | ({"omegay": "nan"} if bad and (k, i) == (3, 2) else {})
                stream.write(" ".join(values[name] for name in columns.split()) + " \n")
    return path


@pytest.fixture
def opened(tmp_path: Path) -> Callable[..., Any]:
    """opened(**how): a dump and its Universe."""

    def make(path: Path | None = None, additional_columns: bool | None = True, **how: Any) -> tuple[Path, Any]:
        path = path or written(tmp_path / "d.dump", **how)
        universe = mda.Universe(str(path), format="LAMMPSDUMP", topology_format="LAMMPSDUMP", additional_columns=additional_columns)
        return path, universe

    return make


def table_of(series: Any) -> np.ndarray:
    """A Series as the class would give it."""
    return np.column_stack([series[name] for name in ("step", "time", "n", "erotate", "sphere", "multisphere", "superquadric", "ke")])


@pytest.mark.parametrize(
    ("backend", "options"),
    [(BACKENDS[0], {}), *((backend, {"density": 2.5, "timestep": 0.5}) for backend in BACKENDS)],
    ids=["mass", "serial", "multiprocessing", "more parts than workers", "dask"],
)
def test_every_backend_gives_the_same(opened: Callable[..., Any], backend: dict[str, Any], options: dict[str, float]) -> None:
    """Law: rotational energies are bit for bit those of the file (spins, radii and masses are float64), those of translation to float32; the
    backends differ in no bit; options reach other processes."""
    from demverify.mdanalysis import Erotate

    path, universe = opened(columns=COLUMNS if not options else COLUMNS.removesuffix(" mass"))
    run = Erotate(universe, **options).run(**backend)
    expected = table_of(demverify.erotate(path, **options))
    assert run.results.columns == ("step", "time", "n", "erotate", "sphere", "multisphere", "superquadric", "ke")
    assert run.results.table.shape == expected.shape == (7, 8)
    np.testing.assert_array_equal(run.results.table[:, :-1], expected[:, :-1])
    np.testing.assert_allclose(run.results.ke, expected[:, -1], rtol=FLOAT32)
    serial = run if not backend else Erotate(universe, **options).run()
    np.testing.assert_array_equal(run.results.table, serial.results.table)
    for name, column in zip(run.results.columns, run.results.table.T, strict=True):
        np.testing.assert_array_equal(run.results[name], column)
    assert run.results.notes == []
    assert run.frames.tolist() == list(range(7))


@pytest.mark.parametrize("some", [{"start": 1, "stop": 6, "step": 2}, {"start": -2}, {"step": 3}, {"frames": [5, 0]}, {"stop": 0}], ids=str)
@pytest.mark.parametrize("backend", BACKENDS[:2], ids=["serial", "multiprocessing"])
def test_some_frames(opened: Callable[..., Any], some: dict[str, Any], backend: dict[str, Any]) -> None:
    """Law: start, stop, step and frames choose rows as slices do, none at all included; a second run forgets the first."""
    from demverify.mdanalysis import Erotate

    _, universe = opened()
    analysis = Erotate(universe)
    everything = analysis.run().results.table
    which = some.get("frames", range(7)[slice(some.get("start"), some.get("stop"), some.get("step"))])
    chosen = analysis.run(**some, **backend)
    np.testing.assert_array_equal(chosen.results.table, everything[list(which)].reshape(-1, 8))
    assert chosen.frames.tolist() == list(which)


def test_the_library_call_takes_a_universe(opened: Callable[..., Any]) -> None:
    """Law: `demverify.erotate(universe)` is the class without a class."""
    from demverify.mdanalysis import Erotate

    path, universe = opened()
    np.testing.assert_array_equal(table_of(demverify.erotate(universe)), Erotate(universe).run().results.table)
    np.testing.assert_array_equal(demverify.erotate(universe)["erotate"], demverify.erotate(path)["erotate"])


@pytest.mark.parametrize("backend", BACKENDS[::3] + BACKENDS[1:2], ids=["serial", "dask", "multiprocessing"])
def test_no_spins(opened: Callable[..., Any], backend: dict[str, Any]) -> None:
    """Law: without the columns it needs the class raises an InputError of one line that names them, whatever the backend."""
    from demverify.mdanalysis import Erotate

    _, universe = opened(columns=COLUMNS.replace("omega", "beta"))
    with pytest.raises(InputError) as caught:
        Erotate(universe).run(**backend)
    assert "erotate/sphere needs the columns omegax omegay omegaz; the dump has " in caught.value.message
    assert "betax" in caught.value.message
    assert "additional_columns" not in caught.value.message
    assert "\n" not in caught.value.message


def test_columns_that_were_not_asked_for(opened: Callable[..., Any]) -> None:
    """Law: where MDAnalysis was not told to read other columns the message says how to."""
    from demverify.mdanalysis import Erotate

    _, universe = opened(additional_columns=None)
    with pytest.raises(InputError, match=r"omegax omegay omegaz; .* with additional_columns=True MDAnalysis shows what else is in it"):
        Erotate(universe).run()


@pytest.mark.parametrize("backend", BACKENDS[:2], ids=["serial", "multiprocessing"])
def test_a_number_that_is_none(opened: Callable[..., Any], backend: dict[str, Any]) -> None:
    """Law: nan makes its row nan and a note with step and id; the other rows stand."""
    from demverify.mdanalysis import Erotate

    _, universe = opened(bad=True)
    found = Erotate(universe).run(**backend).results
    assert np.flatnonzero(np.isnan(found.erotate)).tolist() == [3]
    assert found.notes == ["step 300: omega of particle 2 is not finite"]


@pytest.mark.parametrize("backend", BACKENDS[:2], ids=["serial", "multiprocessing"])
def test_the_deck_is_the_dictionary(opened: Callable[..., Any], tmp_path: Path, backend: dict[str, Any]) -> None:
    """Law: a deck says what columns are, the density and the time step, also in another process; what it passes over is noted."""
    from demverify.mdanalysis import Erotate

    deck = tmp_path / "in.liggghts"
    deck.write_text(DECK)
    columns = COLUMNS.replace("omegax omegay omegaz", "c_w c_s[1] c_s[2]").removesuffix(" mass")
    path, universe = opened(columns=columns)
    of_file, found = demverify.erotate(path, deck=deck), Erotate(universe, deck=deck).run(**backend).results
    np.testing.assert_array_equal(found.table[:, :-1], table_of(of_file)[:, :-1])
    assert found.time.tolist() == [25.0 * k for k in range(7)]
    assert found.erotate.all()
    assert found.notes == list(of_file.notes)
    assert "unknown" in found.notes[0]
    np.testing.assert_array_equal(demverify.erotate(universe, deck=deck)["erotate"], found.erotate)


def test_superquadrics(opened: Callable[..., Any], tmp_path: Path) -> None:
    """Law: shapes, quaternions and spins of a real LIGGGHTS dump are additional columns too; who wrote it must be told."""
    from demverify.mdanalysis import Erotate

    path, deck = tmp_path / "free.dump", tmp_path / "in.liggghts"
    path.write_bytes(gzip.decompress(SUPERQUADRICS.read_bytes()))
    deck.write_text("atom_style superquadric\nunits si\ntimestep 1e-5\n")
    _, universe = opened(path)
    found = Erotate(universe, deck=deck).run().results
    np.testing.assert_array_equal(found.erotate, demverify.erotate(path)["erotate"])
    np.testing.assert_array_equal(found.superquadric, found.erotate)
    assert (found.superquadric > 0.0).all()
    with pytest.raises(InputError, match="shapex is a semi-axis in LIGGGHTS and a diameter in LAMMPS"):
        Erotate(universe).run()


def test_clumps(opened: Callable[..., Any], tmp_path: Path) -> None:
    """Law: members, template and the convention for the inertia go through; positions are float32, here 2e-8 of arms of 0.3."""
    from demverify.mdanalysis import Erotate

    path, template = tmp_path / "d.dump", tmp_path / "t.ms"
    template.write_text("-0.3 0 0 0.5\n0.3 0 0 0.5\n")
    rows = "1 1 0.25 0.5 0.5 0 0 -0.6 0 2 0 0.5 3 \n2 1 0.85 0.5 0.5 0 0 -1.8 0 2 0 0.5 3 \n"
    path.write_text(HEAD.format(step=0, n=2, columns=COLUMNS.replace("type", "id_multisphere")) + rows)
    _, universe = opened(path)
    for options in ({"templates": [template]}, {"inertia": "spheres"}, {"inertia": "union"}):
        found = Erotate(universe, **options).run().results
        np.testing.assert_allclose(found.multisphere, demverify.erotate(path, **options)["multisphere"], rtol=1e-6)
        assert found.sphere == 0.0


def test_the_limits_are_those_of_mdanalysis(opened: Callable[..., Any], tmp_path: Path) -> None:
    """Law: what the docstring calls limits of MDAnalysis are errors there, and none here."""
    from demverify.mdanalysis import Erotate

    more = tmp_path / "more.dump"
    of_five, of_four = (written(tmp_path / f"{n}.dump", frames=2, n=n).read_text() for n in (5, 4))
    more.write_text(of_five + of_four)
    units = tmp_path / "units.dump"
    units.write_text("ITEM: UNITS\nsi\n" + written(tmp_path / "c.dump").read_text())
    with pytest.raises(ValueError, match="Number of atoms in trajectory changed"):
        Erotate(opened(more)[1]).run()
    assert demverify.erotate(more)["n"].tolist() == [4, 4]
    with pytest.raises(ValueError, match="No id column found"):
        opened(units)
    assert len(demverify.erotate(units).rows) == 7


def test_mdanalysis_is_not_imported_without_need() -> None:
    """Law: `import demverify` and its `erotate` work where MDAnalysis is not installed."""
    code = "import sys; sys.modules['MDAnalysis'] = None; import demverify; demverify.erotate"
    subprocess.run([sys.executable, "-c", code], check=True)
