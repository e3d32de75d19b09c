"""What a deck says of its particles: which densities they have, by type, and which clumps it inserts."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from demsolver.shapes.multisphere import Template
from demverify.deck.dictionary_clumps import CLUMP, clump
from demverify.deck.dictionary_data import data_densities, has_density
from demverify.deck.dictionary_density import Choice, Densities, Values
from demverify.deck.dictionary_script import Script, Spoken
from demverify.deck.setup import Dialect
from demverify.errors import InputError

_SET = ("type", "type/fraction", "type/ratio", "type/subset", "density", "density/disc", "diameter", "shape", "mass")
_INSERTIONS = ("pour", "deposit", "particletemplate", "adapt")  # fixes, up to the first slash
_LARGEST_ID = 2**31 - 1


class Particles:
    """Where particles come from and what changes them. dimension: of the deck. style: words of the atom_style command, (): not known."""

    def __init__(self, script: Script, dialect: Dialect) -> None:
        """script: variables, folder and notes."""
        self.dimension = 3
        self.densities = Densities()
        self.templates: list[Template] = []
        self._script, self._dialect = script, dialect
        self.style: tuple[str, ...] = ("atomic",)
        self._coarse: list[float] | None = []  # factors by type; None: not known
        self._readers: dict[str, Callable[[Spoken], None]] = {
            "atom_style": self._atom_style,
            "coarsegraining": self._coarse_graining,
            "create_box": self._create_box,
            "create_atoms": self._create_atoms,
            "read_data": self._read_data,
            "read_restart": self._from_elsewhere,
            "include": self._from_elsewhere,
            "jump": self._from_elsewhere,
            "set": self._set,
            "group": self._group,
            "delete_atoms": self._renumbered,
            "replicate": self._renumbered,
            "reset_ids": self._renumbered,
            "reset_atoms": self._renumbered,
            "fix": self._fix,
        }

    def concerns(self, cmd: Spoken) -> bool:
        """Whether a command is about particles' densities or clumps."""
        if cmd.name == "set":
            return any(word in _SET for word in cmd.args[2:])
        if cmd.name == "fix":
            return len(cmd.args) > 2 and cmd.args[2].partition("/")[0] in _INSERTIONS
        return cmd.name in self._readers

    def read(self, cmd: Spoken) -> None:
        """Raises InputError for what cannot be told. A clump counts wherever it stands: its number shows whether it was used."""
        if CLUMP not in cmd.args:
            cmd.sure()
        self._readers[cmd.name](cmd)

    def doubt(self, cmd: Spoken, why: str) -> None:
        """A command could not be read: what it might have changed is not known any more."""
        if cmd.name == "set":
            self.densities.put(self.densities.something(), {None: why})
        elif cmd.name == "group":
            self.densities.ungroup(cmd.args[0] if cmd.args else "")
        elif cmd.name in {"delete_atoms", "replicate", "reset_ids", "reset_atoms"}:
            self.densities.forget_ids()
        elif cmd.name == "coarsegraining":
            self._coarse = None
        elif cmd.name == "atom_style":
            self.style = ()
        elif cmd.name != "create_box" and CLUMP not in cmd.args:
            self.densities.unknown(why)

    def _atom_style(self, cmd: Spoken) -> None:
        self.style = cmd.rest()

    def _coarse_graining(self, cmd: Spoken) -> None:
        factors = list(self._coarse or ())
        while cmd and cmd.peek() != "model_check":
            factors.append(cmd.positive("factor"))
        self._coarse = factors

    def _create_box(self, cmd: Spoken) -> None:
        self.densities.types = cmd.integer("number of types", 1)

    def _create_atoms(self, cmd: Spoken) -> None:
        kinds = {cmd.integer("type", 0)}
        single = cmd.peek() == "single"
        if "mol" in cmd.args:
            raise cmd.error("makes molecules, whose densities stand elsewhere")
        for index, word in enumerate(cmd.args[:-2]):
            if word == "basis":
                kinds.add(Spoken(("basis", cmd.args[index + 2]), cmd.text, cmd.place, certain=True, unknown=cmd.unknown).integer("type"))
        for kind in sorted(kinds) if self._has_density() else ():
            self.densities.create(kind, self._default(cmd), single=single and len(kinds) == 1)

    def _has_density(self) -> bool:
        return not self.style or has_density(self.style)

    def _default(self, cmd: Spoken) -> Values:
        """Particles of create_atoms are spheres of density 1 in both engines, those of atom_style ellipsoid points."""
        if self.style and "ellipsoid" not in self.style:
            return {1.0: f"default of create_atoms, {cmd.where}"}
        return {None: f"create_atoms, {cmd.where}, without a density"}

    def _read_data(self, cmd: Spoken) -> None:
        path = self._script.find_file(cmd.take("a file"))
        if not self._has_density():
            return
        if not self.style:
            raise cmd.error("reads particles whose atom_style is not known")
        offset = cmd.after("offset").integer("offset of types", 0) if "offset" in cmd.args else 0
        try:
            data = data_densities(path if _opens(path) else Path(f"{path}.gz"), self.style)
        except InputError as error:
            raise cmd.error(str(error)) from None
        self.densities.types = max(self.densities.types, data.types + offset)
        for kind, values in data.values.items():
            if values:
                self.densities.create(kind + offset, dict.fromkeys(values, f"{path.name}, {cmd.where}"))

    def _from_elsewhere(self, cmd: Spoken) -> None:
        self.style = () if self.style == ("atomic",) else self.style
        self.densities.unknown(f"{cmd.name} {cmd.peek()}, {cmd.where}".replace("\0", "?"))

    def _renumbered(self, cmd: Spoken) -> None:
        self.densities.forget_ids()

    def _group(self, cmd: Spoken) -> None:
        name, style = cmd.take("an ID"), cmd.take("a style")
        kinds = [_type_range(word) for word in cmd.args[2:]] if style == "type" else [None]
        if style in {"clear", "delete"}:
            self.densities.ungroup(name)
        for kind in kinds:
            self.densities.group(name, self.densities.something() if kind is None else self.densities.of_types(kind))

    def _set(self, cmd: Spoken) -> None:
        choice = self._chosen(cmd, cmd.take("a style"))
        for index, word in enumerate(cmd.args[2:], start=3):
            if word in _SET:
                value = Spoken((f"set {word}", *cmd.args[index:]), cmd.text, cmd.place, certain=True, unknown=cmd.unknown)
                choice = self._set_one(word, value, choice)

    def _chosen(self, cmd: Spoken, style: str) -> Choice:
        which = cmd.take(f"a {style}")
        if style == "group":
            return self.densities.of_group(which)
        if style not in {"type", "atom"}:
            return self.densities.something()
        if which == "*":
            return self.densities.everything()
        found = re.fullmatch(r"(\d{0,9})(\*?)(\d{0,9})", which, re.ASCII)
        if not found or not any(found.group(1, 3)) or (found[3] and not found[2]):
            raise cmd.error(f"{style} expects a number or a range such as 2*5, got {which!r}")
        low = int(found[1] or 1)
        high = low if not found[2] else int(found[3] or (_LARGEST_ID if style == "atom" else max(self.densities.types, low)))
        if high < low:
            return []
        return self.densities.of_ids(range(low, high + 1)) if style == "atom" else self.densities.of_types(range(low, high + 1))

    def _set_one(self, keyword: str, value: Spoken, choice: Choice) -> Choice:
        if keyword == "type":
            return self.densities.retype(choice, value.integer("type", 1))
        if keyword.startswith("type"):  # a fraction, which is drawn
            return self.densities.retype([(lot, False) for lot, _ in choice], value.integer("type", 1))
        if keyword == "mass" or (keyword == "density/disc" and self.dimension == 2):
            self.densities.put(choice, {None: f"mass set in another way, {value.where}"})
        elif keyword.startswith("density"):
            self.densities.put(choice, {self._number(value): value.where})
        elif self._dialect == "lammps":  # keeps the mass of a particle whose size is set; LIGGGHTS keeps the density
            self.densities.put(choice, {None: f"{keyword} set after density, {value.where}"})
        return choice

    def _number(self, value: Spoken) -> float:
        if value.peek().startswith("v_"):
            return self._script.variables.number(value.take("density")[2:], value.place)
        return value.positive("density")

    def _fix(self, cmd: Spoken) -> None:
        style, args = cmd.args[2], cmd.args[3:]
        if style == CLUMP:
            if self._coarse is None:
                raise cmd.error("is coarse grained by a factor that is not known")
            self.templates.append(clump(cmd, self._script.folder, self._coarse))
        elif style.startswith("adapt"):
            if self._dialect == "lammps" and "atom" in args and any(word.startswith("diameter") for word in args):
                raise cmd.error("changes diameters while runs go on, and densities with them")
        elif "mol" in args or "spheres_different_types" in args:
            raise cmd.error("inserts particles of types that stand elsewhere")
        elif self._has_density():
            self.densities.insert(*(_template(cmd) if style.startswith("particletemplate") else self._inserted(cmd)))

    def _inserted(self, cmd: Spoken) -> tuple[int, Values]:
        """Type and density of `fix pour` and `fix deposit`: N type seed ... [dens lo hi]."""
        words = Spoken((cmd.name, *cmd.args[3:]), cmd.text, cmd.place, certain=True, unknown=cmd.unknown)
        words.integer("number of particles")
        kind = words.integer("type", 1)
        if "dens" not in cmd.args:
            return kind, {1.0: f"default of fix {cmd.args[2]}, {cmd.where}"}
        density = cmd.after("dens")
        low, high = density.positive("density"), density.positive("density")
        return kind, {low: cmd.where} if low == high else {None: f"densities from {low:g} to {high:g}, {cmd.where}"}


def _opens(path: Path) -> bool:
    try:
        path.open("rb").close()
    except OSError:
        return False
    return True


def _template(cmd: Spoken) -> tuple[int, Values]:
    """Type and density of a particletemplate of LIGGGHTS."""
    kind = cmd.after("atom_type").integer("atom_type", 1) if "atom_type" in cmd.args else 1
    density = cmd.after("density")
    if density.skip("constant"):
        return kind, {density.positive("density"): cmd.where}
    return kind, {None: f"a density with the distribution {density.peek()}, {cmd.where}"}


def _type_range(word: str) -> range | None:
    """N, N:M or N:M:STEP of a group; None for anything else."""
    found = re.fullmatch(r"(\d{1,9})(?::(\d{1,9})(?::([1-9]\d{0,8}))?)?", word, re.ASCII)
    return range(int(found[1]), int(found[2] or found[1]) + 1, int(found[3] or 1)) if found else None
