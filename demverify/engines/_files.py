"""Which words of a command name a file to read, and which a file to write. LAMMPS and LIGGGHTS alike."""

from __future__ import annotations

from itertools import pairwise

_READ_FIRST = {"read_data", "read_restart", "read_dump", "include", "jump"}
_READ_ANYWHERE = {"molecule", "rerun", "region", "create_atoms", "pair_style", "pair_coeff"}
_READING_FIXES = ("mesh/", "particletemplate/", "rigid", "move", "property/", "tmd", "adapt")
_WRITE_AT = {"log": 1, "write_restart": 1, "write_data": 1, "write_coeff": 1, "write_dump": 3, "dump": 5}
_FILE_KEYWORDS = {"file", "append", "overwrite"}
_SHELL_PATHS = {"cd", "mkdir", "mv", "rm", "rmdir"}


def read_at(words: list[str]) -> list[int]:
    """Indices of the words that may name a file to read.

    Where any argument may be a file, only words with a dot or a slash count: an id is not a file for bearing the name of one.
    """
    command = words[0]
    if command in _READ_FIRST:
        return [1] if len(words) > 1 and words[1] != "SELF" else []
    if command in _READ_ANYWHERE or _is_reading_fix(words) or _is_file_variable(words):
        return [i for i, word in enumerate(words) if i > 1 and ("." in word or "/" in word)]
    return []


def must_exist(words: list[str]) -> bool:
    """Whether the command is lost without the file it names first."""
    return words[0] in _READ_FIRST


def written(words: list[str]) -> list[str]:
    """The paths that a command writes to."""
    command = words[0]
    if command in _WRITE_AT:
        return words[_WRITE_AT[command] : _WRITE_AT[command] + 1]
    if command == "restart":
        return words[2:4]
    if command == "shell" and words[1:2] and words[1] in _SHELL_PATHS:
        return words[2:]
    if command in ("print", "info") or (command == "fix" and not _is_reading_fix(words)):
        return [path for keyword, path in pairwise(words) if keyword in _FILE_KEYWORDS]
    return []


def _is_reading_fix(words: list[str]) -> bool:
    return words[0] == "fix" and len(words) > 3 and words[3].startswith(_READING_FIXES)


def _is_file_variable(words: list[str]) -> bool:
    return words[0] == "variable" and len(words) > 2 and words[2] in ("file", "atomfile")
