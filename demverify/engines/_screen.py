"""What an engine prints: steps as they come, loop times, and why it died. LAMMPS and LIGGGHTS print alike, with `-echo both`."""

from __future__ import annotations

import re
from dataclasses import dataclass

from demverify.engines._words import squeezed
from demverify.engines.base import Progress
from demverify.errors import Place

_LOOP = re.compile(r"^Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms", re.MULTILINE)
_RUN = re.compile(r"^run\s+(\d+)(\s+upto\b)?")
_ROW = re.compile(r"^\s*(\d+)(?:\s|$)")
_LAST_LINES = 5


@dataclass(frozen=True)
class Loops:
    """Sums over the runs of a deck. seconds: loop time. work: particles times steps. n: particles in the last run."""

    seconds: float
    steps: int
    work: int
    n: int

    @property
    def rate(self) -> float:
        """Particle steps per second; 0 where no time was taken."""
        return self.work / self.seconds if self.seconds > 0 else 0.0


def loops(screen: str) -> Loops:
    """The sums of all `Loop time` lines."""
    found = [(float(time), int(steps), int(n)) for time, steps, n in _LOOP.findall(screen)]
    return Loops(
        sum(time for time, _, _ in found),
        sum(steps for _, steps, _ in found),
        sum(steps * n for _, steps, n in found),
        found[-1][2] if found else 0,
    )


class Tracker:
    """Follows the screen as it grows and reports (steps done, steps planned; with no plan, the end of the present run)."""

    def __init__(self, report: Progress, total: int | None) -> None:
        self._report = report
        self._total = total
        self._rest = ""  # a line not yet whole
        self._before = 0  # steps of finished runs
        self._step = 0  # timestep number last seen
        self._first: int | None = None  # timestep number at the start of this run
        self._length = 0
        self._in_table = False

    def feed(self, text: str) -> None:
        """Take in what was printed since the last call."""
        *lines, self._rest = (self._rest + text).split("\n")
        done = [self._line(line) for line in lines]
        if any(done):
            self._report(self._done, self._total if self._total is not None else self._before + self._length)

    @property
    def _done(self) -> int:
        return self._before + (self._step - self._first if self._first is not None else 0)

    def _line(self, line: str) -> bool:
        """Take in one line; True when it moved the count."""
        if match := _RUN.match(line):
            self._length = int(match[1]) - (self._step if match[2] else 0)
        elif match := _LOOP.match(line):
            self._before, self._first, self._in_table = self._before + int(match[2]), None, False
            self._length = 0
            return True
        elif line.split()[:1] == ["Step"]:
            self._in_table = True
        elif self._in_table and (match := _ROW.match(line)):
            self._step = int(match[1])
            self._first = self._step if self._first is None else self._first
            return True
        return False


def why(screen: str, errors: str, places: dict[str, list[Place]]) -> str:
    """The ERROR line with the place of the command in the user's deck, or else the last lines of screen and stderr."""
    lines = screen.splitlines()
    at = next((i for i, line in enumerate(lines) if line.startswith("ERROR")), None)
    if at is None:
        return "\n".join([*_tail(screen), *_tail(errors)])
    place = _last_command(lines[:at], places)
    head = f"{place}: {lines[at]}" if place else lines[at]
    return "\n".join([head, *_tail("\n".join(lines[:at])), *lines[at + 1 : at + 3]])


def _last_command(echoed: list[str], places: dict[str, list[Place]]) -> Place | None:
    """Where the last command stands that was echoed. Of equal lines the k-th echo is taken for the k-th line."""
    commands = [line for line in map(squeezed, echoed) if line in places]
    if not commands:
        return None
    among = places[commands[-1]]
    return among[min(commands.count(commands[-1]), len(among)) - 1]


def _tail(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.strip()][-_LAST_LINES:]
