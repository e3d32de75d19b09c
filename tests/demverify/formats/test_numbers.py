"""The compiled parser of numbers: what it reads is what float() reads, bit for bit, and what is no number is refused."""

from __future__ import annotations

import io
import math
import struct
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from demverify.errors import InputError
from demverify.formats import text as text_module
from demverify.formats.numbers import _LOWER, _LOWEST, _UPPER
from demverify.formats.rows import Picked
from demverify.formats.text import Text
from demverify.frames import Floats

FORMATS = ("%g", "%.15g", "%.16g", "%.17g", "%.16e", "%e", "%.18e", "%.20g", "%f", "%r", "%20.15g", "%+.3E")
SEPARATORS = (" ", "  ", "\t", " \t ", "\v", "\f", "\r", " " * 40)
any_double = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)
ordinary = st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-12)


def parsed(content: bytes, found: Sequence[str], keep: Sequence[int] | None = None) -> Floats:
    """The rows of a text as a table (kept columns, rows)."""
    at = list(range(len(found)) if keep is None else keep)
    text = Text(Path("d.txt"), io.BufferedReader(io.BytesIO(content)))  # type: ignore[arg-type]
    table = np.empty((len(at), content.count(b"\n")))
    assert text.rows(table, 0, found, Picked(at, [found[i] for i in at], None)) == table.shape[1]
    return table


def column(words: Sequence[bytes]) -> Floats:
    """One word a row."""
    return parsed(b"".join(word + b"\n" for word in words), ["x"])[0]


def bits(values: Floats | list[float]) -> list[str]:
    """To compare with: zeros with their sign, any NaN with its own."""
    return [struct.pack(">d", value).hex() for value in values]


def assert_as_python(words: Sequence[bytes]) -> None:
    """Each word gives what float() gives."""
    assert bits(column(words)) == bits([float(word) for word in words])


@given(st.lists(st.tuples(any_double | ordinary, st.sampled_from(FORMATS)), max_size=40))
@settings(max_examples=150, deadline=None)
def test_what_is_printed_is_read_as_float_reads_it(values: list[tuple[float, str]]) -> None:
    """Law: any double in any format that a dump may have, NaN, infinities, subnormals and 20 digits included."""
    assert_as_python([(fmt % value).strip().encode() for value, fmt in values])


@given(st.lists(st.from_regex(r"[+-]?([0-9]{1,25}\.?[0-9]{0,25}|\.[0-9]{1,30})([eE][+-]?[0-9]{1,4})?", fullmatch=True), max_size=40))
@example(["1E5", "+1", ".5", "5.", "-0", "-0.0", "0e999", "-.0E-999", "007", "1e+0000005", "1e000000005", "1e-000000012"])
@example(["nan", "-nan", "+NaN", "inf", "-Inf", "+INF", "infinity", "-Infinity"])
@example(["1e400", "-1e400", "1e-400", "4.9e-324", "2.4703282292062328e-324", "2.2250738585072011e-308", "1.7976931348623159e308"])
@example(["0." + "0" * 20 + "1234567890123456789", "12345678901234567890123", "9999999999999999999", "18446744073709551616"])
@settings(max_examples=150, deadline=None)
def test_odd_spellings_are_read_as_float_reads_them(words: list[str]) -> None:
    """Law: signs, points and exponents anywhere that float() takes them, digits by the dozen, exponents beyond all doubles."""
    words = [word for word in words if is_number(word)]
    assert_as_python([word.encode() for word in words])


