"""The page of the library: cases down, engines across; every cell opens its numbers and its pictures. One file, no network, no script."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from demverify.report import tables
from demverify.report.axes import scientific
from demverify.report.html import entry_list
from demverify.report.json import write_whole
from demverify.report.pictures import gauge

if TYPE_CHECKING:
    from demverify.compare import Check
    from demverify.library import Cell, Verified
    from demverify.report.content import Deviation

SIGNS = {"pass": "✓", "deviation": "≠", "skipped": "–", "fail": "✕"}
WORDS = {"pass": "pass", "deviation": "expected deviation", "skipped": "skipped", "fail": "fail"}


def write_matrix(path: Path, found: Sequence[Verified], columns: Sequence[str], entries: Sequence[Deviation]) -> None:
    """Writes the page, whole or not at all. entries: of the register, for the deviations that cells name."""
    write_whole(path, render(found, columns, entries))


def render(found: Sequence[Verified], columns: Sequence[str], entries: Sequence[Deviation]) -> str:
    """The page as text."""
    cells = [one.cell(engine) for one in found for engine in columns]
    counts = {status: sum(cell.status == status for cell in cells) for status in SIGNS}
    good = not counts["fail"] and bool(counts["pass"])
    told = ", ".join(f"{count} {WORDS[status]}" for status, count in counts.items() if count)
    scenarios = list(dict.fromkeys(one.case.scenario for one in found))
    named = "; ".join(cell.reason for cell in cells if cell.status == "deviation")
    evidence = [entry for entry in entries if entry.id in named]
    style = files("demverify.report").joinpath("matrix.css").read_text(encoding="utf-8")
    return Template(files("demverify.report").joinpath("template.html").read_text(encoding="utf-8")).substitute(
        eyebrow="demverify verify",
        title=f"{len(found)} cases in {len(columns)} engines",
        verdict="pass" if good else "fail",
        word="Every engine does what it should" if good else "Something is off",
        sign=SIGNS["pass" if good else "fail"],
        summary=escape(f"{told}."),
        body=f"<style>{style}</style>" + _failures(found, columns) + "".join(
            _scenario(name, [(k, one) for k, one in enumerate(found) if one.case.scenario == name], columns) for name in scenarios
        ) + _evidence(evidence) + "".join(_detail(k, one, engine) for k, one in enumerate(found) for engine in columns),
    )  # fmt: skip


def _failures(found: Sequence[Verified], columns: Sequence[str]) -> str:
    lines = [
        f'<li>{_button(k, engine, cell)} <b>{escape(one.case.name)}</b>, {engine}: {escape(" ".join(cell.reason.split())[:400])}</li>'
        for k, one in enumerate(found) for engine in columns if (cell := one.cell(engine)).status == "fail"
    ]  # fmt: skip
    return f'<section><h2>What failed</h2><ul class="failed">{"".join(lines)}</ul></section>' if lines else ""


def _scenario(name: str, rows: Sequence[tuple[int, Verified]], columns: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{escape(engine)}</th>' for engine in columns)
    body = "".join(_case_row(k, one, columns) for k, one in rows)
    table = f'<table class="matrix"><thead><tr><th scope="col">Case</th>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f"<section><h2>{escape(name[:1].upper() + name[1:] or 'Cases')}</h2>{table}</section>"


def _case_row(k: int, one: Verified, columns: Sequence[str]) -> str:
    cells = "".join(f"<td>{_button(k, engine, one.cell(engine))}</td>" for engine in columns)
    return f'<tr><th scope="row">{escape(one.case.name)}<span class="soft">{escape(one.case.title)}</span></th>{cells}</tr>'


def _button(k: int, engine: str, cell: Cell) -> str:
    label = f"{engine}: {WORDS[cell.status]}"
    return f'<button class="cell {cell.status}" popovertarget="c{k}-{engine}" aria-label="{label}" title="{label}">{SIGNS[cell.status]}</button>'


def _detail(k: int, one: Verified, engine: str) -> str:
    """What a cell opens."""
    cell, case = one.cell(engine), one.case
    infos = [info for label, info in one.engines.items() if label.startswith(engine)]
    version = f" {escape(infos[0].version)}" if infos and infos[0].version else ""
    laws = "".join(f"<li><b>{escape(law.name)}</b>, within {law.tolerance:g}: {escape(law.reason)}</li>" for law in case.laws)
    close = f'<button popovertarget="c{k}-{engine}" popovertargetaction="hide" class="close" aria-label="close">×</button>'
    parts = [
        f'<header><p class="soft">{escape(case.name)}, {engine}{version}</p><h3>{escape(case.title)}</h3>{close}</header>',
        f'<p><span class="badge {cell.status}">{SIGNS[cell.status]} {WORDS[cell.status]}</span> {escape(" ".join(cell.reason.split())[:600])}</p>',
        f"<p>{escape(case.what)}</p>" if case.what else "",
        f'<p class="soft">Source: {escape(case.source)}</p>' if case.source else "",
        _numbers(cell.checks),
        f'<div class="plots">{_figures(one.pictures[engine])}</div>' if one.pictures.get(engine) else "",
        f'<h4>Closed forms</h4><ul class="soft">{laws}</ul>' if laws else "",
        f'<p><a href="{escape(one.page)}">The whole report of this case</a></p>' if one.page else "",
    ]
    return f'<div popover id="c{k}-{engine}" class="detail">{"".join(parts)}</div>'


def _numbers(checks: Sequence[Check]) -> str:
    """One row a pair and quantity, the step nearest to its limit, closed forms first; of engines that agree one row a pair."""
    rows: dict[tuple[str, tuple[str, str], str], Check] = {}
    among: dict[object, set[str]] = {}
    for check in checks:
        good = check.kind == "engine" and check.outcome == "pass"
        key = check.kind, check.engines, "" if good else check.quantity
        among.setdefault(key, set()).add(check.quantity)
        rows[key] = max((check, rows.get(key, check)), key=lambda c: (c.outcome in ("fail", "crashed"), c.closeness))
    more = {id(check): f" (of {len(among[key])})" if not key[2] and len(among[key]) > 1 else "" for key, check in rows.items()}
    ordered = sorted(rows.values(), key=lambda c: (c.kind != "law", c.outcome in ("pass", "skipped")))
    body = "".join(
        f'<tr><td class="{c.outcome}">{tables.SIGNS[c.outcome]}</td><td>{escape(c.quantity + more[id(c)])}</td><td>{" - ".join(c.engines)}</td>'
        f"<td>{c.step}</td><td>{scientific(c.max_rel)}</td><td>{scientific(c.tolerance)}</td><td>{gauge(c.max_rel, c.tolerance, c.outcome)}</td></tr>"
        for c in ordered
    )
    head = "".join(f"<th>{name}</th>" for name in ("", "quantity", "of", "step", "relative", "limit", "against the limit"))
    return f'<div class="table"><table class="numbers"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>' if rows else ""


def _figures(pictures: Sequence[str]) -> str:
    return "".join(f"<figure>{picture}</figure>" for picture in pictures)


def _evidence(entries: Sequence[Deviation]) -> str:
    return f"<section><h2>Expected deviations</h2>{entry_list(entries)}</section>" if entries else ""
