"""Writing a file so that no reader ever meets half of it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from demverify.errors import InputError


def part_path(path: Path) -> Path:
    """Where the bytes of `path` gather until it is whole: `path.part`, in the same folder."""
    return path.with_name(path.name + ".part")


def check_writable(*paths: Path | None) -> None:
    """To be asked before the work, not after it. None: a file that nobody wants. Raises InputError where no file can come to be: its folder
    does not exist, or it is a folder itself."""
    for path in filter(None, paths):
        if not path.parent.is_dir():
            message = f"cannot write {path.name}: there is no folder {path.parent}"
            raise InputError(message)
        if path.is_dir():
            message = f"cannot write {path}: it is a folder"
            raise InputError(message)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Holds SIGINT and SIGTERM back until the block is done, so that a frame in several files is whole in all of them."""
    came: list[int] = []
    before: dict[int, Any] = {}
    with suppress(ValueError):  # only the main thread may, and only it is interrupted
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for known, handler in before.items():
            signal.signal(known, handler)
    for caught in came:
        signal.raise_signal(caught)


@contextmanager
def atomic_write(path: Path, *, keep: bool = False) -> Iterator[Path]:
    """Yields the name of a temporary file to write; on success it becomes `path`, on failure it is removed.

    keep: for streams of frames that are each written whole: also an interrupted one becomes `path`, as far as it got.
    (After SIGKILL nothing runs any more: `path.part` is left.)
    Raises InputError as `check_writable` does.
    """
    check_writable(path)
    temporary = part_path(path)
    try:
        yield temporary
    except BaseException:
        if not keep:
            temporary.unlink(missing_ok=True)
        elif temporary.exists():
            temporary.replace(path)
        raise
    temporary.replace(path)
