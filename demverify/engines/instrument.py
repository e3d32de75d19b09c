"""A copy of the user's deck for one engine and one run folder.

The deck itself is never changed. In the copy
- files to read are found wherever the run folder lies: each gets an entry in `in.<engine>.files/` (a link; included decks as
  copies made by the same rules; `.gz` files unpacked, for Debian's LIGGGHTS reads none), and the word that names it points there;
- files to write stay in the run folder, whose sub-folders are made; a path that leaves it is an InputError;
- `echo` always goes to the screen, where a log that the deck renames cannot take it away;
- a dump of all particles, `demverify_all`, starts before the first run. It stands behind a flag, so that a loop passes over it;
  before `clear` and `reset_timestep`, which a dump does not survive in LAMMPS, it is closed and the next run opens another.
Lines keep their order, and `Prepared.places` leads from a line of the copy back to the user's.
"""

from __future__ import annotations

import glob
import gzip
import re
import shutil
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path, PurePosixPath

from demverify.engines import _files
from demverify.engines._words import Edit, Word, apply, logical_lines, nested_commands, squeezed, words_of
from demverify.errors import InputError, Place

# Binary dumps hold float64 in both engines; LIGGGHTS writes no column names, so they are told here.
COLUMNS = (
    *("id", "type", "x", "y", "z", "ix", "iy", "iz", "vx", "vy", "vz", "fx", "fy", "fz"),
    *("omegax", "omegay", "omegaz", "tqx", "tqy", "tqz", "radius", "mass"),
)
SHAPES = (
    *("shapex", "shapey", "shapez", "blockiness1", "blockiness2", "quat1", "quat2", "quat3", "quat4"),
    *("angmomx", "angmomy", "angmomz", "inertiax", "inertiay", "inertiaz"),
)
"""Of superquadrics, behind the others."""
SUPERQUADRICS = re.compile(r"^\s*atom_style\s+superquadric\b", re.MULTILINE)
DUMP_ID = "demverify_all"
SEGMENT = "demverify_trajectory.{}.bin"

_VARIABLE = re.compile(r"\$\{(?P<name>\w+)\}|\$(?P<letter>\w)|\$\((?:[^()]|\([^()]*\))*\)")
_RUNS = {"run", "minimize", "rerun"}
_BREAKS = {"clear", "reset_timestep"}
_WRITES = {"write_data", "write_restart", "restart", "shell", "python"}
_LOOPS = {"jump", "next", "if"}
_START = "variable demverify_on equal 0\nvariable demverify_pass equal 0\n"
_STOP = (
    f'if "${{demverify_on}} == 1" then "undump {DUMP_ID}" "variable demverify_on equal 0"'
    ' "variable demverify_pass equal ${demverify_pass}+1"\n'
)


@dataclass(frozen=True)
class Prepared:
    """The copy of a deck.

    total: steps of all its runs, None when a loop or a variable hides it. places: squeezed line of the copy -> where the user
    wrote it, every occurrence. columns: of the dump of all particles.
    """

    deck: Path
    total: int | None
    places: dict[str, list[Place]]
    columns: tuple[str, ...]


def prepare(deck: Path, folder: Path, engine: str, variables: dict[str, list[str]], every: int | None) -> Prepared:
    """Write `folder/in.<engine>` and what it reads.

    Raises InputError: no such deck, not text, no command, a file that is not there, a path outside the folder, a folder that is
    the deck's own, frames every less than one step.
    """
    deck, folder = deck.resolve(), folder.resolve()
    text = _read(deck)
    if folder == deck.parent:
        raise InputError(f"the run folder {folder} is the deck's own; name another, for the run writes into it", Place(deck))
    if every is not None and every < 1:
        raise InputError(f"frames every {every} steps; expected a whole number of 1 or more", Place(deck))
    folder.mkdir(parents=True, exist_ok=True)
    columns = COLUMNS + SHAPES if SUPERQUADRICS.search(text) else COLUMNS
    copy = _Copy(deck, folder, f"in.{engine}", every, columns, {name: list(values) for name, values in variables.items()})
    body = copy.rewritten(text, deck)
    if not copy.places:
        raise InputError("no command in this deck", Place(deck))
    target = folder / copy.name
    target.write_text((_START if every else "") + body, encoding="utf-8", errors="surrogateescape")
    return Prepared(target, copy.total, copy.places, columns)


