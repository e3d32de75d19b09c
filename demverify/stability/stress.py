"""Stress: what becomes of the scenes of inputs/stress in the native solver, LAMMPS and LIGGGHTS, and of random scenes in the native solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from html import escape
from typing import Any

from demverify.cases import DECKS, Case
from demverify.stability.stress_random import LAWS, STEPS, Ran, draws, try_draw
from demverify.stability.stress_scenes import ENGINES, OUTCOMES, Found, Outcome, quick, scenes, try_scene
from demverify.studies import Claim, Figure, Finding, Progress, Table

RANDOM, RANDOM_QUICK, SEED = 1_000, 50, 7
QUICK_ENGINES = ("native", "lammps", "liggghts")
GOOD: tuple[Outcome, ...] = ("stayed", "refused", "warned")
"""What may become of a scene in the native solver."""
_SHOWN = {  # outcome -> class of the line, path of the mark about 0 0
    "stayed": ("b2", "m-2.6 0a2.6 2.6 0 1 0 5.2 0a2.6 2.6 0 1 0 -5.2 0z"),
    "refused": ("b0", "m-2.3 -2.3h4.6v4.6h-4.6z"),
    "warned": ("b4", "m0 -3.1l2.9 5h-5.8z"),
    "lied": ("b1", "m-2.8 -2.8l5.6 5.6m0 -5.6l-5.6 5.6"),
    "crashed": ("b3", "m-3.2 0h6.4m-3.2 -3.2v6.4"),
    "skipped": ("b5", "m-1.5 0h3"),
}
_LEFT, _COLUMN, _ROW, _PITCH, _TOP = 92, 175, 17, 8.6, 60


def stress(quick_run: bool, progress: Progress) -> tuple[Finding, ...]:
    """Both findings. quick_run: 100,000 steps of the resting contact in the place of 10,000,000, the native solver on LAMMPS' decks only, 50 random
    scenes with linear springs in the place of 1,000."""
    scenic = on_scenes(quick_run, lambda what, share: progress(what, 0.7 * share))
    return scenic, at_random(quick_run, lambda what, share: progress(what, 0.7 + 0.3 * share))


def on_scenes(quick_run: bool, progress: Progress) -> Finding:
    """Every stress scene in every engine."""
    engines = QUICK_ENGINES if quick_run else ENGINES
    cases = [quick(case) if quick_run else case for case in scenes()]
    found = _all_outcomes(cases, engines, progress)
    native = [one for one in found if one.engine.startswith("native")]
    claims = (
        _of_native(native, "scene"),
        Claim(
            "A native run that is not within its stated error of the closed form has said so, or has not been made.",
            _counted([one.outcome for one in native]), all(one.outcome in GOOD for one in native), whose="ours",
        ),
    )  # fmt: skip
    return Finding(
        "Stress scenes", claims,
        "Each scene is a variant of a case in inputs/stress: two decks and the closed form or conservation law that it must meet, with the stated "
        "error. " + "; ".join(f"{word}: {means}" for word, means in MEANINGS.items()) + ".",
        (Figure("stress", "One mark a variant, in the order of the table.", picture(found, engines)),),
        (tally(found, engines), listing(found, engines)), {"outcomes": [asdict(one) for one in found]},
    )  # fmt: skip


def _all_outcomes(cases: Sequence[Case], engines: Sequence[str], progress: Progress) -> list[Found]:
    """By scene, then by engine. LAMMPS and LIGGGHTS are processes of their own: they run beside the native solver."""
    known: dict[tuple[str, str], Found] = {}
    with ThreadPoolExecutor(1) as pool:
        others = {(case.name, engine): pool.submit(try_scene, case, engine) for engine in engines if engine in DECKS for case in cases}
        try:
            for n, engine in enumerate(one for one in engines if one not in DECKS):
                for k, case in enumerate(cases):
                    progress(f"{case.name} in {engine}", (n + k / len(cases)) / len(engines))
                    known[case.name, engine] = try_scene(case, engine)
            for (name, engine), result in others.items():
                progress(f"{name} in {engine}", len(known) / len(cases) / len(engines))
                known[name, engine] = result.result()
        finally:
            pool.shutdown(cancel_futures=True)
    return [known[case.name, engine] for case in cases for engine in engines]


MEANINGS = {
    "stayed": "within the stated error", "refused": "an error, before or when it went wrong", "warned": "wrong, and told",
    "lied": "wrong, and nothing was said", "crashed": "a signal, a time limit or a traceback",
}  # fmt: skip


def _of_native(found: Sequence[Found | Ran], what: str) -> Claim:
    bad = [one for one in found if one.outcome not in GOOD]
    names = ", ".join(_name(one) for one in bad[:5])
    return Claim(
        f"No {what} makes the native solver lie or crash.",
        f"{len(found) - len(bad)} of {len(found)} stayed, were refused or warned of{f'; not {names}' if bad else ''}.", not bad, whose="ours",
    )  # fmt: skip


def _name(one: Found | Ran) -> str:
    return f"{one.scene} ({one.outcome})" if isinstance(one, Found) else f"seed {one.draw.seed} ({one.outcome}: {one.message})"


def _counted(outcomes: Sequence[str]) -> str:
    return ", ".join(f"{outcomes.count(word)} {word}" for word in OUTCOMES if word in outcomes) + "."


def tally(found: Sequence[Found], engines: Sequence[str]) -> Table:
    """Outcomes by engine."""
    rows = tuple((engine, *(f"{sum(one.engine == engine and one.outcome == word for one in found)}" for word in OUTCOMES[:-1])) for engine in engines)
    return Table("Who stays, who lies, who crashes", ("engine", *OUTCOMES[:-1]), rows)


def listing(found: Sequence[Found], engines: Sequence[str]) -> Table:
    """Every scene with its outcomes and the first thing that was said or is wrong."""
    known = {(one.scene, one.engine): one for one in found}
    rows = []
    for scene in dict.fromkeys(one.scene for one in found):
        row = [known[scene, engine] for engine in engines]
        rows.append((scene, *(one.outcome for one in row), next((f"{one.engine}: {one.message}" for one in row if one.message), "")))
    return Table("Scenes", ("scene", *engines, "what was said, or is wrong"), tuple(rows))


def picture(found: Sequence[Found], engines: Sequence[str]) -> str:
    """Scenes down, engines across, a mark for each variant: shape and colour are its outcome."""
    folders = list(dict.fromkeys(one.scene.partition(":")[0] for one in found))
    width, height = _LEFT + _COLUMN * len(engines), _TOP + _ROW * len(folders)
    parts = [f'<text class="head" x="0" y="12">stress scenes</text>{_key()}']
    for n, engine in enumerate(engines):
        parts.append(f'<text class="tick" x="{_LEFT + n * _COLUMN}" y="{_TOP - 14}">{escape(engine)}</text>')
    for k, folder in enumerate(folders):
        y = _TOP + k * _ROW
        parts.append(f'<path class="grid" d="M0 {y + 7}H{width}"/><text class="tick" x="0" y="{y + 3}">{escape(folder)}</text>')
        for n, engine in enumerate(engines):
            variants = [one for one in found if one.engine == engine and one.scene.partition(":")[0] == folder]
            parts += [_mark(one.outcome, _LEFT + n * _COLUMN + 4 + m * _PITCH, y, f"{one.scene}: {one.outcome}") for m, one in enumerate(variants)]
    label = "; ".join(f"{engine}: {_counted([one.outcome for one in found if one.engine == engine])}" for engine in engines)
    return f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'


def _key() -> str:
    return "".join(
        _mark(word, 4 + 66 * k, 24, word) + f'<text class="tier" x="{11 + 66 * k}" y="27">{word}</text>' for k, word in enumerate(OUTCOMES[:-1])
    )


def _mark(outcome: str, x: float, y: float, title: str) -> str:
    style, path = _SHOWN[outcome]
    return f'<path class="{style}" fill="none" stroke-width="1.4" d="M{x:.1f} {y:.1f}{path}"><title>{escape(title)}</title></path>'


def at_random(quick_run: bool, progress: Progress) -> Finding:
    """Random scenes in the native solver."""
    count = RANDOM_QUICK if quick_run else RANDOM
    ran: list[Ran] = []
    for k, draw in enumerate(draws(count, SEED, LAWS[:1] if quick_run else LAWS)):
        progress(f"random scene {k + 1} of {count}", k / count)
        ran.append(try_draw(draw))
    stayed = [one for one in ran if one.outcome == "stayed"]
    worst = max((one.growth for one in stayed), default=0.0), max((one.drift for one in stayed), default=0.0)
    claims = (
        _of_native(ran, "random scene"),
        Claim(
            "Runs that go through end with an energy and a momentum within their bounds.",
            f"{len(stayed)} runs: energy grew by at most {worst[0]:.2g} of what it may, momentum drifted by at most {worst[1]:.2g} of its rounding.",
            max(worst) <= 1.0, whose="ours",
        ),
    )  # fmt: skip
    return Finding(
        f"{count} random scenes", claims,
        f"2 to 40 spheres, sizes over a factor of 30, densities of 1000, {'linear' if quick_run else 'linear or Hertz'} springs over ten "
        "decades, damping up to twice critical, friction 0.01 to 100, steps from 0.003 to 5 of the limit of the lightest contact, speeds from "
        f"1e-6 to 3 radii a step, walls and gravity or a periodic box; {STEPS} steps each. Energy is computed beside the solver: kinetic and "
        "normal elastic. It may grow by what it was at the start (and what gravity gave): that much the guard lets pass; momentum, in the periodic "
        "ones, by 1e-15 a step and particle.",
        tables=(_reasons(ran),),
        numbers={"outcomes": [(known := asdict(one)).pop("draw") | known for one in ran]},
    )  # fmt: skip


_KINDS: Mapping[str, Callable[[str], bool]] = {
    "too fast": lambda text: "of its radius in step" in text,
    "too deep": lambda text: "overlap" in text,
    "energy": lambda text: "the energy grew" in text,
    "flew through the periodic box": lambda text: "flew through" in text,
    "left the box": lambda text: "left the box" in text,
    "step above a limit": lambda text: "stability limit" in text,
}


def _reasons(ran: Sequence[Ran]) -> Table:
    rows: list[tuple[Any, ...]] = [("stayed, nothing said", f"{sum(one.outcome == 'stayed' and not one.message for one in ran)}")]
    told = [one for one in ran if one.message]
    for kind, fits in _KINDS.items():
        chosen = [one for one in told if fits(one.message.partition(";")[0])]
        rows.append((kind, f"{len(chosen)}"))
        told = [one for one in told if one not in chosen]
    rows.append(("other", f"{len(told)}"))
    return Table("What was said", ("reason", "scenes"), tuple(rows))
