"""Thermo tables as the engines print them (`thermo_style one` and `custom`), and as CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from demverify.deck.setup import Dialect, ThermoSpec
from demverify.errors import InputError, Place
from demverify.formats.atomic import atomic_write
from demverify.formats.printf import column_formats
from demverify.frames import Thermo

_INTEGER = frozenset({"step", "elapsed", "elaplong", "part", "atoms", "nbuild", "ndanger"})
_TITLES = {
    "step": "Step", "elapsed": "Elapsed", "elaplong": "Elaplong", "part": "Part", "atoms": "Atoms",
    "dt": "Dt", "time": "Time", "cpu": "CPU", "tpcpu": "T/CPU", "spcpu": "S/CPU", "cpuremain": "CPULeft",
    "ke": "KinEng", "vol": "Volume", "density": "Density", "fmax": "Fmax", "fnorm": "Fnorm",
    "lx": "Lx", "ly": "Ly", "lz": "Lz", "xlo": "Xlo", "xhi": "Xhi", "ylo": "Ylo", "yhi": "Yhi", "zlo": "Zlo", "zhi": "Zhi",
}  # fmt: skip
TITLES: dict[Dialect, dict[str, str]] = {
    "lammps": _TITLES
    | {
        "timeremain": "TimeoutLeft", "temp": "Temp", "press": "Press", "pe": "PotEng", "etotal": "TotEng", "enthalpy": "Enthalpy",
        "evdwl": "E_vdwl", "ecoul": "E_coul", "epair": "E_pair", "emol": "E_mol", "elong": "E_long", "etail": "E_tail",
        "ebond": "E_bond", "eangle": "E_angle", "edihed": "E_dihed", "eimp": "E_impro",
        "pxx": "Pxx", "pyy": "Pyy", "pzz": "Pzz", "pxy": "Pxy", "pxz": "Pxz", "pyz": "Pyz",
        "nbuild": "Nbuild", "ndanger": "Ndanger",
    },
    "liggghts": _TITLES | {"erotate": "RotEng", "cu": "Cu"},
}  # fmt: skip
"""What the engine prints over the column of a thermo keyword."""

_ONE: dict[Dialect, tuple[str, ...]] = {
    "lammps": ("step", "temp", "epair", "emol", "etotal", "press"),
    "liggghts": ("step", "atoms", "ke", "cpu"),
}


def thermo_keywords(spec: ThermoSpec, dialect: Dialect, *, box_changes: bool) -> tuple[str, ...]:
    """The keywords of a table. box_changes: some face is s or m; then style one has the volume too."""
    if spec.style == "custom":
        return spec.columns
    if spec.style == "one":
        return _ONE[dialect] + ("vol",) * box_changes
    message = f"thermo_style {spec.style!r} is not one of one, custom"
    raise InputError(message)


@dataclass(frozen=True)
class ThermoTable:
    """Header and rows of a thermo table in the layout of `dialect`, ready to print, newlines included.

    keywords: as in thermo_style custom. formats: as in thermo_modify format (see printf.column_formats).
    (LIGGGHTS 3.8.0 prints a bare `%ld` for every column with a `format int`; that is not imitated.)
    """

    keywords: Sequence[str]
    dialect: Dialect
    formats: Mapping[str, str]
    place: Place | None = None

    def __post_init__(self) -> None:
        """Raises InputError for a keyword that the dialect does not have, and for a format that does not fit."""
        self.header()
        self.row([0.0] * len(self.keywords))

    @property
    def titles(self) -> tuple[str, ...]:
        """The column heads: LAMMPS keeps c_ID, LIGGGHTS prints the first eight letters of ID."""
        return tuple(self._title(keyword) for keyword in self.keywords)

    def header(self) -> str:
        """The line over the table."""
        if self.dialect == "liggghts":
            return "".join(f"{title:>{8 if whole else 14}} " for title, whole in self._columns()) + "\n"
        return " ".join(f"{title:^{11 if whole else 14}}" for title, whole in self._columns()) + "\n"

    def row(self, values: Sequence[float]) -> str:
        """One line of numbers, in the order of the keywords."""
        defaults = ("%8d", "%14.8g") if self.dialect == "liggghts" else ("%10d ", "% -14.8g")
        formats = column_formats(self.keywords, self._integer, self.formats, defaults, self.place)
        numbers = tuple(int(value) if whole else float(value) for value, whole in zip(values, self._integer, strict=True))
        return " ".join(formats) % numbers + (" \n" if self.dialect == "liggghts" else "\n")

    @property
    def _integer(self) -> list[bool]:
        return [keyword in _INTEGER for keyword in self.keywords]

    def _columns(self) -> list[tuple[str, bool]]:
        return list(zip(self.titles, self._integer, strict=True))

    def _title(self, keyword: str) -> str:
        if keyword.startswith(("c_", "f_", "v_")):
            return keyword[2:10] if self.dialect == "liggghts" else keyword
        known = TITLES[self.dialect]
        if keyword not in known:
            message = f"thermo keyword {keyword!r} is not one of {' '.join(known)} or c_ID, f_ID, v_NAME"
            raise InputError(message, self.place)
        return known[keyword]


def thermo_formats(spec: ThermoSpec) -> dict[str, str]:
    """The formats in `spec.modify`, whose keys are "format float", "format int", "format line", "format N"."""
    return {key.removeprefix("format "): value for key, value in spec.modify.items() if key.startswith("format ")}


def write_thermo_csv(path: Path, thermo: Thermo) -> None:
    """A header of column names, then rows whose numbers read back to the same bits."""
    lines = [",".join(thermo.columns)]
    lines += [",".join(repr(value).removesuffix(".0") for value in row) for row in thermo.values.tolist()]
    with atomic_write(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n")
