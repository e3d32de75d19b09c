"""The spheres of a clump as LIGGGHTS' `fix particletemplate/multisphere ... spheres file NAME scale X` reads them.

One sphere a line, `x y z r`, or `x y z r type` (spheres_different_types). `#` starts a comment, `&` at the end of a line goes on with
the next, empty lines count nothing. Source: LIGGGHTS 3.8.0, input_multisphere.cpp, fix_template_multiplespheres.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from demsolver.shapes.multisphere import Template
from demverify.errors import InputError, Place
from demverify.formats.text import whole_text
from demverify.formats.words import number


def read_template(path: Path, scale: float = 1.0, density: float | None = None, kind: int = 1) -> Template:
    """The template in a file, centres and radii multiplied by `scale`, in the order of the file.

    Raises InputError with file and line for anything but rows of numbers with a radius above zero, and for a file without any.
    """
    if not (scale > 0.0 and math.isfinite(scale)):
        message = f"expected a scale above zero, got {scale:g}"
        raise InputError(message, Place(path))
    rows = [_sphere(words, Place(path, line)) for line, words in _lines(path)]
    if not rows:
        message = "expected one sphere a line (x y z r), got none"
        raise InputError(message, Place(path))
    table = scale * np.array(rows)
    return Template(table[:, :3].copy(), table[:, 3].copy(), density, kind)


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and words of every line that has some; of continued lines the number of the last."""
    text = whole_text(path, "a text file of spheres (x y z r)")
    words: list[str] = []
    for at, line in enumerate(text.splitlines(), 1):
        plain = line.partition("#")[0].rstrip()
        words += plain.removesuffix("&").split()
        if words and not plain.endswith("&"):
            yield at, words
            words = []
    if words:
        yield len(text.splitlines()), words


def _sphere(words: list[str], place: Place) -> list[float]:
    """x y z r."""
    shown = " ".join(words[:8])
    if len(words) not in {4, 5}:
        message = f"expected x y z r, or x y z r type, got {len(words)} words: {shown!r}"
        raise InputError(message, place)
    try:
        values = [number(word.encode()) for word in words]
    except ValueError:
        message = f"expected numbers x y z r, got {shown!r}"
        raise InputError(message, place) from None
    if not all(map(math.isfinite, values)) or values[3] <= 0.0:
        message = f"expected finite numbers x y z r with r above zero, got {shown!r}"
        raise InputError(message, place)
    return values[:4]
