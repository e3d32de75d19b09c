"""A backend that runs nothing: it notes what a deck asks for."""

from __future__ import annotations

from copy import copy, deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING

from demverify.deck.setup import Setup
from demverify.deck.state_values import moves, state_value
from demverify.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from demsolver.memories import Memories
    from demsolver.scene import Scene
    from demverify.deck.restart import Restart


@dataclass(frozen=True)
class DryRun:
    """One `run` command: a copy of the setup as it was, and the number of steps."""

    setup: Setup
    steps: int

    @property
    def scene(self) -> Scene:
        """The scene of that run, built on demand. Raises InputError."""
        from demverify.deck.scene_builder import scene_of

        return scene_of(self.setup)


class NeedsRun(InputError):
    """A deck goes on with a value that only a run gives."""


class DryBackend:
    """Records runs; answers only what follows from the set-up."""

    def __init__(self) -> None:
        """`runs` fills as the deck goes on."""
        self.runs: list[DryRun] = []
        self._kept: dict[str, Restart] = {}

    def run(self, setup: Setup, steps: int) -> None:
        """Notes the run and advances step and time; the particles stay where they are."""
        kept = copy(setup)
        kept.variables = None
        kept = deepcopy(kept)
        kept.variables = setup.variables.snapshot() if setup.variables else None
        self.runs.append(DryRun(kept, steps))
        setup.step += steps
        setup.time += steps * setup.dt

    def value(self, setup: Setup, keyword: str) -> float:
        """A value known without running. Raises InputError for one that only a run gives."""
        found = None if self.runs and moves(keyword) else state_value(setup, keyword)
        if found is None:
            raise NeedsRun(f"the formula needs {keyword}, which only a run gives")
        return found

    def memories(self, setup: Setup) -> Memories | None:
        """Those of a file that no run has taken up yet."""
        return setup.memories

    def keep(self, state: Restart, name: str) -> None:
        """Keeps it in memory; writes nothing. Raises InputError as the native engine would."""
        from demverify.engines._outputs import check_own_file

        check_own_file("write_restart", name)
        self._kept[name] = state

    def kept(self, name: str, folder: Path) -> Restart:
        """What was kept, else what the file holds. Raises InputError."""
        from demverify.deck.restart import find_restart, newest, read_restart_file

        own = newest(name, self._kept)
        return self._kept[own] if own else read_restart_file(find_restart(name, folder))

    def cleared(self) -> None:
        """Nothing to end."""
