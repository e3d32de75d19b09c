"""Which decks of a source tree this project runs: every granular deck under the given folders is read and checked whole, nothing runs.

    python benchmarks/public_decks.py FOLDER...

One line a deck: `runs`, with particles and steps, or the first line of it that is refused and why. Decks of equal text count once.
Then how many decks each refused command or style stops. Decks that need a variable from outside (-var) say so.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from demverify.errors import InputError
from demverify.runs import plan

_NAMED = ("in.*", "in_*", "*.in", "*.lmp", "*.lammps", "*.liggghts", "*.bonds")
_GRANULAR = re.compile(
    rb"^[ \t]*(pair_style\s+(gran|hybrid\S*\s.*\bgran)|fix\s+\S+\s+\S+\s+(wall/gran|nve/sphere)|atom_style\s+(hybrid\s.*)?(granular|sphere)\b)",
    re.MULTILINE,
)


def granular_decks(folders: Iterable[Path]) -> Iterator[Path]:
    """The granular decks under folders, sorted, each text once."""
    seen: set[bytes] = set()
    for path in sorted({path for folder in folders for name in _NAMED for path in folder.rglob(name) if path.is_file()}):
        text = path.read_bytes()
        key = b"\n".join(b" ".join(line.split()) for line in text.splitlines())
        if b"\0" not in text and _GRANULAR.search(text) and key not in seen:
            seen.add(key)
            yield path


def judge(deck: Path) -> tuple[bool, str]:
    """(whether it runs here, its size or the line that is refused)."""
    try:
        known = plan(deck, {})
    except InputError as error:
        return False, brief(str(error).replace(f"{deck}", deck.name))
    if not known.runs:
        return False, "no run command: a part of another deck"
    more = "" if known.whole else " and more that depend on its own results"
    return True, f"{known.dialect}: {known.particles} particles, {known.steps} steps{more}"


def brief(message: str) -> str:
    """The message up to the list of what is supported."""
    return re.split(r"; supported|; defined| is not one of| \(looked for", message.splitlines()[0])[0]


def cause(reason: str) -> str:
    """What a refusal is about, for the count: without file and line."""
    return re.sub(r"^\S+:\d+: ", "", reason)


def main(folders: list[str]) -> None:
    """Prints the survey."""
    found = [(deck, *judge(deck)) for deck in granular_decks(Path(folder) for folder in folders)]
    for deck, runs, reason in found:
        print(f"{'runs   ' if runs else 'refused'}  {deck}  {reason}")
    print(f"\n{sum(runs for _, runs, _ in found)} of {len(found)} decks run")
    for what, count in Counter(cause(reason) for _, runs, reason in found if not runs).most_common():
        print(f"{count:5d}  {what}")


if __name__ == "__main__":
    main(sys.argv[1:])
