"""The output of one `run` command in the native engine: thermo, dumps and the trajectory file, at the steps at which they are due."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from demsolver import Simulation
    from demverify.deck.setup import DumpSpec, Setup
    from demverify.engines.native import NativeBackend
    from demverify.formats.bodies import Bodies
    from demverify.formats.columns import Snapshot
    from demverify.formats.dump import DumpWriter

TRAJECTORY = [
    "id", "type", "x", "y", "z", "ix", "iy", "iz", "vx", "vy", "vz", "fx", "fy", "fz",
    "omegax", "omegay", "omegaz", "tqx", "tqy", "tqz", "radius", "mass",
]  # fmt: skip


@dataclass
class OpenDump:
    """A dump of the deck and its files. last: the step of its last frame, -1 before the first."""

    spec: DumpSpec
    writer: DumpWriter
    last: int = -1


class Run:
    """The output of one `run`: which steps, and what is written at them."""

    def __init__(self, backend: NativeBackend, setup: Setup, simulation: Simulation, steps: int) -> None:
        from demverify.engines._outputs import keywords_of
        from demverify.engines._thermo import Meter
        from demverify.formats.thermo import ThermoTable, thermo_formats

        self.backend, self.setup, self.simulation, self.steps = backend, setup, simulation, steps
        self.start, self.end = setup.step, setup.step + steps
        self.portion = 1  # steps that may be done before the next sign of life
        self.meter = Meter(setup, simulation, self.start, perf_counter(), backend._checks)
        self.table = ThermoTable(keywords_of(setup), setup.dialect, thermo_formats(setup.thermo), setup.thermo.place)
        self._head = self.table.header()
        self._open_dumps()
        if not backend._thermo or backend._thermo[-1][0] != self.table.titles:
            backend._thermo.append((self.table.titles, []))

    def next_output(self) -> int:
        """The next step at which anything is written, or the end."""
        rhythms = [self.setup.thermo.every, self.backend._every or 0, *(dump.every for dump in self.setup.dumps.values())]
        now = self.simulation.step
        checks = self.backend._checks.next(self.setup, now, self.end)
        return min([self.end, checks, *(now - now % every + every for every in rhythms if every > 0)])

    def output(self) -> None:
        """Writes what is due at this step, whatever interrupts."""
        from demverify.formats.atomic import undisturbed

        step, thermo = self.simulation.step, self.setup.thermo
        self._bring_back()
        if step > self.start:
            self.backend._checks.update(self.setup, self.simulation)
        with undisturbed():
            if step in (self.start, self.end) or (thermo.every and step % thermo.every == 0):
                self._write_thermo()
            for dump in self.backend._dumps.values():
                self._write_dump(dump, step)
            self._write_frame(step)

    def _write_thermo(self) -> None:
        from demsolver import Unstable

        norm = normalised(self.setup)
        values = [self.meter.value(keyword, normalise=norm) for keyword in self.table.keywords]
        for keyword, value in zip(self.table.keywords, values, strict=True):
            if not isfinite(value):
                message = f"thermo column {keyword} became infinite by step {self.simulation.step}"
                raise Unstable(message)
        self.backend.say(self._head + self.table.row(values))
        self._head = ""
        rows = self.backend._thermo[-1][1]
        if not (rows and "Step" in self.table.titles and rows[-1][self.table.titles.index("Step")] == self.simulation.step):
            rows.append(values)

    def _open_dumps(self) -> None:
        """Closes dumps that the deck ended (its file is whole then), and opens new ones."""
        from demverify.formats.dump import DumpWriter

        known = self.backend._dumps
        for name in [name for name, dump in known.items() if self.setup.dumps.get(name) is not dump.spec]:
            known.pop(name).writer.__exit__(None, None, None)
        for name, spec in self.setup.dumps.items():
            if name not in known:
                writer = self.backend._files.enter_context(DumpWriter(spec, self.setup.dialect, self.backend._folder))
                known[name] = OpenDump(spec, writer)

    def _write_dump(self, dump: OpenDump, step: int) -> None:
        from demverify.formats.bodies import body_frame
        from demverify.formats.columns import snapshot_frame

        spec = dump.spec
        if step != dump.last and (step % spec.every == 0 or (spec.first and dump.last < 0)):
            if spec.style == "local":
                dump.writer.write(body_frame(step, self._bodies(), spec.columns, self.setup.computes))
            else:
                dump.writer.write(snapshot_frame(self._snapshot(spec.group), spec.columns, spec.place))
            dump.last = step

    def _write_frame(self, step: int) -> None:
        from demverify.engines.instrument import SHAPES
        from demverify.formats.columns import snapshot_frame

        backend, every = self.backend, self.backend._every
        last = step == self.end and not backend._keep  # the engines' dumps, which kept frames are compared with, leave it out
        if every is None or step == backend._last_frame or not (step % every == 0 or last):
            return
        backend._last_frame = step
        snapshot = self._snapshot("all")
        frame = snapshot_frame(snapshot, TRAJECTORY if snapshot.particles.superquadrics is None else [*TRAJECTORY, *SHAPES])
        backend._trajectory.write(frame, self.setup.time)
        if backend._keep:
            backend.outputs.frames.append(frame)
        if backend._budget:
            backend.outputs.budgets.append((step, self.setup.time, self.simulation.energy_budget()))

    def _bring_back(self) -> None:
        """The deck sees the particles, the box and the time of the simulation."""
        from demverify.deck.setup import Atoms

        setup, simulation, p = self.setup, self.simulation, self.meter.particles
        assert setup.atoms is not None
        molecule, mass = setup.atoms.molecule, setup.atoms.mass  # other rules may have given members of clumps another mass
        if len(p.id) < len(setup.atoms.id):
            stay = np.isin(setup.atoms.id, p.id)
            molecule, mass = molecule[stay], mass[stay]
        setup.atoms = Atoms(p.id, p.type, p.x, p.v, p.omega, p.radius, mass, p.mask, p.image, molecule, p.superquadrics, p.clumps)
        setup.box = simulation.box()
        setup.time += (simulation.step - setup.step) * setup.dt
        setup.step = simulation.step

    def _bodies(self) -> Bodies:
        """The clumps of the present step."""
        from demverify.deck.particles import no_clumps
        from demverify.formats.bodies import Bodies

        sim, p = self.simulation, self.meter.particles
        return Bodies(p.clumps or no_clumps(len(p.id)), sim.box(), *sim.clump_forces())

    def _snapshot(self, group: str) -> Snapshot:
        from demsolver.state import selected
        from demverify.formats.columns import Snapshot

        sim, atoms = self.simulation, self.setup.atoms
        assert atoms is not None
        p, molecule = self.meter.particles, atoms.molecule
        chosen = selected(p.mask, self.setup.groups[group])
        if not chosen.all():
            p, molecule = p.rows(chosen), molecule[chosen]
        force, torque = sim.forces()
        return Snapshot(sim.step, sim.box(), p, force[chosen], torque[chosen], molecule, self.setup.dimension)


def normalised(setup: Setup) -> bool:
    """Whether extensive thermo values are per particle: thermo_modify norm, by default yes for lj units only."""
    return setup.thermo.modify.get("norm", "yes" if setup.units == "lj" else "no") == "yes"
