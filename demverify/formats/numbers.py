"""Rows of numbers as text, to float64 columns: compiled, without the interpreter's lock, bit for bit what Python's float() gives.

One comparison of 32 bytes finds where a word ends; eight digits become a number in three multiplications. A significand below 2^53
with a power of ten up to 22 takes one exact division (W. D. Clinger, PLDI 1990, doi:10.1145/93542.93557). Up to 19 digits are rounded
by a product of 64 with 128 bits (D. Lemire, Softw. Pract. Exp. 51 (2021) 1700, doi:10.1002/spe.2984), which is enough for each of them
(N. Mushtak, D. Lemire, Softw. Pract. Exp. 53 (2023) 1467, doi:10.1002/spe.3198). Other words are left to the caller.

All that is compiled stands in this file, so that Numba's cache cannot serve old code. Little-endian machines alone.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call, call-arg, var-annotated"
# ruff: noqa: ANN001, ANN201, ANN202 (Numba finds the types of what it compiles)

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

PADDING = 64
"""Bytes that must follow the last row in its array: words are looked at 32 bytes at a time."""
DONE, ODD_ROW, FULL = range(3)
"""What stopped `parse_rows`: nothing left to do; a row with another number of words; no room to note more odd words."""

_U = np.uint64
_LOWEST, _HIGHEST = -342, 308  # powers of ten that 19 digits can have in a double
_ZEROS = _U(0x3030303030303030)
_TOPS = _U(0x8080808080808080)
_ABOVE_NINE = _U(0x7676767676767676)  # added to a byte, sets its top bit when the byte is above 9
_TOP = _U(1 << 63)
_NONE = _U(2**64 - 1)  # no number of 19 digits
_NO_POWER = 1 << 40
_NAN, _INF = (_U(int.from_bytes(word, "little")) for word in (b"nan", b"inf"))


def _powers_of_ten() -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """Upper and lower 64 bits of 10^q 2^-k with 2^127 <= 10^q 2^-k < 2^128: cut off for q >= 0, rounded up for q < 0."""
    upper, lower = [], []
    for q in range(_LOWEST, _HIGHEST + 1):
        five = 5 ** abs(q)
        bits = (five << 128) >> five.bit_length() if q >= 0 else (1 << (five.bit_length() + 127)) // five + 1
        upper.append(bits >> 64)
        lower.append(bits & (2**64 - 1))
    return np.array(upper, np.uint64), np.array(lower, np.uint64)


_UPPER, _LOWER = _powers_of_ten()
_EXACT = np.array([float(10**i) for i in range(23)])  # the powers of ten that are doubles
_WHOLE = np.array([10**i for i in range(9)], np.uint64)

_inlined = njit(error_model="numpy", forceinline=True)


def _load(builder: Any, address: Any, kind: Any) -> Any:
    """What stands at an address, of an LLVM type. Addresses, not arrays: Numba would count those in and out at every word."""
    return builder.load(builder.inttoptr(address, kind.as_pointer()), align=1)


@intrinsic
def _byte(typing: Any, at: Any) -> Any:
    """The byte at an address."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(builder, args[0], ir.IntType(8))

    return types.uint8(types.uint64), generate


@intrinsic
def _eight_bytes(typing: Any, at: Any) -> Any:
    """Eight bytes at an address as a little-endian number."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _load(builder, args[0], ir.IntType(64))

    return types.uint64(types.uint64), generate


@intrinsic
def _marks(typing: Any, at: Any) -> Any:
    """Four masks of 32 bytes at an address, bit i for byte i: blanks (as bytes.split() has them), e or E, points, newlines."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.VectorType(ir.IntType(8), 32)
        found = _load(builder, args[0], vector)

        def same(letters: Any, sign: str, byte: int) -> Any:
            return builder.icmp_unsigned(sign, letters, ir.Constant(vector, [byte] * 32))

        from_tab = builder.sub(found, ir.Constant(vector, [ord("\t")] * 32))  # \t \n \v \f \r follow each other
        lower = builder.or_(found, ir.Constant(vector, [ord("e") ^ ord("E")] * 32))
        blank = builder.or_(same(found, "==", ord(" ")), same(from_tab, "<=", ord("\r") - ord("\t")))
        masks = [blank, same(lower, "==", ord("e")), same(found, "==", ord(".")), same(found, "==", ord("\n"))]
        wide = [builder.zext(builder.bitcast(mask, ir.IntType(32)), ir.IntType(64)) for mask in masks]
        return cgutils.pack_array(builder, wide)

    return types.UniTuple(types.uint64, 4)(types.uint64), generate


@intrinsic
def _first_bit(typing: Any, mask: Any) -> Any:
    """Number of zero bits below the lowest one; the mask must not be zero."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.uint64(types.uint64), generate


@intrinsic
def _leading_zeros(typing: Any, number: Any) -> Any:
    """Number of zero bits above the highest one; the number must not be zero."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.ctlz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.uint64(types.uint64), generate


