"""Tells when a run is about to start with a step above a stability limit. A scene far below its limits costs a few milliseconds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from demsolver.scene import Scene
from demsolver.simulate import Simulation
from demsolver.stability import contact_limits
from demsolver.stability_contacts import Contacts, contacts_in
from demsolver.stability_packing import packing_bound, packing_limit

MOST_CONTACTS = 20_000
"""Packings larger than this are told of by their single contacts only: their own limit takes more than a second or two."""
GROWN = 1.1
"""A packing is looked at again when it has so many times the contacts it had."""


@dataclass
class StepWatch:
    """tell: called with one line when a step is above a limit; for each limit once."""

    tell: Callable[[str], object]
    _told: set[str] = field(default_factory=set)
    _fine: dict[float, float] = field(default_factory=dict)  # step -> contacts of the last packing that was below its limit

    def look(self, simulation: Simulation) -> None:
        """At a simulation that has been set up; not at one with clumps, whose limits are not known here."""
        if simulation.scene.particles.clumps is not None:
            return
        scene = replace(simulation.scene, particles=simulation.particles())
        contacts = contacts_in(scene, simulation.bodies, simulation.pairs, simulation.box_hi - simulation.box_lo)
        limits = contact_limits(scene, contacts)
        worst = min(limits, key=lambda limit: limit.combined, default=None)
        if worst is not None and scene.timestep > worst.combined:
            self._say(scene.timestep, worst.combined, f"{worst.between}, {worst.motion} ({worst.law})")
        elif limits:
            self._packing(scene, contacts)

    def _packing(self, scene: Scene, contacts: Contacts) -> None:
        dt, count = scene.timestep, len(contacts)
        if count > MOST_CONTACTS or count <= GROWN * self._fine.get(dt, 0) or dt <= packing_bound(scene, contacts):
            return
        found = packing_limit(scene, contacts)
        if dt <= found.combined:
            self._fine[dt] = count
        else:
            self._say(dt, found.combined, f"the packing of {count} contacts ({found.law})")

    def _say(self, step: float, limit: float, what: str) -> None:
        name = what.split(" (", maxsplit=1)[0]
        if name not in self._told:
            self._told.add(name)
            self.tell(f"the step {step:.6g} is above {limit:.6g}, the stability limit of {what}")
