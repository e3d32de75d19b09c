"""What the columns of a deck's dumps are: computes and variables of particles and bodies, the dump commands and their new names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from demverify.analysis.meanings import DumpWords
from demverify.deck.dictionary_script import UNKNOWN, Script, Spoken

_XYZ = ("x", "y", "z")
_PARTICLE = {  # attribute of compute property/atom -> word of dump custom
    **{name: name for name in ("id", "mol", "type", "mass", "radius", "diameter")},
    **{p + a + s: p + a + s for a in _XYZ for p, s in (("", ""), ("", "s"), ("", "u"), ("i", ""), ("v", ""), ("f", ""))},
    **{p + a: p + a for a in _XYZ for p in ("omega", "angmom", "tq", "shape")},
    **{f"quat{old}": f"quat{new}" for new, old in enumerate("wijk", start=1)},
}
_IN_FORMULA = {  # of an atom-style variable; LIGGGHTS knows those of the last two lines
    **{name: name for name in ("id", "mol", "type", "mass", "radius", *(p + a for a in _XYZ for p in ("", "v", "f")))},
    **{p + a: p + a for a in _XYZ for p in ("omega", "tq")},
    "r": "radius",
    "density": "density",
    **{f"quat{i}": f"quat{i}" for i in (1, 2, 3, 4)},
}
_BODY = {  # attribute of LAMMPS' compute rigid/local -> property of a body
    "mol": "id_multisphere",
    "mass": "masstotal",
    **{a: f"xcm[{i}]" for i, a in enumerate(_XYZ, start=1)},
    **{old + a: f"{new}[{i}]" for i, a in enumerate(_XYZ, start=1) for old, new in (("v", "vcm"), ("f", "fcm"), ("tq", "torque"))},
    **{name + a: f"{name}[{i}]" for i, a in enumerate(_XYZ, start=1) for name in ("omega", "angmom", "inertia")},
    **{f"quat{a}": f"quat[{i}]" for i, a in enumerate("wijk", start=1)},
}
_VECTORS = {"quat": 4, **dict.fromkeys(("xcm", "vcm", "fcm", "torque", "angmom", "omega", "inertia", "ex_space", "ey_space", "ez_space"), 3)}
_SCALARS = ("id_multisphere", "masstotal", "clumptype", "atomtype", "nrigid")
_LISTED = ("custom", "local", "yaml", "netcdf", "vtk")  # dump styles, up to the first slash, whose arguments are columns


@dataclass(frozen=True)
class _Source:
    """What a compute or variable gives. meanings: its column -> what that is. group: particles outside have zeros."""

    meanings: Mapping[str, str]
    length: int = 0
    group: str = "all"


@dataclass
class _Dump:
    """A dump command. renamed: index of a column -> its new name."""

    words: DumpWords
    group: str
    renamed: dict[int, str]

    def header(self, index: int) -> str:
        """What the header calls a column."""
        return self.renamed.get(index, self.words.columns[index])


class Columns:
    """Computes, variables and dumps, in the order of the deck. What is undone later is kept, and an `if` does not matter: a column that
    a user has was written."""

    def __init__(self, script: Script) -> None:
        """script: where notes go."""
        self.dumps: list[_Dump] = []
        self._script = script
        self._sources: dict[str, list[_Source]] = {}
        self._open: dict[str, _Dump] = {}

    @property
    def dumping(self) -> bool:
        """Whether a run writes files now."""
        return bool(self._open)

    def concerns(self, cmd: Spoken) -> bool:
        """Whether a command defines or writes columns."""
        if cmd.name == "variable":
            return len(cmd.args) > 1 and cmd.args[1] == "atom"
        return cmd.name in {"compute", "dump", "undump", "dump_modify", "write_dump"} and len(cmd.args) > (cmd.name != "undump")

    def read(self, cmd: Spoken) -> None:
        """Raises InputError for what cannot be told."""
        if cmd.name == "undump":
            self._open.pop(cmd.args[0] if cmd.args else "", None)
        elif cmd.name == "dump_modify":
            self._modify(cmd)
        elif cmd.name in {"dump", "write_dump"}:
            self._dump(cmd)
        else:
            define = self._compute if cmd.name == "compute" else self._variable
            self._sources.setdefault(f"{cmd.name[0]}_{cmd.take('an ID')}", []).append(define(cmd))

    def doubt(self, cmd: Spoken, why: str) -> None:
        """A command could not be read: its columns have no meaning."""
        if cmd.name in {"compute", "variable"}:
            self._sources.setdefault(f"{cmd.name[0]}_{cmd.args[0]}", []).append(_Source({}))

    def _compute(self, cmd: Spoken) -> _Source:
        name, group, style = f"c_{cmd.args[0]}", cmd.args[1], cmd.args[2] if len(cmd.args) > 2 else ""
        if UNKNOWN in style or (style in {"property/atom", "rigid/local"} and UNKNOWN in "".join(cmd.args)):
            raise cmd.error(f"has words that are not known: {'; '.join(dict.fromkeys(cmd.unknown))}")
        if style == "property/atom":
            return _listed(name, cmd.args[3:], _PARTICLE, group)
        if style == "rigid/local":
            owner = {} if "mol" in cmd.args[4:] else {"id": "id_multisphere"}
            return _listed(name, cmd.args[4:], {**_BODY, **owner}, "all")
        if style in {"multisphere", "rigid"}:
            what = cmd.after("property").take("a property")
            count = _VECTORS.get(what, 0)
            return _Source({f"{name}[{i}]": f"{what}[{i}]" for i in range(1, count + 1)} or ({name: what} if what in _SCALARS else {}), count)
        return _Source({})

    def _variable(self, cmd: Spoken) -> _Source:
        name, formula = f"v_{cmd.args[0]}", re.sub(r"\s", "", "".join(cmd.args[2:]))
        while formula.startswith("(") and formula.endswith(")"):
            formula = formula[1:-1]
        if formula in _IN_FORMULA:
            return _Source({name: _IN_FORMULA[formula]})
        source, meaning = self._source(formula)
        return _Source({name: meaning}, group=source.group) if meaning else _Source({})

    def _source(self, column: str) -> tuple[_Source, str]:
        """The source of a column such as c_ID[2], and what it is; "" where that is not known."""
        sources = self._sources.get(column.partition("[")[0], [])
        if not sources or _differ(sources):
            return _Source({}), ""
        return sources[0], sources[0].meanings.get(column, "")

    def _dump(self, cmd: Spoken) -> None:
        args = cmd.args if cmd.name == "dump" else ("", *cmd.args[:2], "1", *cmd.args[2:])
        modify = args.index("modify") if cmd.name == "write_dump" and "modify" in args else len(args)
        name, group, style, _, file = (*args[:modify], "", "", "", "", "")[:5]
        if UNKNOWN in name + group + style:
            raise cmd.error("has words that are not known")
        kind = style.partition("/")[0]
        if kind not in (*_LISTED, "atom"):
            return
        columns = args[5:modify] if kind != "atom" else ("id", "type", "xs", "ys", "zs")
        if UNKNOWN in "".join(columns):
            raise cmd.error(f"has columns that are not known: {'; '.join(dict.fromkeys(cmd.unknown))}")
        expanded = tuple(name for column in columns for name in self._expanded(column, cmd))
        dump = _Dump(DumpWords(re.sub(rf"[{UNKNOWN}*]+", "*", file), style, expanded), group, {})
        self.dumps.append(dump)
        if cmd.name == "dump":
            self._open[name] = dump
        self._modified(dump, args[modify + 1 :], cmd)

    def _expanded(self, column: str, cmd: Spoken) -> list[str]:
        """c_ID[*], c_ID[2*] ... as the columns they stand for."""
        found = re.fullmatch(r"([cfv]_\w+)\[(\d{0,9})\*(\d{0,9})\]", column, re.ASCII)
        if not found:
            return [column]
        source = (self._sources.get(found[1]) or [_Source({})])[-1]
        last = int(found[3] or source.length)
        if not last or last > source.length:
            raise cmd.error(f"has the column {column}, and how many it stands for is not known")
        return [f"{found[1]}[{i}]" for i in range(int(found[2] or 1), last + 1)]

    def _modify(self, cmd: Spoken) -> None:
        dump = self._open.get(cmd.args[0])
        if dump is not None:
            self._modified(dump, cmd.args[1:], cmd)

    def _modified(self, dump: _Dump, args: Sequence[str], cmd: Spoken) -> None:
        columns = dump.words.columns
        for index, keyword in enumerate(args):
            value, new = (*args[index + 1 :], "", "")[:2]
            if keyword == "colname":
                if UNKNOWN in value + new:
                    raise cmd.error("gives a column a name that is not known")
                self._rename(dump, value, new)
            elif dump.words.style.startswith("atom") and keyword in {"scale", "image"} and value in {"yes", "no", "on", "off"}:
                columns = _atom_columns(columns, keyword, value in {"yes", "on"})
        dump.words = replace(dump.words, columns=columns)

    def _rename(self, dump: _Dump, which: str, new: str) -> None:
        """A column by its number from 1, or from -1 at the end, or by its name; `default` takes all new names back."""
        columns = dump.words.columns
        if which == "default":
            dump.renamed.clear()
        elif re.fullmatch(r"-?\d{1,9}", which):
            index = int(which) - 1 if int(which) > 0 else len(columns) + int(which)
            dump.renamed.update({index: new} if 0 <= index < len(columns) else {})
        elif which in columns:
            dump.renamed[len(columns) - 1 - columns[::-1].index(which)] = new

    def result(self) -> tuple[dict[str, str], list[DumpWords], list[str]]:
        """Column -> what it is, the dumps with the columns as their headers name them, and why some columns have no meaning."""
        meant: dict[str, set[str]] = {}
        for sources in self._sources.values():
            for column in dict.fromkeys(column for source in sources for column in source.meanings):
                meant.setdefault(column, set()).add(self._meaning(column))
        twice: set[str] = set()
        for dump in self.dumps:
            headed = {dump.header(i): self._meaning(column) for i, column in enumerate(dump.words.columns)}
            taken = {header for header, meaning in headed.items() if header == meaning}
            for header, meaning in headed.items():
                meant.setdefault(header, set()).add(meaning)
                if meaning and header != meaning:
                    (twice if meaning in taken else taken).add(header if meaning in taken else meaning)
        notes = [f"column {name} has several meanings" for name, several in meant.items() if len(several) > 1]
        notes += [f"{name} is defined in several ways" for name, sources in self._sources.items() if _differ(sources)]
        names = {name: next(iter(one)) for name, one in meant.items() if len(one) == 1}
        dumps = [replace(dump.words, columns=tuple(map(dump.header, range(len(dump.words.columns))))) for dump in self.dumps]
        return {name: what for name, what in names.items() if what not in ("", name) and name not in twice}, dumps, notes

    def _meaning(self, column: str) -> str:
        """What a column is before it is renamed, "" where that is not known or where particles outside of a group would have zeros."""
        if not re.match(r"[cv]_", column):
            return "" if re.match(r"[fid]2?_", column) else column
        source, meaning = self._source(column)
        groups = {dump.group for dump in self.dumps if column in dump.words.columns}
        return meaning if source.group == "all" or groups == {source.group} else ""


def _differ(sources: Sequence[_Source]) -> bool:
    return any(source != sources[0] for source in sources)


def _listed(name: str, attributes: Sequence[str], table: Mapping[str, str], group: str) -> _Source:
    """A compute whose columns are a list of attributes; with a single one it is a vector without an index."""
    columns = [f"{name}[{i}]" for i in range(1, len(attributes) + 1)] if len(attributes) > 1 else [name]
    meanings = {column: table[what] for column, what in zip(columns, attributes, strict=False) if what in table}
    return _Source(meanings, len(attributes) if len(attributes) > 1 else 0, group)


def _atom_columns(columns: tuple[str, ...], keyword: str, on: bool) -> tuple[str, ...]:
    """The columns of a dump atom after `scale` or `image`."""
    images = ("ix", "iy", "iz")
    if keyword == "scale":
        return tuple({"x": "xs", "y": "ys", "z": "zs"}.get(name, name) if on else name.removesuffix("s") for name in columns)
    return tuple(name for name in columns if name not in images) + (images if on else ())
