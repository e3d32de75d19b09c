"""`demverify erotate` on the command line: what goes in, what comes out, what is refused."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as ET

import h5py
import numpy as np
import pytest

from tests.support.cli import Call, files_in

DATA = Path(__file__).parents[2] / "data" / "superquadric"
KEYS = ["step", "time", "n", "erotate", "sphere", "multisphere", "superquadric", "ke"]
HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n"
Write = Callable[..., Path]


def dump(*steps: int, columns: str = "id type radius mass omegax omegay omegaz", rows: str = "1 1 0.5 2 0 3 0\n2 1 0.5 2 0 0 1\n") -> str:
    """A text dump with the same rows at every step; rotational energies 0.9 and 0.1."""
    return "".join(HEAD.format(step=step, n=rows.count("\n")) + f"ITEM: ATOMS {columns}\n{rows}" for step in steps)


def test_the_table(demverify: Call, write: Write) -> None:
    """Law: the default output is one row a frame under the names of the columns; what is not known is a dash."""
    done = demverify("erotate", write(dump(0, 10), "d.dump"))
    rows = [line.split() for line in done.out.splitlines()]
    assert (done.status, done.err) == (0, "")
    assert rows[0] == KEYS
    assert rows[1:] == [[step, "-", "2", "1.0", "1.0", "0.0", "0.0", "-"] for step in ("0", "10")]


def test_every_output_says_the_same(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: JSON is a list of objects with the names of the columns; CSV and HDF5 hold the same numbers, all digits; the picture is XML."""
    path = DATA / "free.dump.gz"
    out = {kind: tmp_path / f"o.{kind}" for kind in ("json", "csv", "h5", "svg")}
    done = demverify("erotate", path, "--timestep", "1e-5", "--json", out["json"], "--csv", out["csv"], "--h5", out["h5"], "--plot", out["svg"])
    assert done.status == 0, done.err
    rows = json.loads(out["json"].read_text())
    assert [list(row) for row in rows] == [KEYS] * len(rows)
    assert [row["time"] for row in rows] == [row["step"] * 1e-5 for row in rows]
    with out["csv"].open() as stream:
        assert [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)] == rows
    with h5py.File(out["h5"]) as file:
        assert {name: file[name][:].tolist() for name in file} == {name: [row[name] for row in rows] for name in KEYS}
    assert ET.parse(out["svg"]).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    assert done.out.split()[len(KEYS) + 3] == repr(rows[0]["erotate"])


def test_a_series_of_files_is_one_run(demverify: Call, write: Write) -> None:
    """Law: files of a pattern are read in the order of their steps, whatever their names and endings."""
    for step, name in ((0, "post/d0.chute"), (1000, "post/d1000.chute"), (200, "post/d200.chute")):
        write(dump(step), name)
    last = write(dump(300), "post/another.stream")
    pattern = last.parent / "*.*"
    assert [line.split()[0] for line in demverify("erotate", pattern).out.splitlines()[1:]] == ["0", "200", "300", "1000"]


