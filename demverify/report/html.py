"""The report for people: one html file that needs nothing else, neither network nor script."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from demverify.compare import Check, Tolerances, summary
from demverify.differences import QUANTITIES
from demverify.report import pictures, tables
from demverify.report.content import Deviation, DifferenceCurve, EnergySeries, EngineInfo, Report, difference_curves
from demverify.report.json import write_whole

__all__ = ["DifferenceCurve", "EnergySeries", "EngineInfo", "Report", "difference_curves", "render", "write_report"]


def write_report(path: Path, report: Report, tolerances: Tolerances | None = None) -> None:
    """Write the page to `path`, whole or not at all. Raises OSError if the folder cannot be written."""
    write_whole(path, render(report, tolerances))


def render(report: Report, tolerances: Tolerances | None = None) -> str:
    """The page as text. tolerances: the limits drawn into the pictures of differences."""
    template = Template(files("demverify.report").joinpath("template.html").read_text(encoding="utf-8"))
    return template.substitute(
        eyebrow="demverify compare",
        title=escape(report.title),
        verdict=report.verdict,
        word=_headline(report),
        sign=tables.SIGNS[report.verdict],
        summary=escape(summary(report.checks)),
        body="\n".join(filter(None, _sections(report, tolerances or Tolerances()))),
    )


def _headline(report: Report) -> str:
    """The verdict in three words."""
    words = {
        "pass": "The engines agree",
        "fail": "The engines differ",
        "crashed": "An engine crashed",
        "skipped": "Nothing was judged",
    }
    return words[tables.overall(report.checks)]


def _sections(report: Report, tolerances: Tolerances) -> list[str]:
    return [
        _section("Pair by pair", f'<div class="cards">{tables.pair_cards(report.checks)}</div>' if report.checks else ""),
        _section("Engines", tables.engine_table(report.engines) if report.engines else ""),
        _section("Differences over time", _differences(report, tolerances), _DIFFERENCES),
        _section(
            "Energies", _energies(report), "Where the engines agree, their lines lie on one another: broad, narrow, dashed."
        ),
        _section("Verdicts", tables.verdict_table(report.checks, report.entries) if report.checks else "", _VERDICTS),
        _section("Known deviations", _entries(report)),
        _section(
            "What each setting became", tables.settings_table(report.settings_head, report.settings) if report.settings else ""
        ),
        _section("Do it again", f"<pre class=command>{escape(report.command)}</pre>" if report.command else ""),
        _section("Every check", _every_check(report)),
    ]


_DIFFERENCES = """Relative to the largest value so far; the foot of each picture is 0. Grey: how far the native run parts from
itself when it starts one unit in the last place away. The limit, a thin line, rises to ten times that: a difference below
it is chaos and says nothing."""

_VERDICTS = """Each row gathers the steps of one quantity and shows the one nearest to, or farthest beyond, its limit;
why is told of the first step."""


def _section(title: str, content: str, note: str = "") -> str:
    """A section with its heading, or nothing if there is nothing to show."""
    lead = f'<p class="lead">{note}</p>' if note else ""
    return f"<section><h2>{title}</h2>{lead}{content}</section>" if content else ""


def _differences(report: Report, tolerances: Tolerances) -> str:
    """One picture for each vector quantity that was compared over time, and the legend of all."""
    pairs = list(dict.fromkeys(curve.engines for curve in report.differences))
    plots = []
    for quantity in QUANTITIES:
        curves = {pairs.index(c.engines): c for c in report.differences if c.quantity == quantity and len(c.step)}
        if any(len(curve.step) > 1 for curve in curves.values()):
            envelope = next((c for c in report.envelope if c.quantity == quantity and len(c.step)), None)
            failed = _first_failures(report, quantity)
            plots.append(pictures.difference_picture(quantity, curves, envelope, failed, tolerances))
    legend = [(pictures.swatch(pictures.pair_stroke(k)), " ↔ ".join(pair)) for k, pair in enumerate(pairs)]
    envelope_key = [('<span class="swatch grey"></span>', "one unit in the last place away")] if report.envelope else []
    cross_key = (
        [('<span class="swatch failed">✕</span>', "first beyond the limit")]
        if any(c.outcome == "fail" for c in report.checks)
        else []
    )
    return _plots(plots, [*legend, *envelope_key, *cross_key])


def _first_failures(report: Report, quantity: str) -> list[Check]:
    """Of each pair the first step at which the engines differ in this quantity."""
    failed = [c for c in report.checks if (c.quantity, c.outcome, c.kind) == (quantity, "fail", "engine")]
    first = {c.engines: c for c in sorted(failed, key=lambda c: -c.step)}
    return list(first.values())


def _energies(report: Report) -> str:
    """One picture for each energy that several engines have, and the whole budget of an engine that has more."""
    engines = list(report.series)
    names = list(dict.fromkeys(name for s in report.series.values() if len(s.time) for name in s.values))
    shared = [name for name in names if len(engines) == 1 or sum(name in s.values for s in report.series.values()) > 1]
    plots = [pictures.energy_picture(name, report.series) for name in shared]
    content = _plots(plots, [(pictures.swatch(pictures.engine_stroke(k)), engine) for k, engine in enumerate(engines)])
    return content + "".join(_budget(engine, s, shared) for engine, s in report.series.items() if set(s.values) - set(shared))


def _budget(engine: str, series: EnergySeries, shared: Sequence[str]) -> str:
    """The budget of one engine: what it shares with others first."""
    names = sorted(series.values, key=lambda name: name not in shared)
    if not len(series.time):
        return ""
    legend = [(pictures.swatch(pictures.budget_stroke(k)), name) for k, name in enumerate(names)]
    return f"<h3>Energy budget of {escape(engine)}</h3>" + _plots([pictures.budget_picture(engine, series, names)], legend)


def _plots(plots: Sequence[str], legend: Sequence[tuple[str, str]]) -> str:
    if not plots:
        return ""
    keys = "".join(f"<li>{mark}{escape(text)}</li>" for mark, text in legend)
    drawn = "".join(f"<figure>{plot}</figure>" for plot in plots)
    return f'<ul class="legend">{keys}</ul><div class="plots">{drawn}</div>'


def _entries(report: Report) -> str:
    """The entries of the register that apply."""
    return entry_list(report.entries)


def entry_list(entries: Sequence[Deviation]) -> str:
    """Entries of the register, each under the name that the table of verdicts links to."""
    items = "".join(_entry(entry) for entry in entries)
    return f'<dl class="entries">{items}</dl>' if items else ""


def _entry(entry: Deviation) -> str:
    link, name = escape(entry.link), escape(entry.id)
    where = f'<a href="{link}">{link}</a>' if link.startswith("https://") and " " not in link else link
    owner = f'<span class="soft">{escape(entry.engine)} {escape(entry.version)}</span>'
    told = f'{escape(entry.what)}<p class="soft">{escape(entry.size)}</p><p class="soft">{where}</p>'
    return f'<div id="known-{name}"><dt>{name}<br>{owner}</dt><dd>{told}</dd></div>'


def _every_check(report: Report) -> str:
    count = len(report.checks)
    shown = f"{count} check{'s' if count != 1 else ''}, one a line, separated by tabs"
    return f"<details><summary>{shown}</summary><pre class=all tabindex=0>{tables.as_lines(report.checks)}</pre></details>"
