"""Lines and words of a deck."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from demverify.deck.lexer import parse_deck, read_deck, split_words
from demverify.errors import InputError, Place

HERE = Place(Path("in.deck"), 7)
FILE = Path("in.deck")

words = st.text(st.characters(codec="ascii", categories=("L", "N"), include_characters="/_.-*"), min_size=1, max_size=8)
commands = st.lists(words, min_size=1, max_size=6)
quoted = st.text(st.characters(codec="ascii", categories=("L", "N", "Zs"), include_characters="#&<>$"), max_size=10)


def lines(text: str) -> list[tuple[str, int]]:
    """Text and line number of each logical line."""
    return [(line.text, line.place.line) for line in parse_deck(text, FILE)]


@given(commands, st.text(st.characters(exclude_characters="\n\r\0&", codec="utf-8")))
def test_a_comment_changes_nothing(command: list[str], comment: str) -> None:
    """Words before # are the words without it, whatever the comment holds."""
    line = " ".join(command)
    assert [text for text, _ in lines(f"{line} #{comment}")[:1]] == [line]


@given(commands, st.integers(0, 5), st.integers(0, 3))
def test_a_continuation_joins_words(command: list[str], at: int, blanks: int) -> None:
    """A command broken by & after any word has the same words and the place of its first line."""
    at = min(at, len(command))
    broken = " ".join(command[:at]) + " &" + " " * blanks + "\n" + "\t" * blanks + " ".join(command[at:])
    ((text, number),) = lines("\n\n" + broken + "\n")
    assert number == 3
    assert split_words(text, HERE) == tuple(command)


@given(commands, quoted)
def test_quotes_keep_a_word_whole(command: list[str], inside: str) -> None:
    """Blanks, # and & inside any of the three quotes belong to the word."""
    for quote in ("'", '"', '"""'):
        ((text, _),) = lines(f"{' '.join(command)} {quote}{inside}{quote} # end")
        assert split_words(text, HERE) == (*command, inside)


@given(commands, commands)
def test_line_ends_do_not_matter(first: list[str], second: list[str]) -> None:
    """Unix, DOS and old Mac line ends give the same lines, and so does a byte order mark in a file."""
    text = f"{' '.join(first)}\n{' '.join(second)}\n"
    assert lines(text) == lines(text.replace("\n", "\r\n")) == lines(text.replace("\n", "\r"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("print ok &\n# c", [("print ok", 1)]),
        ("# comment &\nprint swallowed", []),
        ("print ab&\ncd", [("print abcd", 1)]),
        ('print """one\ntwo""" # three\nrun 1', [('print """one\ntwo"""', 1), ("run 1", 3)]),
        ("run 1 &", [("run 1", 1)]),
        ("\n # only\n\t\nrun 5", [("run 5", 4)]),
    ],
)
def test_lines(text: str, expected: list[tuple[str, int]]) -> None:
    """Joined and stripped as both engines do it (measured)."""
    assert lines(text) == expected


@pytest.mark.parametrize(
    ("text", "line", "fault"),
    [
        ("run 1\nprint 'a", 2, "unbalanced quotes"),
        ('print "a\nrun 1', 1, "unbalanced quotes"),
        ('print """a\nrun 1', 1, "unbalanced quotes"),
        ("print don't", 1, "unbalanced quotes"),
        ("\nprint 'a'b", 2, "a blank must follow the closing quote"),
        ('print a"b # c" d', 1, "unbalanced quotes"),
    ],
)
def test_wrong_quotes_are_refused(text: str, line: int, fault: str) -> None:
    """A quote without its partner is reported at its line, before anything runs."""
    with pytest.raises(InputError) as caught:
        parse_deck(text, FILE)
    assert str(caught.value).startswith(f"in.deck:{line}: {fault}")


def test_a_comment_may_hold_any_byte(tmp_path: Path) -> None:
    """Engines take any encoding in a comment, and public decks hold Latin-1: it is read as they read it."""
    path = tmp_path / "in.x"
    path.write_bytes(b"# caf\xe9\nunits si\n")
    assert [line.text for line in read_deck(path)] == ["units si"]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"units si\nrun \x001\n", ":2: expected a text file, found a binary one"),
        (b"units si\n\x89PNG\x1a\n", ":2: expected a text file, found a binary one"),
        (b"", ": the deck is empty: it holds no command"),
        (b"# nothing\n\n", ": the deck is empty: it holds no command"),
    ],
)
def test_what_is_no_deck_is_refused(data: bytes, message: str, tmp_path: Path) -> None:
    """A binary file and an empty deck give one line with the file."""
    path = tmp_path / "in.x"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_deck(path)
    assert str(caught.value) == f"{path}{message}"


def test_a_missing_deck_and_a_folder_are_refused(tmp_path: Path) -> None:
    """No file, no traceback."""
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(InputError, match="cannot read the file"):
            read_deck(path)


def test_a_byte_order_mark_is_dropped(tmp_path: Path) -> None:
    """Editors on Windows put it there."""
    path = tmp_path / "in.x"
    path.write_bytes(b"\xef\xbb\xbfunits si\r\n")
    assert [line.text for line in read_deck(path)] == ["units si"]
