"""Rigid bodies of a deck: the clumps it inserts, and how particles belong to bodies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from demsolver.shapes.multisphere import Template
from demverify.deck.dictionary_script import Script, Spoken
from demverify.errors import InputError
from demverify.formats.template import read_template

Membership = Literal["molecule", "multisphere"]
CLUMP = "particletemplate/multisphere"


def clump(cmd: Spoken, folder: Path, coarse: Sequence[float]) -> Template:
    """The clump of a `fix ID group particletemplate/multisphere` of LIGGGHTS. folder: where its file is looked up.

    coarse: factors of coarse graining by type, which scale it. Raises InputError, also where mass and inertia are given outright.
    """
    if "mass" in cmd.args[4:]:
        raise cmd.error("gives mass and inertia outright: they do not follow from the spheres")
    density = cmd.after("density")
    density.choice("distribution of density", ("constant",))
    factor = coarse_factor(coarse, cmd.after("atom_type").integer("atom_type", 1) if "atom_type" in cmd.args else 1)
    rho, kind = density.positive("density"), cmd.after("type").integer("type", 1)
    spheres, count = cmd.after("spheres"), cmd.after("nspheres").integer("nspheres", 1)
    if spheres.skip("file"):
        name = spheres.take("a file")
        template = read_template(folder / name, scale=cmd.after("scale").positive("scale") * factor, density=rho, kind=kind)
        if len(template.radius) != count:
            raise cmd.error(f"says nspheres {count}, and {name} holds {len(template.radius)}")
        return template
    rows = factor * np.array([[spheres.number("x y z r of a sphere") for _ in range(4)] for _ in range(count)])
    if (rows[:, 3] <= 0.0).any():
        raise cmd.error("has a sphere whose radius is not above zero")
    return Template(rows[:, :3], rows[:, 3], rho, kind)


def coarse_factor(coarse: Sequence[float], kind: int) -> float:
    """The factor of coarse graining of a particle type: its own, or the largest where it has none."""
    return coarse[kind - 1] if kind <= len(coarse) else max(coarse, default=1.0)


def distinct(templates: Sequence[Template]) -> tuple[list[Template], list[str]]:
    """Each template once, and why some are left out: two that differ have the same number."""
    found: dict[int, list[Template]] = {}
    for template in templates:
        same = found.setdefault(template.kind, [])
        if not any(_equal(template, other) for other in same):
            same.append(template)
    notes = [f"{len(same)} different clumps have the number {kind}" for kind, same in found.items() if len(same) > 1]
    return [same[0] for same in found.values() if len(same) == 1], notes


def _equal(one: Template, other: Template) -> bool:
    arrays = np.array_equal(one.centre, other.centre) and np.array_equal(one.radius, other.radius)
    return arrays and one.density == other.density


class Rigid:
    """Which fixes hold particles together."""

    def __init__(self, script: Script) -> None:
        """script: where notes go."""
        self._script = script
        self._found: set[Membership | None] = set()

    def concerns(self, cmd: Spoken) -> bool:
        """Whether a command makes bodies, or may."""
        style = cmd.args[2] if cmd.name == "fix" and len(cmd.args) > 2 else ""
        return style.partition("/")[0] in {"rigid", "multisphere", "poems"} or cmd.name in {"include", "jump"}

    def read(self, cmd: Spoken) -> None:
        """Raises InputError where a dump cannot show which particles form a body."""
        cmd.sure()
        if cmd.name != "fix":
            self._found.add(None)
        elif cmd.args[2].startswith("multisphere"):
            self._found.add("multisphere")
        elif cmd.args[3:4] != ("molecule",):
            raise cmd.error(f"{cmd.args[2]} makes bodies of which a dump does not tell the members: it numbers molecules only")
        elif "infile" in cmd.args:
            raise cmd.error(f"{cmd.args[2]} takes mass and inertia of its bodies from a file, which dumps of particles do not show")
        else:
            self._found.add("molecule")
            if cmd.args[1] != "all":
                note = f"only molecules of the group {cmd.args[1]} are rigid; those of other particles are taken as rigid too"
                self._script.note(InputError(note), cmd.place)

    def doubt(self, cmd: Spoken, why: str) -> None:
        """A command could not be read."""
        self._found.add(None)

    def result(self) -> tuple[Literal["molecule", "multisphere", "none"] | None, list[str]]:
        """How particles belong to bodies, None: not known; and why not."""
        if not self._found:
            return "none", []
        if len(self._found) == 1:
            return next(iter(self._found)), []
        return None, ["there are several kinds of rigid bodies"] if None not in self._found else []
