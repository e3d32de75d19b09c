"""The tables of the html report: verdicts, engines, settings. Data in, html out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby

import numpy as np

from demverify.compare import Check, Entry
from demverify.report.axes import DASH, scientific
from demverify.report.content import EngineInfo
from demverify.report.pictures import gauge

ORDER = ("crashed", "fail", "skipped", "pass")
"""Outcomes, worst first; as rows are sorted."""

WORDS = {"pass": "agrees", "fail": "differs", "skipped": "skipped", "crashed": "crashed"}
SIGNS = {"pass": "✓", "fail": "✕", "skipped": DASH, "crashed": "!"}


@dataclass(frozen=True)
class Row:
    """Checks of one pair, tier, quantity and outcome, in order of their steps."""

    checks: tuple[Check, ...]

    @property
    def head(self) -> Check:
        """The first of them: where a difference begins."""
        return self.checks[0]

    @property
    def worst(self) -> Check:
        """The one farthest beyond, or nearest to, its limit."""
        return max(self.checks, key=lambda check: check.closeness)


def badge(outcome: str) -> str:
    """A verdict as sign and word; never as colour alone."""
    return f'<span class="badge {outcome}"><span aria-hidden="true">{SIGNS[outcome]}</span> {WORDS[outcome]}</span>'


def rows(checks: Iterable[Check]) -> list[Row]:
    """Checks gathered into rows: pairs with a failure first, then by tier; in each tier failures first."""
    checks = list(checks)
    spoiled = {(c.kind, c.engines) for c in checks if c.outcome in ("fail", "crashed")}
    order = {pair: k for k, pair in enumerate(dict.fromkeys((c.kind, c.engines) for c in checks))}
    names = {name: k for k, name in enumerate(dict.fromkeys(c.quantity for c in checks))}

    def place(c: Check) -> tuple[bool, int, int, int, int]:
        pair = (c.kind, c.engines)
        return pair not in spoiled, order[pair], c.tier, ORDER.index(c.outcome), names[c.quantity]

    ordered = sorted(checks, key=lambda c: (place(c), c.step))
    return [Row(tuple(group)) for _, group in groupby(ordered, key=place)]


def verdict_table(checks: Sequence[Check], entries: Sequence[Entry]) -> str:
    """The table of verdicts: one body for each pair and tier."""
    bodies = groupby(rows(checks), key=lambda row: (row.head.kind, row.head.engines, row.head.tier))
    head = _head("Verdict", "Quantity", "Steps", "Largest difference", "Relative", "Limit", "Against the limit", "Why")
    return _wrapped("Verdicts", head + "".join(_body(*key, list(group), entries) for key, group in bodies), "verdicts")


def engine_table(engines: Mapping[str, EngineInfo]) -> str:
    """Version, time and speed of every engine; why one did not run."""
    noted = any(info.reason for info in engines.values())
    body = "".join(
        _row(
            f'<th scope="row"><span class="name">{escape(name)}</span></th>',
            _cell("Version", escape(info.version) or DASH),
            _cell("Status", badge_of_engine(info)),
            _cell("Wall time", f"{info.wall_s:.2f} s" if info.wall_s is not None else DASH, "number"),
            _cell("Particle-steps/s", _rate(info.particle_steps_per_s), "number"),
            _cell("Note", f'<span class="log">{escape(info.reason)}</span>' if info.reason else "", "why") if noted else "",
        )
        for name, info in engines.items()
    )
    head = _head("Engine", "Version", "Status", "Wall time", "Particle-steps/s", *(["Note"] if noted else []))
    return _wrapped("Engines", f"{head}<tbody>{body}</tbody>")


def badge_of_engine(info: EngineInfo) -> str:
    """Whether an engine ran, as sign and word."""
    outcome = {"ran": "pass", "skipped": "skipped", "crashed": "crashed"}[info.status]
    return f'<span class="badge {outcome}"><span aria-hidden="true">{SIGNS[outcome]}</span> {info.status}</span>'


def settings_table(head: Sequence[str], settings: Iterable[Sequence[str]]) -> str:
    """Which setting of the deck became what."""
    body = "".join(
        _row(
            f'<th scope="row"><code>{escape(row[0])}</code></th>',
            *(_cell(h, _wording(h, v, head)) for h, v in zip(head[1:], row[1:], strict=True)),
        )
        for row in settings
    )
    return _wrapped("Settings", _head(*map(escape, head)) + f"<tbody>{body}</tbody>")


def pair_cards(checks: Sequence[Check]) -> str:
    """One card a pair of engines: the three tiers, each with its outcome and what came nearest to the limit."""
    pairs = dict.fromkeys((c.kind, c.engines) for c in checks)
    return "".join(_card(kind, engines, [c for c in checks if (c.kind, c.engines) == (kind, engines)]) for kind, engines in pairs)


def overall(checks: Iterable[Check]) -> str:
    """The outcome of many: crashed, then fail, then pass; skipped only if nothing was judged."""
    outcomes = {check.outcome for check in checks}
    return next((o for o in ("crashed", "fail", "pass") if o in outcomes), "skipped")


def as_lines(checks: Iterable[Check]) -> str:
    """Every check, one line each, separated by tabs: for a spreadsheet."""
    head = "outcome\tkind\ttier\tengines\tquantity\tstep\tmax_abs\tmax_rel\ttolerance\treason"
    lines = (
        f"{c.outcome}\t{c.kind}\t{c.tier}\t{c.engines[0]} / {c.engines[1]}\t{c.quantity}\t{c.step}\t"
        f"{c.max_abs:.4g}\t{c.max_rel:.4g}\t{c.tolerance:.4g}\t{' '.join(c.reason.split())}"
        for c in checks
    )
    return escape("\n".join([head, *lines]))


def _card(kind: str, engines: tuple[str, str], checks: Sequence[Check]) -> str:
    tiers = {1: "One state", 2: "Short run", 3: "Long run"} if kind == "engine" else dict.fromkeys((1, 2, 3), "Closed forms")
    lines = "".join(_card_line(tier, tiers[tier], own) for tier in (1, 2, 3) if (own := [c for c in checks if c.tier == tier]))
    if not any(np.isfinite(c.max_rel) or c.outcome == "fail" for c in checks):  # an engine that is missing, or died
        told = escape(_first_line(checks[0].reason))
        lines = f'<div><dd>{badge(overall(checks))}<span class="soft">{told}</span></dd></div>'
    joint = '<span class="versus" aria-label="against">↔</span>'
    title = f"<h3>{escape(engines[0])} {joint} {escape(engines[1])}</h3>"
    return f'<article class="card {overall(checks)}">{title}<dl>{lines}</dl></article>'


def _card_line(tier: int, name: str, checks: Sequence[Check]) -> str:
    outcome = overall(checks)
    shown = Row(tuple(c for c in checks if c.outcome == outcome)).worst
    measured = f"{shown.quantity} {scientific(shown.max_rel)}"
    detail = escape(measured if np.isfinite(shown.max_rel) else _first_line(shown.reason))
    skipped = sum(c.outcome == "skipped" for c in checks)
    also = f", {skipped} of {len(checks)} skipped" if skipped and outcome != "skipped" else ""
    told = f'{badge(outcome)}<span class="soft">{detail}{also}</span>'
    return f'<div><dt>{name} <span class="soft">tier {tier}</span></dt><dd>{told}</dd></div>'


def _first_line(text: str) -> str:
    return text.partition("\n")[0]


def _body(kind: str, engines: tuple[str, str], tier: int, group: Sequence[Row], entries: Sequence[Entry]) -> str:
    name = f"{escape(engines[0])} ↔ {escape(engines[1])}"
    part = "closed form" if kind == "law" else f"tier {tier}"
    head = f'<tr class="group"><th scope="rowgroup" colspan="8">{name} <span class="soft">{part}</span></th></tr>'
    return f"<tbody>{head}{''.join(_verdict_row(row, entries) for row in group)}</tbody>"


def _verdict_row(row: Row, entries: Sequence[Entry]) -> str:
    worst = row.worst
    return _row(
        _cell("Verdict", badge(worst.outcome)),
        f'<th scope="row" class="quantity">{escape(worst.quantity)}</th>',
        _cell("Steps", _steps(row.checks), "number"),
        _cell("Largest difference", scientific(worst.max_abs), "number"),
        _cell("Relative", scientific(worst.max_rel), "number"),
        _cell("Limit", scientific(worst.tolerance), "number"),
        f'<td class="scale">{gauge(worst.max_rel, worst.tolerance, worst.outcome)}</td>',
        _cell("Why", linked(row.head.reason, entries), "why"),
    )


def linked(reason: str, entries: Sequence[Entry]) -> str:
    """A reason as html; a known deviation that it names becomes a link to its entry, which says what it is."""
    text = escape(reason)
    for entry in entries:
        name = f"explained by {escape(entry.id)}"
        text = text.replace(f"{name}: {escape(entry.what)}", f'<a href="#known-{escape(entry.id)}">{name}</a>')
    return text


def _steps(checks: Sequence[Check]) -> str:
    first, last = checks[0].step, checks[-1].step
    return f"{first}" if first == last else f'{first}{DASH}{last} <span class="soft">({len(checks)})</span>'


def _rate(value: float | None) -> str:
    """Particle-steps a second, rounded: 1.2 million."""
    if value is None:
        return DASH
    return next(
        (f"{value / size:.3g} {name}" for size, name in ((1e9, "billion"), (1e6, "million"), (1e3, "thousand")) if value >= size),
        f"{value:.3g}",
    )


def _wording(name: str, value: str, head: Sequence[str]) -> str:
    """What an engine reads is code; what it means is prose."""
    return escape(value) if name == head[-1] else f"<code>{escape(value)}</code>" if value else DASH


def _head(*names: str) -> str:
    return "<thead><tr>" + "".join(f'<th scope="col">{name}</th>' for name in names) + "</tr></thead>"


def _row(*cells: str) -> str:
    return f"<tr>{''.join(cells)}</tr>"


def _cell(label: str, content: str, kind: str = "") -> str:
    return f'<td data-label="{escape(label)}"{f" class={kind}" if kind else ""}>{content}</td>'


def _wrapped(label: str, table: str, kind: str = "") -> str:
    return f'<div class="table" role="region" aria-label="{label}" tabindex="0"><table class="{kind}">{table}</table></div>'
