"""Words of a text file: what is a number, and how a word is shown in a message."""

from __future__ import annotations


def number(word: bytes) -> float:
    """What a word spells. Raises ValueError where it is no number; digits parted by underscores are none."""
    if b"_" in word:
        message = "digits parted by underscores"
        raise ValueError(message)
    return float(word)


def is_number(word: bytes) -> bool:
    """True where `number` does not raise."""
    try:
        number(word)
    except ValueError:
        return False
    return True


def shown(line: bytes) -> str:
    """The start of a line or word."""
    text = line.decode("utf-8", "backslashreplace").strip()
    return text if len(text) <= 60 else text[:57] + "..."
