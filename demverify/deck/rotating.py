"""Regions that turn as walls: `region ... rotate v_theta` of LAMMPS, whose rate is the angle of a step less that of the step before (measured).

So a wall turns steadily only where its angle grows by the same in every step and goes on from run to run; in the set-up of every run it is still,
for there the angle is what it was. Everything else is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from demverify.deck.setup import Setup, Spec
from demverify.errors import InputError, Place

SAMPLES = 100  # steps of a run at which the angle is looked at
ROUNDING = 1e-12  # of an angle: formulas of a few operations, variables in them taken with 15 digits


@dataclass(frozen=True)
class Turn:
    """How a region turns in one run. rate [rad/time], right-handed about its axis. end: the last step and its angle."""

    rate: float
    end: tuple[int, float]


def turns_of(setup: Setup, steps: int) -> dict[str, Turn]:
    """The turns, in a run that begins now, of the regions that are walls. Raises InputError for an angle that does not grow steadily."""
    walls = [(region_of(fix), fix) for fix in setup.fixes.values() if fix.style == "wall/gran/region"]
    return {name: _turn(setup, name, fix.place, steps) for name, fix in walls if name in setup.regions and setup.regions[name].angle}


def region_of(fix: Spec) -> str:
    """The region's ID of a fix wall/gran/region, "" where it names none."""
    at = fix.args.index("region") if "region" in fix.args[:-1] else len(fix.args) - 1
    return fix.args[at + 1] if at + 1 < len(fix.args) else ""


def _turn(setup: Setup, name: str, place: Place, steps: int) -> Turn:
    region = setup.regions[name]
    at = np.unique(np.linspace(0, max(steps, 1), SAMPLES).round())
    angles = np.array([_angle(setup, region.angle, int(step), place) for step in at])
    slope = (angles[-1] - angles[0]) / at[-1]
    if np.abs(angles - angles[0] - slope * at).max() > ROUNDING * np.abs(angles).max():
        message = f"region {name}: v_{region.angle} does not grow by the same angle in every step, which is all that is supported"
        raise InputError(message, place)
    end = setup.step + steps
    if setup.step > 0:
        _check_continued(setup, name, angles[0], place)
    return Turn(float(region.turns * slope / setup.dt), (end, _angle(setup, region.angle, steps, place)))


def _check_continued(setup: Setup, name: str, angle: float, place: Place) -> None:
    """LAMMPS takes the first angle of a run less the last that it knows for the way of one step."""
    step, last = setup.turns[name].end if name in setup.turns else (0, 0.0)
    if step != setup.step or abs(angle - last) > ROUNDING * abs(angle):
        message = (
            f"region {name}: the angle v_{setup.regions[name].angle} comes to the run at step {setup.step} from another step or angle,"
            " and LAMMPS takes the jump for the way of one step; supported: a wall that turns steadily from step 0 on"
        )
        raise InputError(message, place)


def _angle(setup: Setup, name: str, later: int, place: Place) -> float:
    clock: Mapping[str, float] = {"step": setup.step + later, "dt": setup.dt, "time": setup.time + later * setup.dt}
    return float(setup.variables.at(clock).exact(name, place))

