"""One deck or case, every engine, one verdict: runs what is to be run, hands the frames to `compare`, writes the report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from demverify import laws, register
from demverify.cases import DECKS, FILE, Case, Law, load_case, split_variant
from demverify.chaos import Envelope, nudge
from demverify.compare import KNOWN, TIER2_STEPS, Check, compare_law, compare_series, explain, not_judged, verdict
from demverify.deck.convert import convert
from demverify.deck.setup import Dialect
from demverify.engines import ENGINES
from demverify.engines.base import Job, Progress
from demverify.errors import InputError, Place
from demverify.frames import Frame
from demverify.reference import reference_checks
from demverify.report.content import DifferenceCurve, EnergySeries, EngineInfo, Report, difference_curves
from demverify.rules import under_liggghts_rules
from demverify.runs import Plan, Run, engine_of, execute, frame_interval, native_label, plan

if TYPE_CHECKING:
    from demsolver.guard import OnInstability

DIALECTS: tuple[Dialect, Dialect] = ("lammps", "liggghts")
NO_CHAOS = Envelope(np.zeros(0, dtype=np.int64), {})
"""Excuses nothing."""
SAME_RULES = "native, LIGGGHTS' rules"  # on the LAMMPS deck
NOT_CONVERTED = "not converted"
Watch = Callable[[str], Progress | None]


@dataclass(frozen=True)
class Settings:
    """Of a comparison. engines: those asked for, None for all. accept: ids of the register that the user lives with. thorough: keeps the account of
    energy, and measures the chaos envelope also where no difference asks for it. on_instability, warn: of native runs, as NativeBackend has them."""

    engines: tuple[str, ...] | None = None
    threads: int = 1
    ranks: int = 1
    timeout_s: float = 3600.0
    accept: tuple[str, ...] = ()
    thorough: bool = True
    on_instability: OnInstability = "warn"  # what came out is judged anyway
    warn: Callable[[str], object] | None = None

    def __post_init__(self) -> None:
        """Raises InputError for an id that the register does not have."""
        _known_entries(self.accept)


@dataclass(frozen=True)
class Comparison:
    """What came out: the checks, the runs behind them and the report for people."""

    checks: Sequence[Check]
    runs: Mapping[str, Run]
    report: Report


@dataclass(frozen=True)
class _Work:
    """What all runs of a comparison share. plans: of each deck."""

    case: Case
    plans: Mapping[Dialect, Plan]
    out: Path
    settings: Settings
    watch: Watch

    def job(self, dialect: Dialect, folder: str, every: int | None = None) -> Job:
        """A run of one deck, in a folder of its own. every: steps between frames, by default as the case or the deck's length has it."""
        known, settings = self.plans[dialect], self.settings
        interval = every or self.case.every or frame_interval(known.steps, known.particles)
        return Job(known.deck, self.out / folder, dict(self.case.variables), interval, settings.timeout_s, settings.ranks, settings.threads)

    def native(self, label: str, job: Job, doing: str, **more: Any) -> Run:
        """A run of the native engine. doing: what is shown meanwhile; more: settings of NativeBackend."""
        s = self.settings
        more |= {"budget": s.thorough, "on_instability": s.on_instability, "warn": s.warn}
        return execute("native", label, job, self.watch(doing), keep=True, **more)


def find_case(target: Path, out: Path, variables: Mapping[str, list[str]]) -> tuple[Case, tuple[tuple[str, str, str], ...]]:
    """The case that a folder, FOLDER:VARIANT or a deck means; for a single deck the matching one is written to `out`. Second: the mapped
    settings.

    Raises InputError when there is no such deck or folder.
    """
    if found := split_variant(target):
        case = load_case(*found)
        return replace(case, variables={**case.variables, **variables}), ()
    known = plan(target, variables)
    other: Dialect = "liggghts" if known.dialect == "lammps" else "lammps"
    decks: dict[Dialect, Path] = {known.dialect: target}
    try:
        out.mkdir(parents=True, exist_ok=True)
        written = out / DECKS[other]
        rows = convert(known, other, written).rows
        decks[other] = written
    except InputError as error:
        rows = (("the whole deck", NOT_CONVERTED, error.message),)
    return Case(title=target.name, decks=decks, variables=variables), rows


