"""The fixes check/timestep/gran of a running deck: evaluated when LIGGGHTS evaluates them, their values kept in between."""

from __future__ import annotations

import re
from collections.abc import Iterator

from demsolver.simulate import Simulation
from demverify.deck.setup import Setup, Spec
from demverify.deck.timestep_gran import STYLE, Check, check_of, liggghts_material, times_of
from demverify.errors import InputError, Place

FIX = re.compile(r"f_([^\[\]]+)(?:\[(\d+)\])?$")
VALUES = 3


class StepChecks:
    """At the end of every step that `every` divides, LIGGGHTS computes a fix anew; before the first such step it is zero."""

    def __init__(self) -> None:
        """No fix has been seen."""
        self._values: dict[str, tuple[Spec, tuple[float, float, float]]] = {}

    def next(self, setup: Setup, now: int, end: int) -> int:
        """The next step at which a fix must be computed: where its values are seen, and everywhere if it may end the run."""
        due = [end]
        for _, check in _fixes(setup):
            last = end - end % check.every
            due += [now - now % check.every + check.every] if check.error else [last] if last > now else []
        return min(due)

    def update(self, setup: Setup, simulation: Simulation) -> None:
        """Computes the fixes that are due at this step. Raises InputError for one with `error yes` whose limits the step breaks."""
        for spec, check in _fixes(setup):
            if simulation.step % check.every:
                continue
            particles = simulation.particles()
            times = times_of(particles, liggghts_material(setup, spec), vmax=check.vmax, bit=check.bit, dimension=setup.dimension)
            dt, skin = setup.dt, simulation.scene.neighbor.skin
            self._values[spec.id] = (spec, times.fractions(dt, skin))
            if check.error and (said := times.complaints(check, dt, skin)):
                message = f"fix {spec.id} {STYLE} ends the run at step {simulation.step}: {said[0]}"
                raise InputError(message, spec.place)

    def value(self, setup: Setup, name: str, index: int) -> float:
        """f_NAME[index]. Raises InputError."""
        check_reference(setup, name, index, setup.thermo.place)
        spec, values = self._values.get(name, (None, ()))
        return values[index - 1] if spec is setup.fixes[name] else 0.0


def check_fixes(setup: Setup) -> None:
    """Raises InputError for a fix without a pair style, or whose material the deck does not give, as LIGGGHTS does."""
    for spec, _ in _fixes(setup):
        if (setup.pair_style or ("none",))[0] != "gran":
            message = f"fix {spec.id} {STYLE} needs pair_style gran"
            raise InputError(message, spec.place)
        liggghts_material(setup, spec)


def check_reference(setup: Setup, name: str, index: int, place: Place | None) -> None:
    """Raises InputError when f_NAME[index] has no value."""
    known = [spec.id for spec, _ in _fixes(setup)]
    if name not in known:
        message = f"f_{name}: {name!r} is not one of the fixes {STYLE}: {', '.join(known) or 'none'}"
        raise InputError(message, place)
    if not 1 <= index <= VALUES:
        message = f"f_{name}{f'[{index}]' * bool(index)}: this fix has f_{name}[1] to f_{name}[{VALUES}]"
        raise InputError(message, place)


def check_rhythm(setup: Setup, name: str, place: Place | None) -> None:
    """Raises InputError when a thermo table shows a fix at steps where it is not computed, as LIGGGHTS does."""
    every = check_of(setup, setup.fixes[name]).every
    if setup.thermo.every % every:
        message = f"thermo prints f_{name} every {setup.thermo.every} steps, but fix {name} is computed every {every}"
        raise InputError(message, place)


def _fixes(setup: Setup) -> Iterator[tuple[Spec, Check]]:
    return ((spec, check_of(setup, spec)) for spec in setup.fixes.values() if spec.style == STYLE)
