"""Times the engines side by side: `python benchmarks/speed.py [SCENE ...] [--repeats 5] [--quick] [--json FILE] [--markdown]`.

Scenes: chute bed gas column sphere (benchmarks/speed_scenes.py says what they are); all by default, 15 to 20 minutes. The same deck goes through
the native solver with 1 and 2 threads, LAMMPS on 1 core, with 2 ranks and with its OpenMP styles, and through LIGGGHTS, which has rules of its
own, so native runs that deck too. What is timed: whole runs of 1 to 4 s, neighbour lists and thermo output included, as the
engines' own loop times tell; the start of the processes stands apart. The runs take turns, round by round; a rate is the median of its rounds, a
ratio the median of the rounds' ratios. What a second thread brings is measured apart as well, by shorter turns
(speed_turns.py). Peak memory is that of the process (of its ranks together); a Python process with
Numba holds 150 MB before it has a particle.

No figure without the comparison: before the rounds every contender runs the same steps once with frames, and is held against native on the
same deck as `demverify compare` does: every particle at set-up, after up to 200 steps and, while chaos allows, later; energies and the
mean height at the end. Native with 2 threads must give the bits of 1 thread. After each timed run, what it printed is
compared again. A contender that differs has no figure but the reason, and if LAMMPS (LIGGGHTS) on one core differs, native has none
either; the exit status is 1 then.

Compiled loops of the native solver start from an empty cache: "first" is the start of a process that compiles, "start" of one that does not.
--quick: scenes a tenth in size, one round, the cache as it is; to see that all works, in three minutes; its ratios mean little.
"others" says how many cores other programs used meanwhile (Linux): ratios measured beside them mean little, above all for two threads on two
cores, and most of all for OpenMP, whose threads wait spinning. --patience S waits up to S seconds before each run for others to use less than a
tenth of a core.
States that need a run of their own are made once, by LAMMPS (a minute), and kept in DIR.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console
from rich.status import Status
from rich.table import Table

from benchmarks.speed_run import Contender, EngineFailed, Judge, Sample, apart, compared, contenders_of, judge_of, measure, missing, trouble
from benchmarks.speed_scenes import SCENES, Scene
from benchmarks.speed_turns import ONE, TWO, Turns, joined, turns_of
from demverify.compare import Check, summary
from demverify.engines import ENGINES
from demverify.engines.base import Found, Job

HEAD = ("contender", "M particle-steps/s", "lowest", "highest", "of LAMMPS", "of native", "peak MB", "start s", "first s", "others")
RATIOS = (
    ("native", "LAMMPS"),
    ("native, LIGGGHTS' rules", "LIGGGHTS"),
    ("native, 2 threads", "native"),
    ("native, 2 threads", "LAMMPS, 2 ranks"),
    ("native, 2 threads", "LAMMPS, omp, 2 threads"),
    ("native", "native, with friction"),
    ("native", "native, friction and a field of 0"),
    ("native, with friction", "LAMMPS, with friction"),
)


@dataclass
class Row:
    """What was found of a contender. first_s: start of a process that compiles, native only. apart: how far from native. trouble: why it has no
    figure; skipped: for want of an engine."""

    contender: Contender
    samples: list[Sample] = field(default_factory=list)
    first_s: float | None = None
    checks: list[Check] = field(default_factory=list)
    apart: str = ""
    trouble: str = ""
    skipped: bool = False

    @property
    def rates(self) -> list[float]:
        """Particle steps per second, round by round; none without a passed comparison."""
        return [] if self.trouble else [sample.rate for sample in self.samples]


@dataclass
class Result:
    """A scene and its rows, by label. pairs: listed and touching, at the end. turns: of one and two threads, round by round."""

    scene: Scene
    rows: dict[str, Row]
    pairs: tuple[int, int] = (0, 0)
    turns: list[Turns] = field(default_factory=list)

    def ratio(self, above: str, below: str) -> float | None:
        """Median of the rounds' ratios of two rates; None where one has no figure."""
        found = [self.rows[label].rates if label in self.rows else [] for label in (above, below)]
        return median(a / b for a, b in zip(*found, strict=True)) if all(found) else None


def measured(
    scene: Scene, contenders: Sequence[Contender], repeats: int, folder: Path, status: Status, patience: float = 0.0
) -> Result:
    """Compares, then times a scene."""
    paths = scene.write(folder)
    result = Result(scene, {one.label: Row(one, trouble=(why := missing(one)), skipped=bool(why)) for one in contenders})
    say = _Say(status, scene.name)
    for row in result.rows.values():
        if row.contender.engine == "native":
            say(f"{row.contender.label}: compiles")
            _guarded(_first, row, scene, paths, folder)
    found = _judged(result, paths, folder, say)
    _no_figure_alone(result)
    for k in range(repeats):
        for label, row in result.rows.items():
            if not row.trouble:
                say(f"round {k + 1} of {repeats}, {label}")
                job = row.contender.job(paths, folder / "timed", scene)
                _guarded(_sample, row, job, scene, found[row.contender.twin], patience)
        if TWO in result.rows and not any(result.rows[label].trouble for label in (ONE, TWO)):
            say(f"round {k + 1} of {repeats}, one and two threads by turns")
            _guarded(_turns, result.rows[TWO], result, paths, folder, patience)
    _no_figure_alone(result)
    return result


