"""Thermo tables as printed, and as CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demverify.deck.setup import ThermoSpec
from demverify.errors import InputError
from demverify.formats.log import read_thermo
from demverify.formats.thermo import ThermoTable, thermo_formats, thermo_keywords, write_thermo_csv
from demverify.frames import Thermo
from tests.demverify.formats.samples import DATA, any_double

CASES = {
    "lammps": (DATA / "lammps" / "log.lammps", ("step", "atoms", "ke", "c_er", "vol")),
    "liggghts": (DATA / "liggghts" / "log.liggghts", ("step", "atoms", "ke", "c_1", "vol")),
}


@pytest.mark.parametrize("dialect", CASES)
def test_the_table_of_a_real_log_is_written_again(dialect: str) -> None:
    """Law: numbers read from a real log and written anew give the very lines of that log, header included."""
    path, keywords = CASES[dialect]
    table = ThermoTable(keywords, dialect, {})  # type: ignore[arg-type]
    lines = path.read_text().splitlines(keepends=True)
    assert table.header() in lines
    for values in read_thermo(path)[0].values:
        assert table.row(values) in lines


def test_style_one_of_a_real_log() -> None:
    """Law: style one has its fixed columns, and the volume where the box changes."""
    keywords = thermo_keywords(ThermoSpec(style="one"), "lammps", box_changes=True)
    path = DATA / "lammps" / "log.lammps"
    table, lines = ThermoTable(keywords, "lammps", {}), path.read_text().splitlines(keepends=True)
    assert table.header() in lines
    assert all(table.row(values) in lines for values in read_thermo(path)[2].values)
    assert thermo_keywords(ThermoSpec(style="one"), "liggghts", box_changes=False) == ("step", "atoms", "ke", "cpu")


def test_liggghts_cuts_names_to_eight_letters() -> None:
    """Law: LIGGGHTS heads a compute's column by the first eight letters of its ID; LAMMPS keeps c_ID."""
    assert ThermoTable(("step", "c_longname12"), "liggghts", {}).titles == ("Step", "longname")
    assert ThermoTable(("step", "c_longname12"), "lammps", {}).titles == ("Step", "c_longname12")


def test_formats_of_the_deck() -> None:
    """Law: thermo_modify format goes by column, then int and float."""
    spec = ThermoSpec(modify={"norm": "no", "format float": "%.3f", "format int": "%3d", "format 3": "%8.1e"})
    table = ThermoTable(("step", "ke", "vol"), "lammps", thermo_formats(spec))
    assert table.row([7, 1.0, 2.0]) == "  7 1.000  2.0e+00\n"


@pytest.mark.parametrize(
    ("keywords", "formats", "message"),
    [
        (("step", "kinetic"), {}, "thermo keyword 'kinetic' is not one of step elapsed"),
        (("step", "erotate"), {}, "thermo keyword 'erotate'"),
        (("step", "ke"), {"float": "%d"}, "format '%d' of column ke"),
        (("step", "ke"), {"4": "%g"}, "format for column '4'"),
    ],
)
def test_wrong_tables_are_refused(keywords: tuple[str, ...], formats: dict[str, str], message: str) -> None:
    """Law: what LAMMPS cannot print is refused when the table is made, listing what exists."""
    with pytest.raises(InputError, match=message):
        ThermoTable(keywords, "lammps", formats)


def test_style_multi_is_not_written() -> None:
    """Law: styles that are not written are refused by name."""
    with pytest.raises(InputError, match="thermo_style 'multi' is not one of one, custom"):
        thermo_keywords(ThermoSpec(style="multi"), "lammps", box_changes=False)


@given(rows=st.lists(st.tuples(any_double, any_double), max_size=5))
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_csv_keeps_every_bit(tmp_path: Path, rows: list[tuple[float, float]]) -> None:
    """Law: CSV numbers read back to the same doubles, signs of zero included."""
    values = np.array(rows, dtype=float).reshape(-1, 2)
    write_thermo_csv(tmp_path / "thermo.csv", Thermo(("Step", "KinEng"), values))
    head, *lines = (tmp_path / "thermo.csv").read_text().splitlines()
    assert head == "Step,KinEng"
    got = np.array([[float(word) for word in line.split(",")] for line in lines]).reshape(-1, 2)
    np.testing.assert_array_equal(got, values)
    assert (np.signbit(got) == np.signbit(values))[~np.isnan(values)].all()


def test_csv_of_steps_is_plain(tmp_path: Path) -> None:
    """Law: whole numbers carry no point."""
    write_thermo_csv(tmp_path / "thermo.csv", Thermo(("Step", "KinEng"), np.array([[100.0, 0.1]])))
    assert (tmp_path / "thermo.csv").read_text() == "Step,KinEng\n100,0.1\n"
