"""A steel ball hits a bed of 25,000 glass beads: `python benchmarks/penetration.py [--steps 2000] [--repeats 3] [--picture FILE.svg] [--json FILE]`.

Case "penetration" of Dosta et al. 2024 (doi:10.1016/j.cpc.2023.109066): beads of 2 mm (M1: E 1 GPa, nu 0.2, 2500 kg/m3), a steel ball of 20 mm
(210 GPa, 0.2, 7200 kg/m3), restitution 0.5 and friction 0.3 between beads, 0.4 and 0.2 with steel, Hertz-Mindlin, step 5e-7 s, g = 9.81 m/s2;
smooth steel planes for the box. The published ball starts at z = 0.06 m with 5 m/s; to see the impact within 2,000 steps (1 ms) it
starts 0.1 mm above the bead that it meets first, as fast as it has become by then: v^2 = 25 m2/s2 + 2 g (0.06 m - z).

Runs: native and LIGGGHTS on one LIGGGHTS deck (`pair_style gran model hertz tangential history`); native and LAMMPS on one LAMMPS deck
(`pair_style granular`: hertz/material, mindlin, coeff_restitution; the materials of a pair as one of the same effective moduli).
Rates are medians of rounds in which the runs take turns, one core each. The ball's height, speed and force are compared every
10 steps: native against each engine must stay within 10 times that engine's own spread (how far two of its runs part from the first when all
positions start one unit in the last place away; largest so far), or 1e-9 of the scale, where there is no spread yet. Scales: the ball's
diameter, its first speed, the largest force. Without that no rate is printed, and the exit status is 1. LAMMPS and LIGGGHTS follow different rules;
how far their balls are apart is shown too. Takes 6 to 10 minutes; a minute with --steps 100 --repeats 1.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
from rich.console import Console
from rich.status import Status
from rich.table import Table

from benchmarks.penetration_decks import BALL, STEP, Floats, data_file, decks, start
from benchmarks.speed_run import Contender, EngineFailed, Sample, measure, missing
from demverify.chaos import FACTOR, nudge
from demverify.compare import TIER2
from demverify.engines.base import Job
from demverify.frames import Thermo

ROWS, NUDGES = 10, 2  # steps between rows of a path; runs that start one unit in the last place away
QUANTITIES = {"z": "height", "vz": "speed", "fz": "force"}
LAMMPS, LIGGGHTS = "LAMMPS", "LIGGGHTS"
CONTENDERS = (
    Contender("native as LIGGGHTS", "native", "liggghts", LIGGGHTS),
    Contender(LIGGGHTS, "liggghts", "liggghts", LIGGGHTS),
    Contender("native", "native", "lammps", LAMMPS),
    Contender(LAMMPS, "lammps", "lammps", LAMMPS),
)
"""In pairs, native and the engine that it is held against: the twin of both."""
HEAD = ("run", "M steps/s", "lowest", "highest", "of engine", "peak MB", "start s", "others", "z, mm", "v, m/s", "top force, N")


@dataclass(frozen=True)
class Flight:
    """The ball over time. step: (k,); values: z, vz, fz -> (k,)."""

    step: Floats
    values: Mapping[str, Floats]

    @classmethod
    def of(cls, thermo: Thermo) -> Flight:
        """As printed: the column `c_z` of LAMMPS, `z` of LIGGGHTS."""
        found = {name: thermo[name if name in thermo.columns else f"c_{name}"] for name in QUANTITIES}
        return cls(thermo["Step"], found)

    def apart(self, other: Flight) -> dict[str, Floats]:
        """Differences over time, relative to the scales of this one. Raises EngineFailed where the steps are not the same."""
        if not np.array_equal(self.step, other.step):
            raise EngineFailed(f"paths over other steps: {len(self.step)} and {len(other.step)} rows")
        scales = {"z": 2.0 * BALL, "vz": np.abs(self.values["vz"]).max(), "fz": np.abs(self.values["fz"]).max()}
        return {name: np.abs(self.values[name] - other.values[name]) / scales[name] for name in QUANTITIES}

    def spread(self, nudged: Sequence[Flight]) -> dict[str, Floats]:
        """How far the run parts from itself, largest so far."""
        found = [self.apart(one) for one in nudged]
        return {name: np.maximum.accumulate(np.max([one[name] for one in found], axis=0)) for name in QUANTITIES}


@dataclass(frozen=True)
class Verdict:
    """Of native against one engine. worst: quantity -> (largest difference, the engine's own spread at the end). trouble: why it failed."""

    worst: Mapping[str, tuple[float, float]]
    trouble: str


def judge(native: Flight, engine: Flight, own: Mapping[str, Floats], label: str) -> Verdict:
    """Whether native stays within the engine's own spread. A number that is not finite does not."""
    found, trouble = engine.apart(native), ""
    for name, values in found.items():
        limit = np.maximum(TIER2, FACTOR * own[name])
        off = np.flatnonzero(~(values <= limit))
        if len(off) and not trouble:
            size = f"{values[off[0]]:.1e} at step {engine.step[off[0]]:.0f}, limit {limit[off[0]]:.0e}"
            trouble = f"the ball's {QUANTITIES[name]} differs from that of {label} by {size}"
    return Verdict({QUANTITIES[name]: (float(values.max()), float(own[name][-1])) for name, values in found.items()}, trouble)


class Bench:
    """Runs in a folder: states and decks as they are (state 0) and nudged (1, 2 ...)."""

    def __init__(self, folder: Path, steps: int, status: Status) -> None:
        self.folder, self.steps, self._status = folder, steps, status
        x, speed = start()
        for k in range(NUDGES + 1):
            place = folder / f"{k}"
            place.mkdir(parents=True)
            (place / "data").write_text(data_file(nudge(x, seed=k) if k else x, speed))
            for name, text in decks().items():
                (place / f"in.{name}").write_text(text)

    def run(self, one: Contender, what: str, *, rows: int, state: int = 0) -> Sample:
        """One run. Raises EngineFailed."""
        self._status.update(f"{one.label}: {what}")
        variables = {"steps": [f"{self.steps}"], "rows": [f"{rows}"]}
        return measure(one, Job(self.folder / f"{state}" / f"in.{one.deck}", self.folder / "run", variables, None, 900.0))

    def flight(self, one: Contender, state: int = 0) -> Flight:
        """The ball's way. Raises EngineFailed."""
        return Flight.of(self.run(one, "one ulp away" if state else "path", rows=ROWS, state=state).thermo)

    def timed(self, one: Contender, what: str, flight: Flight) -> Sample:
        """A run for its rate; it must end where the compared one did, bit for bit. Raises EngineFailed."""
        sample = self.run(one, what, rows=self.steps)
        end, expected = Flight.of(sample.thermo).values["z"][-1], flight.values["z"][-1]
        if end != expected:
            raise EngineFailed(f"{one.label} ended at z = {end!r}, and at {expected!r} when it was compared")
        return sample


@dataclass
class Result:
    """What was found. flights, samples: by label; verdicts: by engine."""

    contenders: Sequence[Contender]
    flights: dict[str, Flight]
    verdicts: dict[str, Verdict]
    samples: dict[str, list[Sample]]

    def stands(self, one: Contender) -> bool:
        """Whether native and its engine agree."""
        return not self.verdicts[one.twin].trouble


def compare_and_time(bench: Bench, contenders: Sequence[Contender], repeats: int) -> Result:
    """First the paths, then rounds of those that agree."""
    result = Result(contenders, {}, {}, {one.label: [] for one in contenders})
    for native, engine in zip(contenders[::2], contenders[1::2], strict=True):
        try:
            result.flights |= {one.label: bench.flight(one) for one in (engine, native)}
            own = result.flights[engine.label].spread([bench.flight(engine, k) for k in range(1, NUDGES + 1)])
            result.verdicts[engine.label] = judge(result.flights[native.label], result.flights[engine.label], own, engine.label)
        except EngineFailed as error:
            result.verdicts[engine.label] = Verdict({}, str(error))
    for k in range(repeats):
        for one in filter(result.stands, contenders):
            try:
                result.samples[one.label].append(bench.timed(one, f"round {k + 1} of {repeats}", result.flights[one.label]))
            except EngineFailed as error:
                result.verdicts[one.twin] = Verdict(result.verdicts[one.twin].worst, str(error))
    return result


def show(result: Result) -> None:
    """Prints rates and paths."""
    table = Table(title="25,001 spheres, M particle-steps/s, one core each", title_justify="left")
    for name in HEAD:
        table.add_column(name, justify="left" if name == HEAD[0] else "right")
    for one in result.contenders:
        table.add_row(*(cells(result, one) if result.stands(one) else (one.label, "no figure")))
    console = Console(width=max(120, Console().width))
    console.print(table)
    for line in sentences(result):
        console.print(f"  {line}", highlight=False, markup=False, soft_wrap=True)


def cells(result: Result, one: Contender) -> tuple[str, ...]:
    """A row of the table."""
    samples, values = result.samples[one.label], result.flights[one.label].values
    rates = [sample.rate for sample in samples]
    ratio = median(rate / other.rate for rate, other in zip(rates, result.samples[one.twin], strict=True))
    of = [median(getattr(sample, name) for sample in samples) for name in ("peak_mb", "start_s", "others")]
    return (
        one.label, *(f"{rate(rates) / 1e6:.2f}" for rate in (median, min, max)), f"{ratio:.2f}", f"{of[0]:.0f}", f"{of[1]:.1f}", f"{of[2]:.2f}",
        f"{1e3 * values['z'][-1]:.4f}", f"{values['vz'][-1]:.5f}", f"{np.abs(values['fz']).max():.1f}",
    )  # fmt: skip


def sentences(result: Result) -> Iterator[str]:
    """What the comparison found."""
    for label, verdict in result.verdicts.items():
        found = [f"{name} {worst:.0e} (one ulp in {label} itself: {own:.0e})" for name, (worst, own) in verdict.worst.items()]
        reason = f". No figure: {verdict.trouble}" if verdict.trouble else ""
        yield f"native against {label}, largest difference: {'; '.join(found) or 'not measured'}{reason}"
    if {LAMMPS, LIGGGHTS} <= result.flights.keys():
        rules = result.flights[LIGGGHTS].apart(result.flights[LAMMPS])
        yield "LAMMPS against LIGGGHTS, whose rules differ: " + "; ".join(f"{QUANTITIES[name]} {values.max():.0e}" for name, values in rules.items())


def picture(file: Path, flights: Mapping[str, Flight]) -> None:
    """Force on the ball over time, all runs. Raises InputError where the file cannot be written."""
    from demverify.report.axes import linear
    from demverify.report.charts import Series, chart, write_svg

    series = [Series(label, 1e3 * STEP * flight.step, flight.values["fz"], style) for style, (label, flight) in enumerate(flights.items())]
    highest, lowest, end = max(one.y.max() for one in series), min(0.0, *(one.y.min() for one in series)), max(one.x.max() for one in series)
    label = f"force on the ball over time, up to {highest:.0f} N"
    title = "Steel ball into a bed of beads: force on the ball"
    write_svg(file, chart(title, label, series, (linear(0.0, float(end)), linear(float(lowest), float(highest))), ("time, ms", "N")))


def as_json(result: Result) -> dict[str, object]:
    """All that was found."""
    names = ("rate", "loop_s", "start_s", "peak_mb", "others")
    agree = [one for one in result.contenders if result.stands(one)]
    flights = result.flights.items()
    return {
        "rounds": {one.label: [{name: getattr(sample, name) for name in names} for sample in result.samples[one.label]] for one in agree},
        "verdicts": {label: {"worst": dict(verdict.worst), "trouble": verdict.trouble} for label, verdict in result.verdicts.items()},
        "paths": {label: {"step": one.step.tolist(), **{name: found.tolist() for name, found in one.values.items()}} for label, one in flights},
    }


def main(words: Sequence[str]) -> int:
    """Measures and prints; 1 when native and an engine that is here do not agree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--repeats", type=int, default=3, help="rounds")
    parser.add_argument("--picture", type=Path, help="an SVG file: the force on the ball")
    parser.add_argument("--json", type=Path, help="also write all that was found")
    options = parser.parse_args(words)
    for name, number, least in (("--steps", options.steps, ROWS), ("--repeats", options.repeats, 1)):
        if number < least:
            parser.error(f"{name} {number}: expected {least} or more")
    for file in filter(None, (options.picture, options.json)):
        if not file.parent.is_dir():
            parser.error(f"{file}: there is no folder {file.parent}")
    absent = {one.label: why for one in CONTENDERS if (why := missing(one))}
    with tempfile.TemporaryDirectory() as scratch, Console(stderr=True).status("") as status:
        bench = Bench(Path(scratch) / "bench", options.steps, status)
        result = compare_and_time(bench, [one for one in CONTENDERS if one.twin not in absent], options.repeats)
    show(result)
    for label, why in absent.items():
        print(f"  {label} skipped: {why}")
    if options.picture and result.flights:
        picture(options.picture, result.flights)
    if options.json:
        options.json.write_text(json.dumps(as_json(result)) + "\n")
    return int(any(verdict.trouble for verdict in result.verdicts.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