def known_engines(names: Sequence[str] | None) -> tuple[str, ...] | None:
    """Names of engines as Settings wants them. Raises InputError for one there is not."""
    for name in names or ():
        if name not in ENGINES:
            message = f"engine {name!r} is not one of {', '.join(ENGINES)}"
            raise InputError(message)
    return tuple(names) if names else None


def compare_case(case: Case, out: Path, settings: Settings, watch: Watch, rows: Sequence[tuple[str, str, str]] = ()) -> Comparison:
    """Runs a case in every engine and judges it. Raises InputError for a wrong deck, before anything has run."""
    plans = {dialect: plan(deck, case.variables) for dialect, deck in case.decks.items()}
    _known_entries((*case.accept, *(entry for law in case.laws for entry in law.deviates.values())))
    work, runs = _Work(case, plans, out, settings, watch), dict[str, Run]()
    for dialect in plans:
        runs |= _run_dialect(work, dialect)
    closed = _law_checks(case, runs)  # no matter of chaos: once
    envelopes = _envelopes(work, runs) if settings.thorough else {run.dialect: NO_CHAOS for run in _native(runs)}
    checks = _judged(work, runs, envelopes)
    if not settings.thorough and any(check.outcome == "fail" for check in checks):
        envelopes = _envelopes(work, runs)
        checks = _judged(work, runs, envelopes)
    checks += [*closed, *_unneeded(case, plans, checks), *_not_converted(plans, rows)]
    return Comparison(checks, runs, _report(case, plans, runs, checks, envelopes, rows))


def _judged(work: _Work, runs: Mapping[str, Run], envelopes: Mapping[Dialect, Envelope]) -> list[Check]:
    """Engine against engine, and against what was recorded."""
    checks = [*_without_defects(_pair_checks(work.plans, runs, envelopes), work.case, work.plans), *reference_checks(work.case, runs, envelopes)]
    if not any(check.engines == DIALECTS and check.outcome == "fail" for check in checks):
        return checks
    same = _same_scene(work, runs, envelopes)
    return [*_accepted(checks, same, work.plans, (*work.case.accept, *work.settings.accept)), *same]


def _not_converted(plans: Mapping[Dialect, Plan], rows: Sequence[tuple[str, str, str]]) -> Iterator[Check]:
    """The engine that could not run because its deck could not be written is named with the reason, not left out."""
    for _, _, why in (row for row in rows if row[1] == NOT_CONVERTED):
        first: Dialect = next(iter(plans))
        other: Dialect = "liggghts" if first == "lammps" else "lammps"
        yield not_judged("all", (first, other), "skipped", f"{other} did not run: {why}")


def _known_entries(accepted: Sequence[str]) -> None:
    known = [entry.id for entry in register.load()]
    for name in accepted:
        if name not in known:
            message = f"accepted difference {name!r} is not in the register; it has {', '.join(known)}"
            raise InputError(message)


def _run_dialect(work: _Work, dialect: Dialect) -> dict[str, Run]:
    """The native engine, and the engine whose dialect this is, unless the case is without it."""
    label, asked = native_label(dialect, work.plans), work.settings.engines
    found: dict[str, Run] = {}
    if asked is None or "native" in asked:
        found[label] = work.native(label, work.job(dialect, label), label)
    if dialect not in work.case.without and (asked is None or dialect in asked):
        found[dialect] = execute(dialect, dialect, work.job(dialect, dialect), work.watch(dialect), keep=True)
    return found


def _native(runs: Mapping[str, Run]) -> list[Run]:
    return [run for run in runs.values() if run.outcome.engine == "native"]


def _envelopes(work: _Work, runs: Mapping[str, Run]) -> dict[Dialect, Envelope]:
    """How far each native run parts from the same run that starts one unit in the last place away."""
    found: dict[Dialect, Envelope] = {}
    for run in _native(runs):
        nudged = work.native(run.label, work.job(run.dialect, f"{run.label}-nudged"), f"{run.label} nudged", nudge=nudge)
        found[run.dialect] = Envelope.from_frames(run.frames, nudged.frames)
    return found


