"""The native engine's files are the engines' own: the same numbers give the same bytes.

Each engine runs one small deck, which dumps the exact doubles (binary) beside every text form; our writers, fed with the doubles,
must make the engine's text.
"""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from demsolver.scene import Box, Particles
from demverify.deck.setup import Dialect, DumpSpec
from demverify.formats.columns import COLUMNS, Snapshot, snapshot_frame
from demverify.formats.dump import DumpWriter, read_dump
from demverify.formats.log import read_thermo
from demverify.formats.reading import Reading
from demverify.formats.thermo import ThermoTable
from demverify.frames import Frame
from tests.demverify.formats.samples import spec
from tests.support.engines import run_lammps, run_liggghts

COMMON = tuple(name for name in COLUMNS if name not in ("mol", "density"))
ALL: dict[Dialect, tuple[str, ...]] = {"lammps": COMMON, "liggghts": (*COMMON, "density")}

START = """region box block -0.1 0.123456789012 0 0.1 0 0.1
create_box 2 box
"""
SPHERES = """create_atoms 1 single 0.01 0.02 0.03
create_atoms 2 single 0.0195 0.02 0.0301
create_atoms 1 single 0.12 0.05 0.07
set group all diameter 0.01 density 2500
set atom 2 diameter 0.011 density 1234.567
velocity all set 0.3 0.1 -0.2
set atom 3 image 2 NULL NULL
set atom 3 vx 3.14159
group none empty
"""
RUN: dict[Dialect, str] = {
    "lammps": "units si\natom_style sphere\nboundary p fs m\nnewton off\ncomm_modify vel yes\n" + START + SPHERES
    + "pair_style gran/hooke/history 2000.0 NULL 50.0 NULL 0.5 0\npair_coeff * *\ntimestep 1e-5\nfix 1 all nve/sphere\n"
    "compute er all erotate/sphere\n",
    "liggghts": "units si\natom_style granular\natom_modify map array\nboundary p fs m\nnewton off\ncommunicate single vel yes\n"
    + START + SPHERES.replace("group none empty\n", "group none type 2\ngroup none subtract none none\n")
    + """neighbor 0.002 bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 5.e6 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
fix m4 all property/global coefficientFriction peratomtypepair 2 0.05 0.05 0.05 0.05
pair_style gran model hertz tangential history
pair_coeff * *
timestep 0.00001
fix integr all nve/sphere
compute er all erotate/sphere
compute longname12 all erotate
""",
}  # fmt: skip

SHORT = ("id", "type", "x", "y", "z")
DUMPS: dict[Dialect, list[DumpSpec]] = {
    "lammps": [
        spec("default.txt", COMMON, sort="id"),
        spec("formats.txt", SHORT, sort="-3", format={"float": "%20.15g", "int": "%05d", "3": "%-12.4e"}),
        spec("line.txt", SHORT, sort="4", format={"line": "%d  %d %8.3f %g   %lg"}),
        spec("step.*.txt", SHORT, sort="id", pad=6),
        spec("zipped.txt.gz", SHORT, sort="id"),
        spec("step.*.bin", SHORT, sort="id"),
    ],
    "liggghts": [
        spec("default.txt", ALL["liggghts"], sort="id"),
        spec("line.txt", SHORT, sort="-3", format={"line": "%05d  %d %20.15g %-12.4e %g"}),
        spec("step.*.txt", SHORT, sort="id", pad=6),
        spec("step.*.bin", SHORT, sort="id"),
    ],
}


def commands(dialect: Dialect, dump: DumpSpec, number: int) -> str:
    """The dump as the deck says it."""
    pieces = [f"sort {dump.sort}"] + [f"pad {dump.pad}"] * (dump.pad > 0)
    for key, value in dump.format.items():
        pieces.append(f'format {key} "{value}"' if dialect == "lammps" else f'format "{value}"')
    return f"dump d{number} all custom 100 {dump.file} {' '.join(dump.columns)}\ndump_modify d{number} {' '.join(pieces)}\n"