class _Say:
    """Shows what is going on."""

    def __init__(self, status: Status, scene: str) -> None:
        self._status, self._scene = status, scene

    def __call__(self, what: str) -> None:
        self._status.update(f"{self._scene}: {what}")


def _guarded(work: Callable[..., None], row: Row, *rest: Any) -> None:
    """Whatever an engine dies of stands in its row."""
    try:
        work(row, *rest)
    except EngineFailed as error:
        row.trouble = str(error)


def _first(row: Row, scene: Scene, paths: dict[str, Path], folder: Path) -> None:
    row.first_s = measure(row.contender, row.contender.job(paths, folder / "first", scene)).start_s


def _judged(result: Result, paths: dict[str, Path], folder: Path, say: _Say) -> dict[str, Judge]:
    """Judges by label; whoever has one is compared, and whoever has none is in trouble."""
    found: dict[str, Judge] = {}
    for label, row in result.rows.items():
        if label == row.contender.twin and not row.trouble:
            say(f"{label}: one ulp away")
            try:
                found[label] = judge_of(row.contender, result.scene, paths, folder / "judge")
            except EngineFailed as error:
                row.trouble = str(error)
    for label, row in result.rows.items():
        judge = found.get(row.contender.twin)
        if judge and not row.trouble:
            say(f"{label}: comparison")
            row.checks = compared(row.contender, result.scene, paths, folder / "compared", judge)
            row.apart, row.trouble = apart(row.checks, judge), trouble(row.checks)
        row.trouble = row.trouble or ("" if judge else f"not compared: {row.contender.twin} has no figure")
    if found:
        last = next(iter(found.values())).native.frames[-1]
        result.pairs = result.scene.pairs(last.vectors("x", "y", "z"), 2.0 * last.columns["radius"])
    return found


def _no_figure_alone(result: Result) -> None:
    """Native has a figure only where the engine on one core, which comes first after it, agrees."""
    for row in result.rows.values():
        if row.contender.engine == "native" and not row.trouble:
            others = (one for one in result.rows.values() if one.contender.twin == row.contender.twin and one.contender.engine != "native")
            engine = next(others, None)
            if engine is None or engine.trouble:
                row.trouble = f"not compared: {engine.contender.label if engine else 'no engine'} has no figure"
                row.skipped = engine is not None and engine.skipped


def _sample(row: Row, job: Job, scene: Scene, judge: Judge, patience: float) -> None:
    """A timed run, with a look at what it printed."""
    sample = measure(row.contender, job, patience)
    checks = judge.of_thermo(row.contender.label, row.contender.engine, sample.thermo, scene.columns)
    row.samples.append(sample)
    row.checks += checks
    row.trouble = trouble(checks)


def _turns(row: Row, result: Result, paths: dict[str, Path], folder: Path, patience: float) -> None:
    """A round of turns; two threads that part from one have no figure."""
    job = row.contender.job(paths, folder / "turns", result.scene)
    result.turns.append(turns_of(job.deck, job.variables, patience))
    if not result.turns[-1].same:
        row.trouble = "the turns of two threads ended at other bits than those of one"


def cells(result: Result) -> Iterator[tuple[str, ...]]:
    """Rows of the table; short for a contender without a figure."""
    for label, row in result.rows.items():
        if not row.rates:
            yield label, "no figure"
            continue
        twin = row.contender.twin if label != row.contender.twin else "native"
        ratios = (result.ratio(label, "LAMMPS"), result.ratio(label, twin))
        of = [median(getattr(sample, name) for sample in row.samples) for name in ("peak_mb", "start_s", "others")]
        rates = [f"{rate(row.rates) / 1e6:.2f}" for rate in (median, min, max)]
        shown = ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]
        first = "" if row.first_s is None else f"{row.first_s:.1f}"
        yield (label, *rates, *shown, f"{of[0]:.0f}", f"{of[1]:.1f}", first, f"{of[2]:.2f}")


def summed_up(result: Result) -> Iterator[str]:
    """Sentences under a table: why there is no figure, the ratios that matter, what was compared."""
    yield from (f"{label}: no figure: {row.trouble}" for label, row in result.rows.items() if not row.rates)
    shown = [(a, b, result.ratio(a, b)) for a, b in RATIOS]
    yield "; ".join(f"{a} / {b}: {ratio:.2f}" for a, b, ratio in shown if ratio is not None) or "no ratios"
    if result.turns and not result.rows[TWO].trouble:
        yield str(joined(result.turns))
    for label, row in result.rows.items():
        if row.apart:
            yield f"{label}: {summary(row.checks)} {row.apart[0].upper()}{row.apart[1:]}."