def _pair_checks(plans: Mapping[Dialect, Plan], runs: Mapping[str, Run], envelopes: Mapping[Dialect, Envelope]) -> list[Check]:
    checks: list[Check] = []
    for dialect, known in plans.items():
        native = next((run for run in runs.values() if run.outcome.engine == "native" and run.dialect == dialect), None)
        if native and dialect in runs:
            checks += _compare(native, runs[dialect], envelopes.get(dialect), known)
    if "lammps" in runs and "liggghts" in runs:
        checks += _compare(runs["lammps"], runs["liggghts"], envelopes.get("lammps"), plans["lammps"])
    if not checks:
        first, last = next(iter(runs)), list(runs)[-1]
        checks.append(not_judged("all", (first, last), "skipped", "only one engine ran; give a deck that two can run, or install another"))
    return checks


def _without_defects(checks: Sequence[Check], case: Case, plans: Mapping[Dialect, Plan]) -> list[Check]:
    """An engine that must miss a law of the case for a defect must miss the native motion too, which has no defect: that is not judged twice."""
    found = []
    for check in checks:
        names = {engine_of(label) for label in check.engines}
        dialect = next((one for one in DIALECTS if names == {"native", one}), None)
        ids = {law.deviates[dialect] for law in case.laws if dialect in law.deviates} if dialect else set()
        known = [e.id for e in _entries(plans[dialect], check.engines) if e.id in ids and e.kind == "defect"] if dialect else []
        excused = known and (check.outcome, check.kind) == ("fail", "engine") and check.quantity not in ("ids", "steps")
        found.append(replace(check, outcome="skipped", reason=KNOWN + ", ".join(known)) if excused else check)
    return found


def _compare(a: Run, b: Run, envelope: Envelope | None, known: Plan) -> list[Check]:
    engines = (a.label, b.label)
    for run in (a, b):
        if run.outcome.status != "ok":
            outcome: Literal["crashed", "skipped"] = "crashed" if run.outcome.status == "crashed" else "skipped"
            return [not_judged("all", engines, outcome, f"{run.label}: {run.outcome.reason}")]
    checks = compare_series(a.frames, b.frames, engines, envelope)
    return explain(checks, _entries(known, engines))


def _entries(known: Plan, engines: Sequence[str]) -> tuple[register.Entry, ...]:
    """Known deviations between engines (and closed forms: "law") on this deck."""
    names = {engine_of(label) for label in engines}
    return register.applying(known.dialect, register.features_of(known.runs[-1].setup, len(known.runs)), names)


def _same_scene(work: _Work, runs: Mapping[str, Run], envelopes: Mapping[Dialect, Envelope]) -> list[Check]:
    """Whether the two decks describe the same scene: the LAMMPS deck under LIGGGHTS' rules against the LIGGGHTS deck, both native.

    Over the steps of tier 2; nothing where one of the native runs is missing.
    """
    ours, theirs = runs.get("native"), runs.get("native-liggghts")
    if not ours or not theirs or theirs.outcome.status != "ok":
        return []
    every = theirs.frames[1].step - theirs.frames[0].step if len(theirs.frames) > 1 else 1
    rules = partial(under_liggghts_rules, other=work.plans["liggghts"].runs[0].scene)
    job, most = work.job("lammps", "native-rules", every), max(TIER2_STEPS, every)
    swapped = work.native("native", job, "same scene?", rules=rules, most=most)
    last = swapped.frames[-1].step if swapped.frames else -1
    frames = [frame for frame in theirs.frames if frame.step <= last]
    checks = compare_series(swapped.frames, frames, (SAME_RULES, theirs.label), envelopes.get("liggghts"))
    why = "the two decks do not describe the same scene: under the same rules they still differ"
    return [replace(c, reason="; ".join(filter(None, [why, c.reason]))) if c.outcome == "fail" else c for c in checks]


def _accepted(checks: Sequence[Check], same: Sequence[Check], plans: Mapping[Dialect, Plan], accepted: Sequence[str]) -> list[Check]:
    """LAMMPS against LIGGGHTS where the rules alone explain the difference: not judged if the user or the case accepts that, else failed
    with that reason."""
    if not same or any(check.outcome == "fail" for check in same):
        return list(checks)
    lived_with = _lived_with(plans, accepted)
    return [_explained(check, lived_with) if check.engines == DIALECTS else check for check in checks]


