"""Numbers of a page as HDF5."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from demverify.report.numbers import write_numbers


def test_numbers_come_back_as_they_were(tmp_path: Path) -> None:
    """Law: mappings are groups, rows datasets, single numbers and texts attributes; a slash makes no folder."""
    path = tmp_path / "numbers.h5"
    write_numbers(path, {"one": {"x": np.arange(3.0), "k dt^2/m": [1, 2], "n": 7, "why": "text"}, "ragged": [[1], [1, 2]]})
    with h5py.File(path) as file:
        assert file["one/x"][:].tolist() == [0.0, 1.0, 2.0]
        assert file["one"]["k dt^2\N{DIVISION SLASH}m"][:].tolist() == [1, 2]
        assert file["one"].attrs["n"] == 7
        assert file["one"].attrs["why"] == "text"
        assert file.attrs["ragged"] == "[[1], [1, 2]]"