def headline(result: Result) -> str:
    """What the scene is."""
    scene, (listed, touching) = result.scene, result.pairs
    many = f"{scene.n} sphere{'s' if scene.n > 1 else ''}"
    return f"{scene.name}: {many}, {scene.title}; {scene.steps} steps; {listed} pairs within the skin, {touching} touch"


def show(result: Result, *, markdown: bool) -> None:
    """Prints a scene to stdout."""
    rows = list(cells(result))
    if markdown:
        print(f"\n{headline(result)}\n\n| {' | '.join(HEAD)} |\n|---{'|---:' * (len(HEAD) - 1)}|")
        print("\n".join(f"| {' | '.join((*row, *[''] * (len(HEAD) - len(row))))} |" for row in rows) + "\n")
        print("\n".join(f"- {line}" for line in summed_up(result)))
        return
    table = Table(title=headline(result), title_justify="left")
    for name in HEAD:
        table.add_column(name, justify="left" if name == HEAD[0] else "right")
    for row in rows:
        table.add_row(*row)
    console = Console(width=max(140, Console().width))
    console.print(table)
    for line in summed_up(result):
        console.print(f"  {line}", highlight=False, markup=False, soft_wrap=True)


def as_json(results: Sequence[Result], repeats: int, *, quick: bool) -> dict[str, Any]:
    """All that was found."""
    found = {name: engine.find() for name, engine in ENGINES.items()}
    return {
        "machine": {"cpu": _cpu(), "cores": os.cpu_count(), "python": platform.python_version()},
        "versions": {name: engine.version for name, engine in found.items() if isinstance(engine, Found)},
        "repeats": repeats,
        "quick": quick,
        "scenes": {result.scene.name: _scene_json(result) for result in results},
    }


def _scene_json(result: Result) -> dict[str, Any]:
    listed, touching = result.pairs
    return {
        "title": result.scene.title, "n": result.scene.n, "steps": result.scene.steps, "listed": listed, "touching": touching,
        "ratios": {f"{a} / {b}": ratio for a, b in RATIOS if (ratio := result.ratio(a, b)) is not None},
        "turns": [{"steps": turns.steps, "ratios": turns.ratios, "apart": turns.apart} for turns in result.turns],
        "contenders": {label: _row_json(row, result) for label, row in result.rows.items()},
    }  # fmt: skip


def _row_json(row: Row, result: Result) -> dict[str, Any]:
    if not row.rates:
        return {"figure": None, "reason": row.trouble, "skipped": row.skipped}
    names, label = ("rate", "loop_s", "start_s", "peak_mb", "others"), row.contender.label
    return {
        "figure": median(row.rates), "of_lammps": result.ratio(label, "LAMMPS"), "of_twin": result.ratio(label, row.contender.twin),
        "twin": row.contender.twin, "first_s": row.first_s, "compared": summary(row.checks), "apart": row.apart,
        "rounds": [{name: getattr(sample, name) for name in names} for sample in row.samples],
    }  # fmt: skip


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor())


def main(words: Sequence[str]) -> int:
    """Measures and prints; 1 when a contender that ran has no figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}")
    parser.add_argument("--repeats", type=int, help="rounds; 5, with --quick 1")
    parser.add_argument("--quick", action="store_true", help="small scenes, to see that all works")
    parser.add_argument("--json", type=Path, help="also write all that was found")
    parser.add_argument("--markdown", action="store_true", help="tables for the documentation")
    parser.add_argument("--patience", type=float, default=0.0, help="seconds to wait for a quiet machine before each run")
    parser.add_argument("--state", type=Path, default=_cache(), help="where states are kept (%(default)s)")
    options = parser.parse_args(words)
    repeats = options.repeats if options.repeats is not None else 1 if options.quick else 5
    if unknown := [name for name in options.scenes if name not in SCENES]:
        parser.error(f"there is no scene {unknown[0]!r}; there are {', '.join(SCENES)}")
    if repeats < 1:
        parser.error(f"--repeats {repeats}: expected 1 or more")
    if options.json and not options.json.parent.is_dir():
        parser.error(f"--json {options.json}: there is no folder {options.json.parent}")
    results, console = [], Console(stderr=True)
    with tempfile.TemporaryDirectory() as scratch, console.status("") as status:
        if not options.quick:  # before anything imports Numba
            os.environ["NUMBA_CACHE_DIR"] = f"{scratch}/numba"
        for name in options.scenes or SCENES:
            status.update(f"{name}: makes its state")
            scene = SCENES[name](options.state, small=options.quick)
            results.append(measured(scene, contenders_of(scene), repeats, Path(scratch) / name, status, options.patience))
            show(results[-1], markdown=options.markdown)
    if options.json:
        options.json.write_text(json.dumps(as_json(results, repeats, quick=options.quick), indent=1) + "\n")
    return int(any(row.trouble and not row.skipped for result in results for row in result.rows.values()))


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "demverify" / "speed"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