def run(dialect: Dialect, folder: Path, tail: str) -> str:
    """Runs the deck of the dialect with `tail`; returns what was printed."""
    return (run_lammps if dialect == "lammps" else run_liggghts)(RUN[dialect] + tail, folder).log


both = pytest.mark.parametrize(
    "dialect", [pytest.param("lammps", marks=pytest.mark.lammps), pytest.param("liggghts", marks=pytest.mark.liggghts)]
)


@pytest.fixture(scope="module")
def dumped(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Dialect], Path]:
    """The folder of one run of an engine with all its dumps and exact.bin."""
    done: dict[Dialect, Path] = {}

    def folder(dialect: Dialect) -> Path:
        if dialect not in done:
            dumps = [spec("exact.bin", ALL[dialect], sort="id"), *DUMPS[dialect]]
            extra = "dump e none custom 100 empty.txt id x\ndump f none custom 100 empty.bin id x\n"
            path = tmp_path_factory.mktemp(dialect)
            run(dialect, path, "".join(commands(dialect, d, i) for i, d in enumerate(dumps)) + extra + "run 200\n")
            done[dialect] = path
        return done[dialect]

    return folder


def content(path: Path) -> bytes:
    """Bytes of a file, unpacked."""
    data = path.read_bytes()
    return gzip.decompress(data) if path.suffix == ".gz" else data


@both
def test_dumps_are_the_engines_bytes(dialect: Dialect, dumped: Callable[[Dialect], Path], tmp_path: Path) -> None:
    """Law: every dump written anew from the doubles is the engine's file, byte for byte, name included."""
    engine = dumped(dialect)
    exact = list(read_dump(engine / "exact.bin", Reading(columns=tuple(ALL[dialect]))))
    assert [frame.step for frame in exact] == [0, 100, 200]
    for dump in DUMPS[dialect]:
        with DumpWriter(dump, dialect, tmp_path) as writer:
            for frame in exact:
                writer.write(frame)
        names = [dump.file.replace("*", f"{frame.step:06d}" if dump.pad else f"{frame.step}") for frame in exact]
        for name in names:
            assert content(tmp_path / name) == content(engine / name), name


@both
def test_empty_groups_are_the_engines_bytes(dialect: Dialect, dumped: Callable[[Dialect], Path], tmp_path: Path) -> None:
    """Law: frames without particles are written as the engine writes them, in text and in binary."""
    engine = dumped(dialect)
    for name in ("empty.txt", "empty.bin"):
        with DumpWriter(spec(name, ("id", "x")), dialect, tmp_path) as writer:
            for frame in read_dump(engine / "exact.bin", Reading(columns=tuple(ALL[dialect]))):
                writer.write(Frame(frame.step, frame.box, frame.boundary, {"id": np.empty(0), "x": np.empty(0)}))
        assert (tmp_path / name).read_bytes() == (engine / name).read_bytes()
        assert [frame.n for frame in read_dump(engine / name, Reading(columns=("id", "x")))] == [0, 0, 0]


def snapshot(frame: Frame) -> Snapshot:
    """The solver's arrays for an engine's frame."""
    vector, ints = frame.vectors, {name: frame.columns[name].astype(np.int64) for name in ("id", "type")}
    particles = Particles(
        **ints, x=vector("x", "y", "z"), v=vector("vx", "vy", "vz"), omega=vector("omegax", "omegay", "omegaz"),
        radius=frame.columns["radius"], mass=frame.columns["mass"], mask=ints["id"],
        image=vector("ix", "iy", "iz").astype(np.int64),
    )  # fmt: skip
    box = Box(frame.box[:, 0], frame.box[:, 1], frame.boundary)
    return Snapshot(frame.step, box, particles, vector("fx", "fy", "fz"), vector("tqx", "tqy", "tqz"), ints["id"])


