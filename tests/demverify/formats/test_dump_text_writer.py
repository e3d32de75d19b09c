"""Text dumps as written: which format each column gets."""

from __future__ import annotations

import numpy as np
import pytest

from demverify.errors import InputError
from demverify.formats.dump_text_writer import text_frame
from demverify.frames import Frame
from tests.demverify.formats.samples import BOX, NAMES, frame


@pytest.mark.parametrize(
    ("formats", "message"),
    [
        ({"float": "%d"}, "format '%d' of column x is not a printf format with one of %f %F %e %E %g %G"),
        ({"int": "%g"}, "format '%g' of column id"),
        ({"float": "%g %g"}, "'%g %g' of column x"),
        ({"float": "hello"}, "'hello' of column x"),
        ({"float": "%s"}, "'%s' of column x"),
        ({"float": "%*g"}, r"'%\*g' of column x"),
        ({"line": "%d %d %g"}, "has 3 formats for 6 columns"),
        ({"7": "%g"}, "format for column '7', but the columns are 1 to 6: id type"),
    ],
)
def test_wrong_formats_are_refused(formats: dict[str, str], message: str) -> None:
    """Law: a format that does not fit its column is refused, naming both."""
    with pytest.raises(InputError, match=message):
        text_frame(frame(), NAMES, "lammps", formats)


def test_column_format_beats_float_beats_line() -> None:
    """Law: LAMMPS' order of precedence: a column's own format, then int and float, then line, then %d and %g."""
    formats = {"line": "%d %d %.1f %.1f %.1f %.1f", "float": "%.2f", "3": "%.3f", "-1": "%.4f", "y": "%.5f"}
    one = Frame(0, BOX, ("pp", "pp", "pp"), {name: np.array([1.0]) for name in NAMES})
    assert text_frame(one, NAMES, "lammps", formats).endswith(b"\n1 1 1.000 1.00000 1.00 1.0000\n")