def test_every_particle(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: --per-particle gives the energy of each particle; they add up to the total."""
    done = demverify("erotate", write(dump(5), "d.dump"), "--per-particle", "--json", tmp_path / "o.json", "--h5", tmp_path / "o.h5")
    rows = [dict(zip(done.out.split()[:5], line.split(), strict=True)) for line in done.out.splitlines()[1:]]
    assert rows == [
        {"step": "5", "time": "-", "shape": "sphere", "id": i, "erotate": e} for i, e in (("1", "0.9"), ("2", "0.1"))
    ]
    assert [list(row) for row in json.loads((tmp_path / "o.json").read_text())] == [["step", "time", "shape", "id", "erotate"]] * 2
    with h5py.File(tmp_path / "o.h5") as file:
        assert file["shape"][:].tolist() == [b"sphere"] * 2
        assert file["erotate"][:].sum() == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads_gives_the_same(demverify: Call, write: Write, threads: int) -> None:
    """Law: the table does not depend on how many read."""
    path = write(dump(*range(0, 400, 2)), "d.dump")
    lines = demverify("erotate", path, DATA / "nothing" / ".." / "free.dump.gz", "--threads", threads)
    assert lines.status == 2  # another run's file: different particles at step 0
    assert [int(line.split()[0]) for line in demverify("erotate", path, "--threads", threads).out.splitlines()[1:]] == list(range(0, 400, 2))


def test_a_half_written_frame_is_told_and_the_rest_is_used(demverify: Call, write: Write) -> None:
    """Law: a run that is still going on leaves half a frame; it is reported on stderr, and the whole frames count."""
    done = demverify("erotate", write(dump(0, 10)[:-9], "d.dump"))
    assert done.status == 0
    assert [line.split()[0] for line in done.out.splitlines()] == ["step", "0"]
    assert "the file ends inside a frame" in done.err
    assert "the frames before it are used" in done.err


def test_a_number_that_is_none(demverify: Call, write: Write, tmp_path: Path) -> None:
    """Law: nan in a frame is reported with step and id, its row says nan (JSON: null), the others stand, and the status is 1."""
    path = write(dump(0) + dump(10, rows="1 1 0.5 2 0 nan 0\n2 1 0.5 2 0 0 1\n") + dump(20), "d.dump")
    done = demverify("erotate", path, "--json", tmp_path / "o.json")
    assert done.status == 1
    assert "step 10: omega of particle 1 is not finite" in done.err
    assert [row["erotate"] for row in json.loads((tmp_path / "o.json").read_text())] == [1.0, None, 1.0]


DECK = """atom_style sphere
units si
timestep 0.5
compute w all property/atom omegax omegay omegaz
compute r all reduce sum vx
region b block 0 1 0 1 0 1
create_box 1 b
create_atoms 1 single 0.5 0.5 0.5
set type 1 density 3.8197186342054881
dump d all custom 10 d.dump id type radius c_w[1] c_w[2] c_w[3]
some command that only a newer version knows
"""


def test_the_deck_is_the_dictionary(demverify: Call, write: Write) -> None:
    """Law: a deck that no engine here can run still says what columns are, the density, and the time step."""
    rows = dump(0, 10, columns="id type radius c_w[1] c_w[2] c_w[3]", rows="1 1 0.5 0 3 0\n2 1 0.5 0 0 1\n")
    path, deck = write(rows, "d.dump"), write(DECK, "in.x")
    done = demverify("erotate", path, "--deck", deck)
    assert done.status == 0, done.err
    table = [line.split() for line in done.out.splitlines()[1:]]
    assert [row[1] for row in table] == ["0.0", "5.0"]
    assert [float(row[3]) for row in table] == pytest.approx([1.0, 1.0], rel=1e-14)  # density of 15 digits times a volume
    named = demverify("erotate", path, "--columns", "id type radius omegax omegay omegaz", "--density", "3.8197186342054881")
    assert [row.split()[3] for row in named.out.splitlines()] == [row.split()[3] for row in done.out.splitlines()]


def test_a_density_that_nobody_needs_is_no_news(demverify: Call, write: Write) -> None:
    """Law: that the deck has two densities for a type is told where a dump without mass needs one, with the lines, and not else."""
    deck = write(DECK + "run 1\nset type 1 density 7\nrun 1\n", "in.x")
    done = demverify("erotate", write(dump(0), "d.dump"), "--deck", deck)
    assert (done.status, done.err) == (0, "")
    light = dump(0, columns="id type radius c_w[1] c_w[2] c_w[3]", rows="1 1 0.5 0 3 0\n2 1 0.5 0 0 1\n")
    done = demverify("erotate", write(light, "l.dump"), "--deck", deck)
    assert done.status == 2
    assert "the density of type 1 is not known: " in done.err
    assert "in.x:" in done.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("no.dump",), "no dump file no.dump; its folder has"),
        (("d.dump", "--density", "-1"), "density -1.0: expected a number above 0"),
        (("d.dump", "--density", "nan"), "density nan: expected a number above 0"),
        (("d.dump", "--timestep", "0"), "timestep 0.0: expected a number above 0"),
        (("d.dump", "--json", "no/o.json"), "there is no folder no"),
        (("d.dump", "--plot", "."), "it is a folder"),
        (("d.dump", "--deck", "no.deck"), "no.deck: cannot read the file"),
        (("d.dump", "--template", "no.ms"), "no.ms: cannot"),
        (("d.dump", "--columns", "id type"), r"2 names were given (id type) for 7 columns"),
        (("d.dump", "--columns", "id type radius mass omegax omegay x"), "erotate/sphere needs the columns omegax omegay omegaz"),
        (("d.dump", "--halfstep"), "the half-step option needs the columns tqx tqy tqz"),
        (("d.dump", "--inertia", "dice"), "'dice' is not one of 'union', 'spheres'"),
        (("d.dump", "--bodies", "d.dump"), "d.dump: step 0: the dump of particles needs a column id_multisphere or mol"),
        (("d.dump", "--threads", "0"), "--threads"),
        (("d.dump", "--scheduler", "tcp://127.0.0.1:1"), "no Dask scheduler at tcp://127.0.0.1:1"),
        ((), "Missing argument 'FILE...'"),
    ],
)
def test_wrong_words(demverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], message: str) -> None:
    """Law: what cannot be done is one line on stderr, status 2, nothing on stdout and nothing written."""
    write(dump(0), "d.dump")
    monkeypatch.chdir(tmp_path)
    done = demverify("erotate", *words)
    assert (done.status, done.out) == (2, "")
    assert message in done.err
    assert done.err.count("\n") == 1
    assert files_in(tmp_path) == {"d.dump"}


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path: Path) -> None:
    """Law: frames are read one after the other: eight times the frames need no more memory."""
    import subprocess
    import sys

    rng = np.random.default_rng(1)
    rows = "".join(f"{i} 1 0.5 2 {x:g} {y:g} {z:g}\n" for i, (x, y, z) in enumerate(rng.normal(size=(20000, 3)), 1))
    peaks = []
    for frames in (4, 32):
        path = tmp_path / f"{frames}.dump"
        with path.open("w") as stream:
            for step in range(frames):
                stream.write(dump(step, rows=rows))
        code = (
            "import resource, sys; from demverify.analysis.erotate import erotate; "
            f"erotate({str(path)!r}); print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
        )
        peaks.append(int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout))
    assert peaks[1] < peaks[0] + 10_000  # kB; 28 frames more are 18 MB of text and 22 MB of numbers


def test_a_later_frame_with_other_columns(demverify: Call, write: Write) -> None:
    """Law: the columns named in a message are those of the frame it is about."""
    path = write(dump(0) + dump(10, columns="id type radius mass vx vy vz"), "d.dump")
    done = demverify("erotate", path)
    assert done.status == 2
    assert done.err.strip().endswith("step 10: erotate/sphere needs the columns omegax omegay omegaz; the dump has id type radius mass vx vy vz")
