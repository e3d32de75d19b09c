"""Two overlapping spheres, as a deck for each engine, in a folder of its own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from demverify.engines import ENGINES
from demverify.engines.base import Job, Missing, Outcome
from tests.support.engines import unavailable

PREAMBLE = {
    "lammps": "units si\natom_style sphere\nboundary f f f\nnewton off\ncomm_modify vel yes\n",
    "liggghts": "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n",
}
CONTACT = {
    "lammps": "pair_style gran/hooke/history 1000 300 50 25 0.5 1\npair_coeff * *\n",
    "liggghts": """fix m1 all property/global kn peratomtypepair 1 1000
fix m2 all property/global kt peratomtypepair 1 300
fix m3 all property/global gamman peratomtypepair 1 50
fix m4 all property/global gammat peratomtypepair 1 25
fix m5 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
""",
}
SPHERES = """test

2 atoms
1 atom types
-1 1 xlo xhi
-1 1 ylo yhi
-1 1 zlo zhi

Atoms

1 1 0.2 2500 -0.095 0 0
2 1 0.2 2500 0.095 0 0
"""
MOTION = "neighbor 0.1 bin\nneigh_modify delay 0\ntimestep 1e-5\nset atom 1 vx 0.5\nfix nve all nve/sphere\nthermo 10\n"

Write = Callable[..., Path]
Run = Callable[..., Outcome]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """write(engine, tail, read="data.two"): a deck of the two spheres that ends with `tail`, beside its data file."""

    def deck(engine: str, tail: str, read: str = "data.two") -> Path:
        home = tmp_path / "home"
        home.mkdir(exist_ok=True)
        (home / "data.two").write_text(SPHERES)
        path = home / f"in.{engine}"
        path.write_text(f"{PREAMBLE[engine]}read_data {read}\n{CONTACT[engine]}{MOTION}{tail}")
        return path

    return deck


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """run(engine, deck, **job): the outcome; skips the test where the engine is missing."""

    def go(engine: str, deck: Path, **options: object) -> Outcome:
        found = ENGINES[engine].find()
        if isinstance(found, Missing):
            unavailable(str(found))
        progress = options.pop("progress", None)
        folder = options.pop("folder", tmp_path / "out")
        job = Job(deck, folder, **{"timeout_s": 60.0, **options})  # type: ignore[arg-type]
        return ENGINES[engine].run(job, progress)  # type: ignore[arg-type]

    return go
