"""Which of the two dialects a deck is written in."""

from __future__ import annotations

import re
from pathlib import Path

from demverify.deck.lexer import read_text
from demverify.deck.setup import Dialect

_LIGGGHTS = re.compile(
    r"^\s*(atom_style\s+(granular|superquadric|hybrid\s+granular)|pair_style\s+gran\s|communicate\s|fix\s+\S+\s+\S+\s+(property/global|check/timestep/gran|mesh/)"
    r"|(soft_particles|hard_particles|coarsegraining)\s|fix\s.*wall/gran\s+model\s)",
    re.MULTILINE,
)


def detect_dialect(path: Path) -> Dialect:
    """liggghts when the file is called so (in.liggghts, x.liggghts) or speaks its words, else lammps; x.lammps is lammps.

    Raises InputError for a file that cannot be read."""
    name = path.name.lower()
    if "liggghts" in name:
        return "liggghts"
    if name.endswith(".lammps"):
        return "lammps"
    return "liggghts" if _LIGGGHTS.search(read_text(path)) else "lammps"