@both
def test_derived_columns_have_the_engines_bits(dialect: Dialect, dumped: Callable[[Dialect], Path]) -> None:
    """Law: scaled, unwrapped and diameter columns computed from x, image, box and radius are the engine's to the last bit;
    density, which LIGGGHTS stores and we divide out, to one unit in the last place."""
    for frame in read_dump(dumped(dialect) / "exact.bin", Reading(columns=tuple(ALL[dialect]))):
        ours = snapshot_frame(snapshot(frame), ALL[dialect])
        for name in COMMON:
            np.testing.assert_array_equal(ours.columns[name], frame.columns[name], err_msg=name)
        if dialect == "liggghts":
            np.testing.assert_allclose(ours.columns["density"], frame.columns["density"], rtol=3e-16)


TABLES: dict[Dialect, list[tuple[str, tuple[str, ...]]]] = {
    "lammps": [
        ("one", ("step", "temp", "epair", "emol", "etotal", "press", "vol")),
        *[("custom", tuple(words.split())) for words in (
            "step atoms ke c_er pe vol etotal temp press",
            "step elapsed elaplong time dt cpu lx ly lz xlo xhi ylo yhi zlo zhi density fmax fnorm",
            "step enthalpy evdwl ecoul epair emol elong etail ebond eangle edihed eimp pxx pyy pzz pxy pxz pyz",
            "step nbuild ndanger part",
        )],
    ],
    "liggghts": [
        ("one", ("step", "atoms", "ke", "cpu", "vol")),
        *[("custom", tuple(words.split())) for words in (
            "step atoms ke c_er vol c_longname12 elapsed elaplong time dt cpu part cu",
            "step lx ly lz xlo xhi ylo yhi zlo zhi density fmax fnorm",
        )],
    ],
}  # fmt: skip


@both
def test_thermo_tables_are_the_engines_bytes(dialect: Dialect, tmp_path: Path) -> None:
    """Law: header and row made from the doubles (of a second `run 0` of the same state, with %.17g) are the engine's lines."""
    tail = "thermo 1\n"
    for style, keywords in TABLES[dialect]:
        words = " ".join(keywords) if style == "custom" else ""
        tail += f'thermo_style {style} {words}\nrun 0\nthermo_style {style} {words}\nthermo_modify format float "%.17g"\nrun 0\n'
    (tmp_path / "log").write_text(run(dialect, tmp_path, tail))
    printed = (tmp_path / "log").read_text().splitlines(keepends=True)
    tables = read_thermo(tmp_path / "log")
    assert len(tables) == 2 * len(TABLES[dialect])
    for exact, (_, keywords) in zip(tables[1::2], TABLES[dialect], strict=True):
        ours = ThermoTable(keywords, dialect, {})
        assert ours.header() in printed
        assert ours.row(exact.values[0]) in printed


@both
def test_thermo_formats_are_the_engines_bytes(dialect: Dialect, tmp_path: Path) -> None:
    """Law: thermo_modify format float and by column print as in the engine; line and int too in LAMMPS."""
    formats: list[dict[str, str]] = [{"float": "%12.4e"}, {"3": "%9.2f"}, {"float": "%g", "4": "%-20.10g"}]
    if dialect == "lammps":
        formats += [{"int": "%4d"}, {"line": "%d %d %g %10.3e"}, {"line": "%d %d %g %10.3e", "float": "%.1f", "-1": "%.2f"}]
    style = "thermo_style custom step atoms ke c_er\n"
    tail = style + 'thermo_modify format float "%.17g"\nrun 0\n'
    for some in formats:
        tail += style + "".join(f'thermo_modify format {key} "{value}"\n' for key, value in some.items()) + "run 0\n"
    (tmp_path / "log").write_text(run(dialect, tmp_path, tail))
    printed = (tmp_path / "log").read_text().splitlines(keepends=True)
    values = read_thermo(tmp_path / "log")[0].values[0]
    for some in formats:
        assert ThermoTable(("step", "atoms", "ke", "c_er"), dialect, some).row(values) in printed, some