def _lived_with(plans: Mapping[Dialect, Plan], accepted: Sequence[str]) -> list[str]:
    """Of the accepted entries those that can explain a difference between LAMMPS and LIGGGHTS on this deck."""
    return [entry.id for entry in _entries(plans["lammps"], DIALECTS) if entry.id in accepted]


def _unneeded(case: Case, plans: Mapping[Dialect, Plan], checks: Sequence[Check]) -> Iterator[Check]:
    """Strict: what the case accepts and what explains no difference fails. Nothing where the two were not compared, or still differ."""
    pair = [check for check in checks if check.engines == DIALECTS]
    if not any(check.outcome == "pass" for check in pair) or any(check.outcome in ("fail", "crashed") for check in pair):
        return
    explaining = _lived_with(plans, case.accept) if any(check.reason.startswith(KNOWN) for check in pair) else []
    if idle := [entry for entry in dict.fromkeys(case.accept) if entry not in explaining]:
        remedy = f"take it out of accept in {case.folder / FILE}" + (", or move it to the variants that need it" if ":" in case.name else "")
        why = f"no difference of {' and '.join(DIALECTS)} in {case.name} is explained by {', '.join(idle)}: {remedy}"
        yield Check("accepted difference", DIALECTS, 0, np.nan, np.nan, 0.0, "fail", why)


def _explained(check: Check, lived_with: Sequence[str]) -> Check:
    if check.outcome != "fail" or not np.isfinite(check.max_rel) or check.quantity in ("ids", "steps"):
        return check
    if lived_with:
        return replace(check, outcome="skipped", reason=KNOWN + ", ".join(lived_with))
    return replace(check, reason=f"{check.reason}; under the same rules the decks do the same")


def _law_checks(case: Case, runs: Mapping[str, Run]) -> list[Check]:
    checks = []
    for law in case.laws:
        for label, run in runs.items():
            if run.outcome.status != "ok":
                checks.append(not_judged(law.name, (label, "closed form"), "skipped", run.outcome.reason))
                continue
            found = [
                compare_law(one.quantity, label, one.measured, one.expected, law.tolerance, one.step, one.scale)
                for one in laws.measure(law.name, run.frames, law.parameters, Place(case.folder / FILE))
            ]
            if entry := _deviation(law, run):
                checks += _deviating(found, law, entry)
            else:
                checks += [c if c.outcome == "pass" else replace(c, reason=f"{law.name}: {law.reason}; {c.reason}") for c in found]
    return checks


def _deviation(law: Law, run: Run) -> register.Entry | None:
    """Why this run must miss a law: what its dialect's engine does; of a convention, native does it too."""
    entry = next((one for one in register.load() if one.id == law.deviates.get(run.dialect)), None)
    return entry if entry and (run.outcome.engine != "native" or entry.kind != "defect") else None


def _deviating(found: Sequence[Check], law: Law, entry: register.Entry) -> list[Check]:
    """Strict: what misses the law is known and accepted; where nothing does, the register is to be mended."""
    if any(check.outcome == "fail" for check in found):
        return [replace(c, outcome="skipped", reason=f"{KNOWN}{entry.id}: {entry.what}") if c.outcome == "fail" else c for c in found]
    why = f"{law.name} holds, though the case says it does not for {entry.id}: mend the case, or the register"
    return [replace(check, outcome="fail", reason=why) for check in found]


def engine_info(run: Run) -> EngineInfo:
    """How an engine fared, for the reports."""
    o = run.outcome
    if o.status != "ok":
        return EngineInfo(o.version, None, None, o.status, o.reason)
    return EngineInfo(o.version, o.wall_s, o.particle_steps_per_s or None)


