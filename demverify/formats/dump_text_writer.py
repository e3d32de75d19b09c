"""Text dumps as LAMMPS and LIGGGHTS would write them, byte for byte."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from demverify.deck.setup import Dialect
from demverify.errors import Place
from demverify.formats.columns import INTEGER_COLUMNS
from demverify.formats.printf import column_formats, format_rows
from demverify.frames import Frame


def text_frame(
    frame: Frame,
    names: Sequence[str],
    dialect: Dialect,
    formats: Mapping[str, str] | None = None,
    place: Place | None = None,
    rows: str = "ATOMS",
) -> bytes:
    """One frame as the engine of `dialect` writes it, rows in the order of the frame's arrays.

    names: the columns, in order, all of them in frame.columns. formats: as dump_modify format (see printf.column_formats).
    rows: ATOMS, or ENTRIES of a dump local.
    LAMMPS joins by blanks and writes bounds with 17 digits, LIGGGHTS ends each with a blank and gives bounds 6 digits.
    NaN is `nan`: the sign that C's printf may show is lost.
    """
    integer = [name in INTEGER_COLUMNS for name in names]
    fmts = column_formats(names, integer, formats or {}, ("%d", "%g"), place)
    types = [np.int64 if whole else np.float64 for whole in integer]
    columns = [frame.columns[name].astype(kind).tolist() for name, kind in zip(names, types, strict=True)]
    end = " \n" if dialect == "liggghts" else "\n"
    bound = "%g %g\n" if dialect == "liggghts" else "%-1.16e %-1.16e\n"
    head = (
        f"ITEM: TIMESTEP\n{frame.step}\nITEM: NUMBER OF {rows}\n{frame.n}\nITEM: BOX BOUNDS {' '.join(frame.boundary)}\n"
        + "".join(bound % (lo, hi) for lo, hi in frame.box.tolist())
        + f"ITEM: {rows} {' '.join(names)}{end}"
    )
    return head.encode() + format_rows(" ".join(fmts) + end, columns)
