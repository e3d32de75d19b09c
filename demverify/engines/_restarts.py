"""Restart files of a native run: those it writes and reads, and what its simulation takes up from them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from demverify.deck.restart import Restart, find_restart, newest, read_restart_file, write_restart_file
from demverify.engines._outputs import check_own_file
from demverify.errors import InputError

if TYPE_CHECKING:
    from demsolver import Simulation
    from demverify.deck.setup import Setup


class RestartFiles:
    """The restart files in the folder of one run."""

    def __init__(self, folder: Path) -> None:
        """Nothing is written yet."""
        self._folder = folder
        self._names: list[str] = []

    def keep(self, state: Restart, name: str) -> None:
        """Writes a file. Raises InputError for a name that leads out of the folder or is taken by an output."""
        check_own_file("write_restart", name)
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_restart_file(path, state)
        self._names.append(name)

    def kept(self, name: str, folder: Path) -> Restart:
        """What this run wrote, else what stands in `folder`, that of the deck. Raises InputError."""
        own = newest(name, self._names)
        return read_restart_file(self._folder / own if own else find_restart(name, folder))


def recalled(simulation: Simulation, setup: Setup) -> str:
    """Hands what a restart file remembers to a simulation that begins; returns a line for each wall that did not come back.

    Raises InputError for contact laws that are not those of the file."""
    found, setup.memories = setup.memories, None
    if found is None:
        return ""
    try:
        simulation.recall(found)
    except ValueError as error:
        message = f"read_restart: {error}"
        raise InputError(message, setup.restored) from error
    missing = sorted(set(found.walls) - {wall.name for wall in simulation.scene.walls})
    return "".join(f"read_restart: what fix {name} remembered is not used, for no wall of this ID was stated again\n" for name in missing)