def _report(
    case: Case,
    plans: Mapping[Dialect, Plan],
    runs: Mapping[str, Run],
    checks: Sequence[Check],
    envelopes: Mapping[Dialect, Envelope],
    rows: Sequence[tuple[str, str, str]],
) -> Report:
    first = next(iter(plans.values()))
    return Report(
        title=case.title,
        verdict=verdict(checks),
        checks=checks,
        engines={label: engine_info(run) for label, run in runs.items()},
        series={label: _energies(run, plans[run.dialect]) for label, run in runs.items() if run.frames},
        differences=difference_curves(check for check in checks if check.engines[0] != SAME_RULES),
        envelope=[curve for dialect, envelope in envelopes.items() for curve in _envelope_curves(dialect, envelope, runs)],
        settings=_settings(plans, rows),
        entries=_entries(first, [*runs, *(["law"] if case.laws else [])]),
        command=f"demverify compare {first.deck.parent if len(case.decks) > 1 and not rows else first.deck}",
    )


def _envelope_curves(dialect: Dialect, envelope: Envelope, runs: Mapping[str, Run]) -> Iterator[DifferenceCurve]:
    label = next(label for label, run in runs.items() if run.outcome.engine == "native" and run.dialect == dialect)
    for quantity, values in envelope.relative.items():
        yield DifferenceCurve((label, f"{label} one ulp away"), quantity, envelope.steps.astype(float), np.asarray(values))


def _energies(run: Run, known: Plan) -> EnergySeries:
    from demsolver.computes import erotate, ke
    from demverify.analysis.meanings import Meanings
    from demverify.analysis.quantities import population_of

    def of(frame: Frame) -> tuple[float, float]:
        return ke(frame.columns["mass"], frame.vectors("vx", "vy", "vz")), erotate(population_of(frame, Meanings(dialect=run.dialect)))

    steps = np.array([frame.step for frame in run.frames], dtype=float)
    energies = np.array([of(frame) for frame in run.frames])
    values: dict[str, Any] = {"ke": energies[:, 0], "erotate": energies[:, 1]}
    if len(run.budgets) == len(run.frames):
        names = (
            "elastic_normal", "elastic_tangential", "elastic_rolling", "gravitational", "damped", "rubbed", "rolled", "dragged", "total",
        )  # fmt: skip
        budget = {name: np.array([getattr(b, name) for _, _, b in run.budgets]) for name in names}
        for name in ("gravitational", "total"):  # from the start on: where its zero lies depends on image flags, which decks may leave out
            budget[name] = budget[name] - run.budgets[0][2].gravitational
        values |= {name.replace("_", " "): series for name, series in budget.items() if np.abs(series).max() > 0.0}
    return EnergySeries(steps, steps * known.setup.dt, values)


def _settings(plans: Mapping[Dialect, Plan], rows: Sequence[tuple[str, str, str]]) -> list[tuple[str, str, str, str]]:
    """Rows (setting, LAMMPS words, LIGGGHTS words, meaning in the scene)."""
    if rows:
        source = next(iter(plans))
        return [("", *((theirs, ours) if source == "lammps" else (ours, theirs)), meaning) for theirs, ours, meaning in rows]
    found: dict[str, dict[str, str]] = {}
    for dialect, known in plans.items():
        for executed in known.interpreter.executed:
            name = executed.words[0]
            key = f"{name} {executed.words[3]}" if name in ("fix", "compute") and len(executed.words) > 3 else name
            if key.split()[0] in ("pair_style", "fix", "compute", "units", "timestep", "neighbor", "neigh_modify", "boundary"):
                line = found.setdefault(key, {})
                line[dialect] = "; ".join(filter(None, [line.get(dialect, ""), executed.text.strip()]))
    scene = next(iter(plans.values())).runs[-1].scene
    return [(key, words.get("lammps", ""), words.get("liggghts", ""), _meaning(key, scene)) for key, words in found.items()]


def _meaning(key: str, scene: Any) -> str:
    """What a setting has become in the scene, where one sentence says it."""
    if key == "pair_style" and scene.pair:
        law = scene.pair
        return f"normal {law.normal}, damping {law.damping}, friction {law.friction}"
    if key == "timestep":
        return f"{scene.timestep:g}"
    if key.endswith("gravity"):
        return ", ".join(str(tuple(round(c, 6) for c in f.acceleration)) for f in scene.forces if hasattr(f, "acceleration"))
    return ""
