"""From the text of a deck to logical lines and words.

Rules of LAMMPS and LIGGGHTS, measured: a line whose last visible character is `&` goes on in the next one (inside a comment too);
`#` outside quotes starts a comment; quotes are '...', "..." and triple double quotes, the last over several lines; a blank must
follow a closing quote.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from demverify.errors import InputError, Place

_MARK = re.compile(r'"""|"|\'|#')
_WORD = re.compile(r'"""(?P<triple>.*?)"""|"(?P<double>[^"]*)"|\'(?P<single>[^\']*)\'|(?P<bare>[^\s"\']\S*)', re.DOTALL)
_BLANK = re.compile(r"\s*")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f\x7f]")  # control characters that no text holds


@dataclass(frozen=True)
class Line:
    """One command as written, without its comment, and the place of its first physical line."""

    text: str
    place: Place


def read_deck(path: Path) -> list[Line]:
    """The logical lines of a deck; blank and comment lines are left out.

    Raises InputError for a file that is missing, binary, not UTF-8 or without any command, and for unbalanced quotes.
    """
    lines = parse_deck(read_text(path), path)
    if not lines:
        raise InputError("the deck is empty: it holds no command", Place(path))
    return lines


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, without byte order mark. Raises InputError when there is none."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", Place(path)) from None
    return decode(data, path)


def decode(data: bytes, path: Path) -> str:
    """Bytes as text: UTF-8, a byte order mark dropped, else Latin-1, as the engines take any byte in a comment (public decks hold
    such). Raises InputError for binary data."""
    if found := _BINARY.search(data):
        raise InputError("expected a text file, found a binary one", Place(path, data[: found.start()].count(b"\n") + 1))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_deck(text: str, file: Path) -> list[Line]:
    """Logical lines of a text; `file` names it in places. Raises InputError for unbalanced quotes."""
    physical = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines: list[Line] = []
    at = 0
    while at < len(physical):
        place = Place(file, at + 1)
        joined, at = _join(physical, at)
        clean, quote = _scan(joined)
        if quote:
            raise InputError(f"unbalanced quotes: {quote} has no partner", place)
        if clean.strip():
            split_words(clean, place)  # a wrong quote is reported now, before anything has run
            lines.append(Line(clean.strip(), place))
    return lines


def split_words(text: str, place: Place) -> tuple[str, ...]:
    """Words of a command, quotes taken off. Raises InputError for unbalanced quotes."""
    words = []
    at = _blanks(text, 0)
    while at < len(text):
        found = _WORD.match(text, at)
        if found is None:
            raise InputError(f"unbalanced quotes: {text[at]} has no partner", place)
        word = found[found.lastgroup or 0]
        if found.lastgroup == "bare" and _scan(word.replace("#", " "))[1]:
            raise InputError(f"unbalanced quotes in {word!r}", place)
        at = found.end()
        if at < len(text) and not text[at].isspace():
            raise InputError(f"a blank must follow the closing quote of {found[0]!r}", place)
        words.append(word)
        at = _blanks(text, at)
    return tuple(words)


def _join(physical: list[str], at: int) -> tuple[str, int]:
    """The logical line that starts at index `at`, and the index after it."""
    joined = physical[at]
    at += 1
    while at < len(physical):
        bare = joined.rstrip()
        if bare.endswith("&"):
            joined = bare[:-1] + physical[at]
        elif _scan(joined)[1] == '"""':
            joined = f"{joined}\n{physical[at]}"
        else:
            return joined, at
        at += 1
    bare = joined.rstrip()
    return (bare[:-1] if bare.endswith("&") else joined), at


def _scan(text: str) -> tuple[str, str]:
    """The text without its comment, and the quote that is still open at its end."""
    at, quote = 0, ""
    while found := _MARK.search(text, at):
        mark, at = found[0], found.end()
        if quote:
            start = text.find(quote, found.start())
            if start < 0:
                return text, quote
            at, quote = start + len(quote), ""
        elif mark == "#":
            return text[: found.start()], ""
        else:
            quote = mark
    return text, quote


def _blanks(text: str, at: int) -> int:
    found = _BLANK.match(text, at)
    return found.end() if found else at
