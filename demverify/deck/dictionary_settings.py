"""Units, dimension and time step of a deck."""

from __future__ import annotations

from math import isfinite

from demverify.deck.dictionary_script import Spoken
from demverify.deck.setup import Setup

_WITH_A_STEP = ("lj", "si", "cgs", "micro")  # units whose default step Setup.dt knows
_NAMES = ("units", "dimension", "timestep", "reset_timestep", "create_box", "read_data", "read_restart", "include", "jump")


class Settings:
    """dimension: 2 or 3."""

    def __init__(self) -> None:
        """Nothing is set."""
        self.dimension = 3
        self._units: str | None = None
        self._step: float | None = None
        self._box = self._elsewhere = False  # whether the deck makes a box; whether a file that is not read may set something
        self._unknown = ""  # why the step is not known
        self._runs: list[tuple[float | None, bool]] = []  # steps of the runs since step 0, and whether files were written

    @property
    def units(self) -> str | None:
        """Word of the `units` command, or the default of both engines in a deck that begins at the beginning. None: not known."""
        return self._units or ("lj" if self._box and not self._elsewhere else None)

    def concerns(self, cmd: Spoken) -> bool:
        """Whether a command sets one of these."""
        return cmd.name in _NAMES or (cmd.name == "fix" and "dt/reset" in cmd.args[2:3])

    def read(self, cmd: Spoken) -> None:
        """Raises InputError for a value that cannot be told."""
        cmd.sure()
        if cmd.name == "units":
            self._units, self._step, self._unknown = cmd.take("a word"), None, ""
        elif cmd.name == "dimension":
            self.dimension = cmd.integer("dimension", 2, 3)
        elif cmd.name == "timestep":
            self._step, self._unknown = cmd.number("time step", 0.0), ""
        elif cmd.name == "reset_timestep":
            self._runs = [(step, dumping) for step, dumping in self._runs if dumping]
        elif cmd.name == "fix":
            raise cmd.error("dt/reset changes the time step while runs go on")
        elif cmd.name in {"create_box", "read_data"}:
            self._box = True
        else:
            self._elsewhere = True
            if self._step is None:
                self._unknown = f"{cmd.name} in {cmd.where} may set it"

    def doubt(self, cmd: Spoken, why: str) -> None:
        """A command could not be read."""
        if cmd.name == "units":
            self._units, self._elsewhere = None, True
        if cmd.name not in {"dimension", "create_box", "read_data"}:
            self._unknown = why

    def run(self, *, dumping: bool) -> None:
        """A run goes on with the step as it is now."""
        self._runs.append((self._now(), dumping))

    def _now(self) -> float | None:
        if self._unknown:
            return None
        if self._step is None and self._box and self.units in _WITH_A_STEP:
            return Setup(dialect="lammps", units=self.units).dt
        return self._step

    def timestep(self) -> tuple[float | None, list[str]]:
        """The step of all runs, None where there are several or where it is not known; and why."""
        steps = list(dict.fromkeys(step for step, _ in self._runs)) or [self._now()]
        if len(steps) > 1:
            shown = ", ".join("one that is not known" if step is None else f"{step:g}" for step in steps)
            return None, [f"the time step changes between runs ({shown}): steps do not tell the time"]
        if steps[0] is None or not isfinite(steps[0]):
            return None, [f"the time step is not known: {self._unknown or 'the deck does not set it'}"]
        return steps[0], []
