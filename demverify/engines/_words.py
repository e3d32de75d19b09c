"""Words of a deck line with their places in the text, so that one word can be exchanged and the rest stays as the user wrote it.

The deck's own lexer yields values; here the text itself is edited, which takes spans instead.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

_CONTINUED = re.compile(r"&[ \t]*\n?\Z")
_TOKEN = re.compile(
    r'"""(?P<triple>.*?)"""|"(?P<double>[^"]*)"|\'(?P<single>[^\']*)\''
    r"|(?P<comment>\#.*\Z)|&[ \t]*(?:\n|\Z)"
    r"|(?P<bare>(?:\$\((?:[^()]|\([^()]*\))*\)|(?!&[ \t]*(?:\n|\Z))[^\s#])+)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Word:
    """One word: its text without quotes, and where that text stands in the line."""

    text: str
    start: int
    end: int
    quoted: bool


@dataclass(frozen=True)
class Edit:
    """Exchange of text[start:end]."""

    start: int
    end: int
    text: str


def logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """(number of its first line, text with its line ends) of each logical line: `&` and open triple quotes go on in the next."""
    held, first = "", 1
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        first = first if held else number
        held += line
        if not _CONTINUED.search(line) and held.count('"""') % 2 == 0:
            yield first, held
            held = ""
    if held:
        yield first, held


def words_of(text: str, offset: int = 0) -> list[Word]:
    """The words of one logical line, comment left out; `offset` is added to their places."""
    found = []
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup
        if kind and kind != "comment":
            start, end = match.span(kind)
            found.append(Word(match[kind], start + offset, end + offset, quoted=kind != "bare"))
    return found


def nested_commands(words: list[Word]) -> Iterator[list[Word]]:
    """The commands that an `if` or a `run ... every` carries as arguments, as words placed in the outer line."""
    texts = [word.text for word in words]
    if texts[:1] == ["if"]:
        carried = _then_words(words)
    elif texts[:1] == ["run"] and "every" in texts:
        carried = words[texts.index("every") + 2 :]
    else:
        carried = []
    for word in carried:
        if inner := words_of(word.text, word.start):
            yield inner


def _then_words(words: list[Word]) -> list[Word]:
    """Arguments of `if` that are commands: all after `then`, but the keywords and the condition after `elif`."""
    texts = [word.text for word in words]
    return [
        word
        for i, word in enumerate(words)
        if "then" in texts[:i] and texts[i] not in ("elif", "else") and texts[i - 1] != "elif"
    ]


def apply(text: str, edits: list[Edit]) -> str:
    """The text with every edit made."""
    for edit in sorted(edits, key=lambda edit: edit.start, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def squeezed(line: str) -> str:
    """A line as the engines echo it, but for blanks: continuations joined, runs of blanks made one."""
    return " ".join(re.sub(r"&[ \t]*\n", " ", line).split())
