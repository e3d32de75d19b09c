"""Numbers behind a page as HDF5: mappings become groups, rows of numbers datasets, the rest attributes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demverify.formats.atomic import atomic_write

if TYPE_CHECKING:
    import h5py


def write_numbers(path: Path, numbers: Mapping[str, Any]) -> None:
    """Writes a file of numbers, whole or not at all. A `/` in a name is written as a division sign, as it would be a path."""
    import h5py

    with atomic_write(path) as temporary, h5py.File(temporary, "w") as file:
        _fill(file, numbers)


def _fill(group: h5py.Group, numbers: Mapping[str, Any]) -> None:
    for key, value in numbers.items():
        name = str(key).replace("/", "\N{DIVISION SLASH}")
        if isinstance(value, Mapping):
            _fill(group.create_group(name), value)
            continue
        array = _array(value)
        if array is None:
            group.attrs[name] = str(value)
        elif array.ndim:
            group.create_dataset(name, data=array)
        else:
            group.attrs[name] = array


def _array(value: Any) -> np.ndarray[Any, Any] | None:
    """Numbers as an array; None where they are none, or rows of different lengths."""
    try:
        array = np.asarray(value)
    except ValueError:
        return None
    return array if array.dtype.kind in "biuf" else None