def is_number(word: str) -> bool:
    """Whether float() takes a word; digits parted by underscores are none here."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


@given(st.integers(2**52, 2**53 - 1), st.integers(0, 12), st.sampled_from((-1, 0, 1)))
@settings(max_examples=300, deadline=None)
def test_halfway_cases_go_to_the_even_double(mantissa: int, twos: int, off: int) -> None:
    """Law: what lies exactly between two doubles, or one unit of its last digit beside it, is rounded as float() rounds it."""
    between = 2 * mantissa + 1  # 54 bits, the last one set; so it stays when halved or doubled
    assert_as_python([f"{between * 2**twos + off}".encode(), f"-{between * 5**twos + off}e-{twos}".encode()])


@given(st.integers(0, 23), st.integers(0, 62), st.data())
@settings(max_examples=300, deadline=None)
def test_halfway_cases_with_a_power_of_ten(power: int, twos: int, data: st.DataObject) -> None:
    """Law: w 10^q with w 5^q of 54 bits and odd, or 2^k times that, lies between two doubles; the compiled product must see that."""
    low, high = -(-(2**53) // 5**power), (2**54 - 1) // 5**power
    w = (data.draw(st.integers(low, high)) | 1) << twos
    assert_as_python([f"{word}e{power}".encode() for word in (w - 1, w, w + 1, f"{w}.0")])


def test_every_power_of_ten() -> None:
    """Law: from below the smallest to above the largest double, significands of every length, zero and those around 2^53 and 2^64."""
    whole = [0, 1, 3, 123456, 99999999, 2**53 - 1, 2**53, 2**53 + 1, 10**17 + 1, 10**19 - 1, 2**63, 2**64 - 1, 2**64, 2**64 + 1, 10**22]
    assert_as_python([f"{w}e{q}".encode() for q in range(-370, 330) for w in whole])


def test_every_length_of_a_fraction() -> None:
    """Law: zeros and then digits behind the point, of any number, with any number of digits before it; so are leading zeros."""
    digits = "7315926480" * 3
    assert_as_python(
        [f"{digits[:n]}.{'0' * zeros}{digits[n : n + m]}".encode() for n in range(12) for zeros in range(12) for m in range(n == 0, 24)]
    )
    assert_as_python([f"{'0' * zeros}{digits[:n]}.{digits[:m]}".encode() for zeros in range(24) for n in range(1, 22) for m in (0, 3, 12)])


@given(any_double.filter(math.isfinite), st.integers(15, 25))
@settings(max_examples=150, deadline=None)
def test_the_middle_between_two_doubles_cut_short(value: float, digits: int) -> None:
    """Law: the first 15 to 25 digits of the exact middle of two doubles, and their neighbours, are rounded as float() rounds them."""
    following = math.nextafter(value, math.inf)
    assume(math.isfinite(following))
    middle = (Decimal(value) + Decimal(following)) / 2
    word = f"{middle:.{digits - 1}e}"
    mantissa, exponent = word.split("e")
    near = [f"{Decimal(mantissa) + step * Decimal(10) ** (1 - digits)}e{exponent}" for step in (-1, 0, 1)]
    assert_as_python([one.encode() for one in near])


def test_powers_of_ten_are_the_nearest_below_or_above() -> None:
    """Law: the table holds 10^q 2^-k with 128 bits, the highest set: cut off for q >= 0, the next above for q < 0."""
    for i, (upper, lower) in enumerate(zip(_UPPER.tolist(), _LOWER.tolist(), strict=True)):
        bits_, power = upper << 64 | lower, Fraction(10) ** (i + _LOWEST)
        scale = Fraction(2) ** (power.numerator.bit_length() - power.denominator.bit_length() - 128)
        while power / scale >= 2**128:
            scale *= 2
        while power / scale < 2**127:
            scale /= 2
        exact = power / scale
        assert (bits_ == int(exact)) if i + _LOWEST >= 0 else (bits_ - 1 == int(exact) or bits_ == exact)


NO_NUMBERS = """\
nanx in na nann nan. -na --nan infi inf1 infinit n i
- + . -. e e5 .e5 1e 1e+ 1e- 1.5e 0e -0e+ 0e- --1 +-1 1- 1..2 1.2.3 1e5e5 1e5.0 0.0e0e 0x10 1_0 1e5_0 1,5 1d5 1f **** id 1:2 / 1/2 9: 1e:
1234567: 12345678a 1234567890123456a 0.12345678901234567x 1.2345678901234567e+x ٣ 1\x00 \x001 0\x7f
"""


@pytest.mark.parametrize("word", ["", *NO_NUMBERS.split(), "1\x0e", "\x081", "1\x1c", "1\x1f2", "\x85", "x" * 50, "1" * 50 + "x"])
def test_what_is_no_number_is_refused(word: str) -> None:
    """Law: a word that float() does not take is named with its line and column; none becomes a number."""
    with pytest.raises(InputError, match=r"^d\.txt:2: (column b expects a number|expected 3 columns)"):
        parsed(b"1 2 3\n4 " + word.encode() + b" 6\n7 8 9\n", ["a", "b", "c"])


@given(st.lists(st.text("0123456789.+-eEnaifx_\x01\x7f", min_size=1, max_size=12), min_size=1, max_size=12))
@settings(max_examples=400, deadline=None)
def test_a_word_is_read_or_refused_as_python_does(words: list[str]) -> None:
    """Law: rows are taken if and only if float() takes every word of them, and then with its bits."""
    if all(map(is_number, words)):
        assert_as_python([word.encode() for word in words])
    else:
        wrong = next(i for i, word in enumerate(words) if not is_number(word))
        with pytest.raises(InputError, match=rf"d\.txt:{wrong + 1}: column x expects a number"):
            column([word.encode() for word in words])


@given(st.data(), st.integers(1, 5))
@settings(max_examples=150, deadline=None)
def test_rows_are_parted_as_python_parts_them(data: st.DataObject, columns: int) -> None:
    """Law: words stand where line.split() finds them, whatever the blanks; a row with another number of them is refused by its line."""
    numbers = st.sampled_from(["1", "-2.5", "1e-5", "0.1234567890123456789", "nan", "7" * 35])
    blank = st.sampled_from(("", *SEPARATORS))
    lines = []
    for _ in range(data.draw(st.integers(1, 8))):
        count = data.draw(st.sampled_from((columns, columns, columns, columns, columns - 1, columns + 1)))
        words = [data.draw(numbers) + data.draw(st.sampled_from(SEPARATORS)) for _ in range(count)]
        lines.append((data.draw(blank) + "".join(words)[: None if data.draw(st.booleans()) else -1]).encode())
    names = [f"c{i}" for i in range(columns)]
    rows = [line.split() for line in lines]
    content = b"".join(line + b"\n" for line in lines)
    if all(len(row) == columns for row in rows):
        assert bits(parsed(content, names).T.ravel()) == bits([float(word) for row in rows for word in row])
    else:
        wrong = next(i for i, row in enumerate(rows) if len(row) != columns)
        with pytest.raises(InputError, match=rf"d\.txt:{wrong + 1}: expected {columns} columns .* got {len(rows[wrong])}"):
            parsed(content, names)


def test_columns_that_are_not_wanted_are_not_looked_at() -> None:
    """Law: words of any length in columns that are passed over do no harm; their number still counts."""
    content = b"1 Cu 2.5 " + b"x" * 100 + b"\n2 **** -3 y\n"
    np.testing.assert_array_equal(parsed(content, ["id", "element", "x", "label"], [0, 2]), [[1, 2], [2.5, -3]])
    with pytest.raises(InputError, match="expected 3 columns"):
        parsed(content, ["id", "element", "x"], [0, 2])


class Trickle(io.BytesIO):
    """A stream that gives a few bytes at a time."""

    def readinto1(self, target: memoryview) -> int:  # type: ignore[override]
        return self.readinto(target[:7])


@given(st.lists(ordinary, min_size=1, max_size=60), st.integers(70, 200))
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_pieces_of_any_size_make_the_same_numbers(monkeypatch: pytest.MonkeyPatch, values: list[float], room: int) -> None:
    """Law: it does not matter where the bytes that are held end, nor how many come at a time; lines are counted right through."""
    monkeypatch.setattr(text_module, "_ROOM", room)
    content = b"# one line\n" + b"".join(b"%.17g %g \n" % (value, value) for value in values) + b"end"
    for stream in (io.BufferedReader(io.BytesIO(content)), Trickle(content)):  # type: ignore[arg-type]
        text = Text(Path("d.txt"), stream)  # type: ignore[arg-type]
        assert text.line() == b"# one line\n"
        table = np.empty((2, len(values) + 5))
        assert text.rows(table, 0, ["a", "b"], Picked([0, 1], ["a", "b"], None)) == len(values)
        assert bits(table[0, : len(values)]) == bits(values)
        assert text.place().line == len(values) + 1
        assert text.position == len(content) - 3
        assert (text.line(), text.line()) == (b"end", b"")


def test_a_line_without_end_is_refused() -> None:
    """Law: a file whose lines are longer than any row can be is refused, not held in memory as a whole."""
    with pytest.raises(InputError, match=r"d\.txt:2: a line of more than 1048576 bytes"):
        parsed(b"1 2\n" + b"3 " * 2**20 + b"\n", ["a", "b"])


def test_many_odd_words_are_all_decided() -> None:
    """Law: more words than are noted at a time, left to Python each, all come out right, those of other columns too."""
    words = [b"infinity", b"0.12345678901234567890123", b"-1e-320", b"1" * 40] * 1000
    table = parsed(b"".join(b"%d %s %s\n" % (i, word, word) for i, word in enumerate(words)), ["a", "b", "c"])
    np.testing.assert_array_equal(table[0], np.arange(len(words)))
    assert bits(table[1]) == bits(table[2]) == bits([float(word) for word in words])