@intrinsic
def _product(typing: Any, a: Any, b: Any) -> Any:
    """Upper and lower 64 bits of the product of two 64-bit numbers."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word, wide = ir.IntType(64), ir.IntType(128)
        product = builder.mul(builder.zext(args[0], wide), builder.zext(args[1], wide))
        upper = builder.trunc(builder.lshr(product, ir.Constant(wide, 64)), word)
        return cgutils.pack_array(builder, [upper, builder.trunc(product, word)])

    return types.UniTuple(types.uint64, 2)(types.uint64, types.uint64), generate


@intrinsic
def _double(typing: Any, bits: Any) -> Any:
    """The double with these bits."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.uint64), generate


@intrinsic
def _signed(typing: Any, number: Any, negative: Any) -> Any:
    """The number with its sign changed if negative is 1; without a branch, which signs at random would mislead."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        flip = builder.shl(args[1], ir.Constant(word, 63))
        return builder.bitcast(builder.xor(builder.bitcast(args[0], word), flip), ir.DoubleType())

    return types.float64(types.float64, types.uint64), generate


@_inlined
def _digits(at, n):
    """Up to 8 digits at an address as bytes 0 to 9, the last one on top, zeros below."""
    shift = _U(32) - _U(4) * n
    return ((_eight_bytes(at) ^ _ZEROS) << shift) << shift  # two steps: a shift by 64 is undefined


@_inlined
def _no_digits(word):
    """Not zero when a byte is above 9."""
    return ((word + _ABOVE_NINE) | word) & _TOPS


@_inlined
def _number(word):
    """The number that eight digits make: of pairs, of fours, of all."""
    word = (word * _U(10) + (word >> _U(8))) & _U(0x00FF00FF00FF00FF)
    word = (word * _U(100) + (word >> _U(16))) & _U(0x0000FFFF0000FFFF)
    return (word * _U(10000) + (word >> _U(32))) & _U(0xFFFFFFFF)


@njit(error_model="numpy")
def _significand(at, lead, point, end, whole, fraction):
    """The digits from `lead` to `end` behind an address, but for the point, as a number, and how many beyond 19 are cut off.

    _NONE where there are other letters.
    """
    if whole <= _U(8) < fraction <= _U(24):
        n = min(fraction, _U(16)) - _U(8)
        rest = fraction - _U(8) - n
        start = at + point + _U(1)
        a, b = _digits(at + lead, whole), _digits(start, _U(8))
        c, d = _digits(start + _U(8), n), _digits(start + _U(8) + n, rest)
        if _no_digits(a) | _no_digits(b) | _no_digits(c) | _no_digits(d):
            return _NONE, 0
        zeros = _first_bit(b | _TOP) >> _U(3)
        if (fraction - zeros if a == 0 else whole + fraction) <= _U(19):
            number = _number(a) * _WHOLE[8] + _number(b)
            return (number * _WHOLE[n] + _number(c)) * _WHOLE[rest] + _number(d), 0
    number, significant, dropped = _U(0), 0, 0
    for i in range(lead, end):
        if i != point:
            digit = _U(_byte(at + i)) - _U(48)
            if digit > _U(9):
                return _NONE, 0
            if significant < 19:
                number = number * _U(10) + digit
                significant += number != 0
            else:
                dropped += 1
    return number, dropped


@_inlined
def _power(at, n):
    """The power of ten that n > 0 bytes at an address spell: e, a sign or none, up to 8 digits; else _NO_POWER."""
    sign = _byte(at + _U(1))
    signed = _U(sign == 45) | _U(sign == 43)
    digits = n - _U(1) - signed
    word = _digits(at + _U(1) + signed, min(digits, _U(8)))
    if digits - _U(1) > _U(7) or _no_digits(word):
        return _NO_POWER
    power = np.int64(_number(word))
    return -power if sign == 45 else power


@_inlined
def _rounded(w, q):
    """w 10^q to the nearest double, ties to even; NaN outside of the normal range. w > 0."""
    if q < _LOWEST or q > _HIGHEST:
        return np.nan
    zeros = _leading_zeros(w)
    w <<= zeros
    upper, lower = _product(w, _UPPER[q - _LOWEST])
    if upper & _U(0x1FF) == _U(0x1FF):  # the lower half of the power may carry into the bits that are kept
        carry, _ = _product(w, _LOWER[q - _LOWEST])
        lower += carry
        upper += _U(lower < carry)
    top = upper >> _U(63)
    kept = upper >> (top + _U(9))  # 53 bits and one to round by
    exponent = ((q * 217706) >> 16) + 1086 + np.int64(top) - np.int64(zeros)  # 217706 / 2^16: log2(10)
    if exponent <= 0 or exponent >= 2046:
        return np.nan
    if lower == _U(0) and -4 <= q <= 23 and kept & _U(3) == _U(1) and kept << (top + _U(9)) == upper:
        kept -= _U(1)  # half way between two doubles, which only these powers allow: down to the even one
    kept = (kept + (kept & _U(1))) >> _U(1)
    return _double((_U(exponent - 1) << _U(52)) + kept)  # the leading bit, or a carry beyond it, adds to the exponent


@_inlined
def _value(at, end, exponents, points):
    """The number that the word of `end` < 32 bytes at an address spells; NaN where that is left to the caller."""
    first = _byte(at)
    lead = _U(first == 45) | _U(first == 43)
    stop = _U(1) << end
    exponent = _first_bit(exponents | stop)
    point = _first_bit(points | exponents | stop)
    whole = point - lead
    fraction = exponent - point - _U(point < exponent)
    dropped = 0
    if whole + fraction == _U(0):
        return np.nan
    if whole <= _U(8) and fraction <= _U(8):
        a, b = _digits(at + lead, whole), _digits(at + point + _U(1), fraction)
        if (whole + fraction <= _U(8)) | (a == _U(0)):
            back = _U(4) * fraction
            b |= (a >> back) >> back  # one number of all digits
            w, wrong = _number(b), _no_digits(b)
        else:
            w, wrong = _number(a) * _WHOLE[fraction] + _number(b), _no_digits(a) | _no_digits(b)
        if wrong:
            return np.nan
    else:
        w, dropped = _significand(at, lead, point, exponent, whole, fraction)
        if w == _NONE:
            return np.nan
    q = dropped - np.int64(fraction)
    if exponent != end:
        power = _power(at + exponent, end - exponent)
        if power == _NO_POWER:
            return np.nan
        q += power
    if w < _U(1 << 53) and -22 <= q <= 22:
        number = np.float64(np.int64(w))
        number = number / _EXACT[-q] if q <= 0 else number * _EXACT[q]
    else:
        number = _rounded(w, q) if w else 0.0
        if dropped and number != _rounded(w + _U(1), q):  # the digits that were cut off decide
            return np.nan
    return _signed(number, _U(first == 45))


@_inlined
def _without_digits(at, end):
    """Whether the word of `end` bytes at an address is nan or inf, and then the number."""
    first = _byte(at)
    lead = _U(first == 45) | _U(first == 43)
    letters = (_eight_bytes(at + lead) | _U(0x202020)) & _U(0xFFFFFF)  # small letters
    number = np.inf if letters == _INF else np.nan
    return end - lead == _U(3) and letters in (_INF, _NAN), _signed(number, _U(first == 45))


@njit(cache=True, nogil=True, error_model="numpy")
def parse_rows(data, at, stop, slots, table, row, rows, odd):
    """Whole lines of data[at:stop] into table[:, row:rows]; the last one ends just before `stop`.

    data: (bytes,) uint8, with PADDING after `stop`. slots: (columns of the file,) int64, the row of `table` for each, -1 to pass over.
    table: (columns, rows) float64. odd: (room, 4) int64, gets row, slot, start and length of each word that is not decided here;
    `room` must be at least the number of columns. Returns where the next row starts, its number, how many odd words there are, and
    DONE, ODD_ROW or FULL (words of the next row may then be among the odd ones).
    """
    memory, at = _U(data.ctypes.data), _U(at)
    n_odd, columns = 0, len(slots)
    while row < rows and at < _U(stop):
        start, newline = at, False
        for column in range(columns):
            if newline:
                return start, row, n_odd, ODD_ROW
            blanks, exponents, points, newlines = _marks(memory + at)
            while blanks & _U(1):
                if newlines & _U(1):
                    return start, row, n_odd, ODD_ROW
                at += _U(1)
                blanks, exponents, points, newlines = _marks(memory + at)
            length = _first_bit(blanks | _U(1 << 32))
            while not blanks and data[at + length] != 32 and not 9 <= data[at + length] <= 13:
                length += _U(1)
            slot = slots[column]
            if slot >= 0:
                number = _value(memory + at, length, exponents, points) if blanks else np.nan
                known = not np.isnan(number)
                if not known:
                    known, number = _without_digits(memory + at, length)
                if not known:
                    if n_odd == len(odd):
                        return start, row, n_odd, FULL
                    odd[n_odd, 0], odd[n_odd, 1], odd[n_odd, 2], odd[n_odd, 3] = row, slot, at, length
                    n_odd += 1
                table[_U(slot), _U(row)] = number
            newline = data[at + length] == 10
            at += length + _U(1)
        while not newline:
            newline = data[at] == 10
            if not newline and data[at] != 32 and not 9 <= data[at] <= 13:
                return start, row, n_odd, ODD_ROW
            at += _U(1)
        row += 1
    return at, row, n_odd, DONE
