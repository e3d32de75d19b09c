"""Every small real file in tests/data/dumps: read to stated numbers, or refused with a stated reason."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.errors import InputError
from demverify.formats.dump import read_dump
from demverify.formats.reading import AS_WRITTEN, Reading
from tests.demverify.formats.samples import DATA

NAMED = {  # files without column names, with those of the dump command
    "liggghts/d.bin": ("id", "type", "x", "y", "z", "radius"),
    "liggghts/tilted/tilted.bin": ("id", "x", "y", "z"),
    "lammps/headless.txt": ("id", "type", "x", "y", "z", "radius"),
}
READ = {  # steps, rows a frame, columns
    "lammps/all.bin": ([0, 100, 200, 300, 400], 3, 22),
    "lammps/all.txt": ([0, 100, 200, 300, 400], 3, 22),
    "lammps/all.txt.gz": ([0, 100, 200, 300, 400], 3, 5),
    "lammps/atom.bin": ([0, 100, 200, 300, 400], 3, 5),
    "lammps/entries.local": ([0, 10, 20], 0, 5),
    "lammps/general.bin": ([0, 1], 3, 8),
    "lammps/general.txt": ([0, 1], 3, 8),
    "lammps/general_scaled.bin": ([0, 1], 3, 5),
    "lammps/headless.txt": ([0, 1, 2], 20, 6),  # nothing tells the steps: they are counted
    "lammps/none.txt": ([0, 200, 400], 0, 3),
    "lammps/none.yaml": ([0, 1], 0, 2),
    "lammps/renamed.txt": ([0, 10, 20], 20, 6),
    "lammps/scaled.txt": ([0, 10, 20], 20, 5),
    **{f"lammps/step.{step}.txt": ([step], 3, 5) for step in (0, 100, 200, 300, 400)},
    "lammps/tilted.bin": ([0, 10, 20], 20, 6),
    "lammps/tilted.txt.gz": ([0, 10, 20], 20, 5),
    "lammps/tilted.yaml": ([0, 10, 20], 20, 5),
    "lammps/triclinic.bin": ([0, 10, 20], 20, 6),
    "lammps/triclinic.txt": ([0, 10, 20], 20, 17),
    "lammps/units.txt": ([0, 10, 20], 20, 8),
    "liggghts/d.bin": ([0, 10, 20], 3, 6),
    "liggghts/d.local": ([0, 10, 20], 2, 13),
    "liggghts/d.txt": ([0, 10, 20], 3, 16),
    "liggghts/d10.vtk": ([10], 3, 15),
    "liggghts/l10.vtp": ([10], 2, 6),
    "liggghts/tilted/tilted.bin": ([0], 2, 4),
    "liggghts/tilted/tilted0.vtk": ([0], 2, 4),
    "liggghts/tilted/tilted0.vtp": ([0], 2, 4),
    "liggghts/vtk/ascii10.vtk": ([10], 3, 27),
    "liggghts/vtk/ascii10.vtp": ([10], 3, 16),
    "liggghts/vtk/binary10.vtk": ([10], 3, 27),
    "liggghts/vtk/exact.txt": ([0, 10], 3, 24),
    "liggghts/vtk/inline10.vtp": ([10], 3, 16),
    "liggghts/vtk/none10.vtk": ([10], 0, 3),
    "liggghts/vtk/none10.vtp": ([10], 0, 5),
    "liggghts/vtk/share10.pvtp": ([10], 3, 5),
    "liggghts/vtk/triangles10.vtk": ([10], 2, 5),
    "liggghts/vtk/triangles10.vtp": ([10], 2, 5),
    "liggghts/vtk/zlib10.vtu": ([10], 3, 16),
}
BOX = "a box without particles"
REFUSED = {
    "lammps/averages.txt": "not a dump of particles, text or binary: output of fix ave/time",
    "lammps/averages.yaml": "not a dump of particles, text or binary: output of fix ave/time",
    "lammps/log.lammps": "not a dump of particles, text or binary: a log of LAMMPS",
    "lammps/samples.log": "not a dump of particles, text or binary: a log of LAMMPS",
    "lammps/words.yaml": "element expects a number, got 'A'",
    "liggghts/averages.txt": "not a dump of particles, text or binary: output of fix ave/time",
    "liggghts/log.liggghts": "not a dump of particles, text or binary: a log of LIGGGHTS",
    "liggghts/vtk/bare10.vtk": "positions alone, without an id",
    "liggghts/vtk/lz10.vtp": "vtkLZ4DataCompressor",
    "liggghts/vtk/lzboundingBox_10.vtr": "vtkLZ4DataCompressor",
    "liggghts/vtk/nostep.vtk": "does not say its step",
    "liggghts/vtk/share10_0.vtp": "one processor's share of share10.pvtp",
    **{
        f"liggghts/{name}": BOX
        for name in (
            *("dboundingBox_10.vtk", "tilted/tiltedboundingBox_0.vtk", "tilted/tiltedboundingBox_0.vtu"),
            *("vtk/asciiboundingBox_10.vtk", "vtk/asciiboundingBox_10.vtr", "vtk/bareboundingBox_10.vtk", "vtk/binaryboundingBox_10.vtk"),
            *("vtk/inlineboundingBox_10.vtr", "vtk/noneboundingBox_10.vtk", "vtk/noneboundingBox_10.vtr", "vtk/zlibboundingBox_10.vtr"),
        )
    },
}
NO_DUMPS = {"README.md", "in.lammps", "in.general", "in.vtk", "in.tilted"}


@pytest.mark.parametrize("name", READ)
def test_reads(name: str) -> None:
    """Law: steps, rows and columns are those that the deck of the file asked for; every number is finite."""
    frames = list(read_dump(DATA / name, Reading(columns=NAMED[name]) if name in NAMED else AS_WRITTEN))
    steps, rows, columns = READ[name]
    assert [frame.step for frame in frames] == steps
    assert {(frame.n, len(frame.columns)) for frame in frames} == {(rows, columns)}
    assert all(np.isfinite(values).all() for frame in frames for values in frame.columns.values())


@pytest.mark.parametrize("name", REFUSED)
def test_refuses(name: str) -> None:
    """Law: what is no dump, or cannot be one alone, is refused in one line that names the file and the reason."""
    with pytest.raises(InputError, match=REFUSED[name]) as caught:
        list(read_dump(DATA / name))
    assert str(DATA / name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_file_is_forgotten() -> None:
    """Law: every file is in one of the lists above."""
    found = {str(path.relative_to(DATA)) for path in DATA.rglob("*") if path.is_file() and path.name not in NO_DUMPS}
    assert found == {*READ, *REFUSED}
    assert not READ.keys() & REFUSED.keys()
