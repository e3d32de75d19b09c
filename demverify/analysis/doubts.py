"""What a user should know of the energies of a dump: what was taken for granted, and what the engine got wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demsolver.shapes.multisphere import Template
from demverify.analysis.clump_inertia import diagnose, forecast
from demverify.analysis.meanings import Meanings
from demverify.frames import Floats, Frame


def doubts(inertia: Floats, clumptype: Floats | None, templates: Sequence[Template]) -> list[str]:
    """One line for each kind of body whose principal moments (m, 3) are those of no template it could be of.

    clumptype: (m,) the template of each body; None: any of them.
    """
    _, kinds = np.unique(inertia.sum(axis=1), return_index=True)
    found = []
    for i in kinds if templates else ():
        own = [template for template in templates if clumptype is None or template.kind == clumptype[i]]
        told = [diagnose(inertia[i], template) for template in own]
        if told and None not in told:
            found.append(min(map(str, told), key=len))
    return found


def remarks(frame: Frame, meanings: Meanings) -> list[str]:
    """One line for each thing that a dump of particles does not tell and that was taken for granted."""
    has, dialect = frame.columns.keys(), meanings.dialect_of(frame)
    shaped, printed = "shapex" in has, {"omegax", "angmomx", "mass"} <= has  # then no energy asks for the shape
    found = []
    if dialect == "liggghts" and shaped and not printed and not any({f"{name}1", f"{name}2"} <= has for name in ("blockiness", "roundness")):
        found.append("no columns blockiness1 blockiness2 (it takes both): superquadrics are taken for ellipsoids (2 2)")
    if dialect == "lammps" and shaped and "radius" not in has and not meanings.atom_style and (frame.columns["shapex"] == 1.0).any():
        found.append("particles of shape 1 1 1 without a column radius are taken for points, as in atom_style ellipsoid")
    if dialect == "liggghts" and "mass" not in has and not shaped and not meanings.atom_style and _in_a_plane(frame):
        found.append("nothing moves along z: if the deck says dimension 2, give it with --deck (discs have another mass than spheres)")
    if {"mol", "id_multisphere"} <= has and not np.array_equal(frame.columns["mol"], frame.columns["id_multisphere"]):
        cause = "a float format in dump_modify (register: liggghts-dump-format-integers)"
        found.append(f"mol and id_multisphere differ, which LIGGGHTS writes the same: {cause}")
    return found


def _in_a_plane(frame: Frame) -> bool:
    still = [frame.columns[name] for name in ("vz", "omegax", "omegay") if name in frame.columns]
    return len(still) == 3 and frame.n > 0 and not any(values.any() for values in still) and bool(frame.columns["omegaz"].any())


def forecasts(templates: Sequence[Template]) -> list[str]:
    """One line for each clump whose inertia LIGGGHTS 3.8.0 gets wrong."""
    told = [forecast(template) for template in templates]
    return [line for line in told if line]