def join_segments(folder: Path) -> Path | None:
    """One trajectory of the segments that the run left; None when it left none."""
    segments = sorted(folder.glob(SEGMENT.format("*")), key=lambda path: int(path.name.split(".")[1]))
    if not segments:
        return None
    whole = folder / "demverify_trajectory.bin"
    segments[0].replace(whole)
    with whole.open("ab") as out:
        for segment in segments[1:]:
            with segment.open("rb") as part:
                shutil.copyfileobj(part, out)
            segment.unlink()
    return whole


def clear_trajectory(folder: Path) -> None:
    """Remove what an earlier run in this folder left."""
    for old in (*folder.glob(SEGMENT.format("*")), folder / "demverify_trajectory.bin"):
        old.unlink(missing_ok=True)


def _read(deck: Path) -> str:
    if not deck.is_file():
        raise InputError("no such deck", Place(deck))
    data = deck.read_bytes()
    if b"\0" in data:
        raise InputError("a binary file; expected a deck, which is text", Place(deck))
    return data.decode("utf-8", errors="surrogateescape").replace("\r\n", "\n")


@dataclass
class _Copy:
    """The copying of one deck and all it includes."""

    deck: Path
    folder: Path
    name: str
    every: int | None
    columns: tuple[str, ...]
    known: dict[str, list[str]]  # values that an index or string variable can take
    total: int | None = 0
    writes: bool = False  # whether a command so far may have made a file that a later one reads
    restarts: set[str] = field(default_factory=set)  # names of restart files that a command so far writes
    places: dict[str, list[Place]] = field(default_factory=dict)
    copied: set[Path] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.fixed = set(self.known)  # the command line wins over the deck's own index variables
        self.copied.add(self.deck)

    def rewritten(self, text: str, source: Path) -> str:
        """The text of one deck file with every line rewritten, and the instrumentation put in."""
        return "".join(self._line(line, Place(source, number)) for number, line in logical_lines(text))

    def _line(self, line: str, place: Place) -> str:
        words = words_of(line)
        if not words:
            return line
        commands = [words, *nested_commands(words)]
        edits = []
        for command in commands:
            edits += self._edits(command, place)
            self._learn([word.text for word in command])
        new = apply(line, edits)
        self.places.setdefault(squeezed(new), []).append(place)
        guard = self._guard({command[0].text for command in commands})
        if guard:
            self.places.setdefault(squeezed(guard), []).append(place)
        return guard + new

    def _guard(self, commands: set[str]) -> str:
        if self.every is None:
            return ""
        if commands & _RUNS:
            dump = f"dump {DUMP_ID} all custom {self.every} {SEGMENT.format('${demverify_pass}')} {' '.join(self.columns)}"
            return f'if "${{demverify_on}} == 0" then "{dump}" "dump_modify {DUMP_ID} sort id" "variable demverify_on equal 1"\n'
        return _STOP if commands & _BREAKS else ""

    def _edits(self, words: list[Word], place: Place) -> list[Edit]:
        texts = [word.text for word in words]
        for path in _files.written(texts):
            self._make_folder(path, texts[0], place)
        if texts[0] == "echo" and len(words) > 1:
            return [Edit(words[1].start, words[1].end, "both")]
        found = [(words[i], self._reading(texts, i, place)) for i in _files.read_at(texts)]
        return [Edit(word.start, word.end, new) for word, new in found if new is not None]

    def _learn(self, words: list[str]) -> None:
        """What this command tells of variables, of files it makes and of steps."""
        if words[0] == "variable" and len(words) > 3 and words[1] not in self.fixed:
            self.known.pop(words[1], None)
            if words[2] in ("index", "string") or (words[2] == "equal" and words[3].isdigit()):
                self.known[words[1]] = [value for word in words[3:] for value in self._values(word)]
        self.writes |= words[0] in _WRITES
        if words[0] == "write_restart" and len(words) > 1:
            self.restarts.update(self._values(words[1]))
        if words[0] in _LOOPS:
            self.total = None
        elif words[0] == "run" and self.total is not None:
            steps = self._values(words[1]) if len(words) > 1 else []
            plain = len(steps) == 1 and steps[0].isdecimal() and "upto" not in words
            self.total = self.total + int(steps[0]) if plain else None

    def _values(self, word: str) -> list[str]:
        """What the word can stand for; a variable of unknown value stays as `*`."""
        names = sorted({_name(match) for match in _VARIABLE.finditer(word)})
        choices = product(*(self.known.get(name, ["*"]) for name in names))
        return [_put_in(word, dict(zip(names, choice, strict=True))) for choice in choices]

    def _make_folder(self, word: str, command: str, place: Place) -> None:
        """Make the sub-folder that an output needs. Raises InputError for one that leaves the run folder."""
        for path in (PurePosixPath(value) for value in self._values(word)):
            if path == PurePosixPath("/dev/null"):
                continue
            if path.is_absolute() or _climbs(path):
                message = f"{command} writes to {str(path)!r}, outside the run folder; expected a relative path inside it"
                raise InputError(message, place)
            if "*" not in str(path.parent):
                (self.folder / path.parent).mkdir(parents=True, exist_ok=True)

    def _reading(self, words: list[str], i: int, place: Place) -> str | None:
        """What to write instead of words[i], which may name a file to read; None: leave it."""
        values = self._values(words[i])
        if words[0] == "jump" and values == [self.deck.name]:
            return self.name
        if words[0] == "read_restart" and values and all(self._is_made(value) for value in values):
            return None  # the run's own file, also where one of this name lies beside the deck
        files = {rel: path for value in values for rel, path in self._matches(value)}
        if not files:
            self._complain(words, values, place)
            return None
        for rel, path in files.items():
            self._provide(rel, path, is_deck=words[0] in ("include", "jump"))
        return self._entry(values[0] if len(values) == 1 and "*" not in values[0] else words[i])

    def _is_made(self, value: str) -> bool:
        """Whether a restart file of this name has been written by then; in either name a `*` is any step."""
        return any(fnmatchcase(value, name) or fnmatchcase(name, value) for name in self.restarts)

    def _matches(self, value: str) -> list[tuple[str, Path]]:
        """(path as the deck writes it, file) of every file beside the deck that fits; `x` finds `x.gz` where there is no `x`."""
        root = self.deck.parent
        if value.strip("*%") == "":
            return []
        if "*" in value or "%" in value:
            return [(rel, root / rel) for rel in glob.glob(value.replace("%", "*"), root_dir=root) if (root / rel).is_file()]
        file = next((file for file in (root / value, root / f"{value}.gz") if file.is_file()), None)
        return [(value, file)] if file else []

    def _complain(self, words: list[str], values: list[str], place: Place) -> None:
        unknown = any("*" in value or "%" in value or "$" in value for value in values)
        if _files.must_exist(words) and not unknown and not self.writes:
            raise InputError(f"{words[0]}: no file {values[0]!r} in {self.deck.parent}, the folder of the deck", place)

    def _entry(self, rel: str) -> str:
        """Name under which a file is given to the engine: short, without blanks, inside the run folder."""
        return f"{self.name}.files/" + rel.removesuffix(".gz").replace("../", "up/").lstrip("/").replace(" ", "_")

    def _provide(self, rel: str, path: Path, *, is_deck: bool) -> None:
        entry = self.folder / self._entry(rel)
        if is_deck and path in self.copied:
            self.total = None  # its runs come again
            return
        entry.parent.mkdir(parents=True, exist_ok=True)
        entry.unlink(missing_ok=True)
        if is_deck:
            self.copied.add(path)
            entry.write_text(self.rewritten(_read(path), path), encoding="utf-8", errors="surrogateescape")
        elif path.suffix == ".gz":
            with gzip.open(path, "rb") as packed, entry.open("wb") as out:
                shutil.copyfileobj(packed, out)
        else:
            entry.symlink_to(path.resolve())


def _name(variable: re.Match[str]) -> str:
    """Name of a variable as met in a word; the text itself of an immediate `$(...)`, which no variable is called."""
    return variable["name"] or variable["letter"] or variable[0]


def _put_in(word: str, values: dict[str, str]) -> str:
    return _VARIABLE.sub(lambda match: values[_name(match)], word)


def _climbs(path: PurePosixPath) -> bool:
    """Whether the path leads out of the folder it starts from."""
    depth = 0
    for part in path.parts:
        depth += -1 if part == ".." else 1
        if depth < 0:
            return True
    return False
