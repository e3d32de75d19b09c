"""The page, the pictures and the numbers of a study: report.html, which needs nothing else, an svg file a figure, numbers.json, numbers.h5."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from demverify.report.axes import scientific
from demverify.report.charts import write_svg
from demverify.report.json import write_whole
from demverify.report.numbers import write_numbers
from demverify.studies import Claim, Figure, Finding, Study, Table, unexplained

_WORDS = {
    "document": ("Document", "The document states", "Where the document does not say"),
    "theory": ("What is looked at", "What should be", "How it was done"),
}
"""Head of the page, of a table of statements, and of the readings, by who makes the statements."""
_BADGES = {"came out": ("pass", "✓"), "did not come out": ("skipped", "✕"), "unexplained": ("fail", "!")}


def write_study(folder: Path, study: Study, command: str) -> Path:
    """Writes everything into `folder`, which exists; each file whole or not at all. Returns the page."""
    for finding in study.findings:
        for figure in finding.figures:
            write_svg(folder / f"{figure.name}.svg", figure.svg)
    write_whole(folder / "numbers.json", as_json(as_dict(study)))
    write_numbers(folder / "numbers.h5", {finding.title: finding.numbers for finding in study.findings})
    page = folder / "report.html"
    write_whole(page, render(study, command))
    return page


def as_json(what: Any) -> str:
    """The text of a JSON file: arrays are lists, what is not finite is null."""
    return json.dumps(_plain(what), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def as_dict(study: Study) -> dict[str, Any]:
    """The study as plain data: claims and numbers, without pictures."""
    findings = [
        {
            "title": finding.title,
            "claims": [asdict(claim) for claim in finding.claims],
            "tables": [asdict(table) for table in finding.tables],
            "numbers": finding.numbers,
        }
        for finding in study.findings
    ]
    return {"title": study.title, "source": study.source, "readings": study.readings, "findings": findings}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def outcome(claim: Claim) -> str:
    """What became of a statement, in words."""
    return "came out" if claim.came_out else "did not come out" if claim.why else "unexplained"


def summary(study: Study) -> str:
    """How many statements came out, a sentence."""
    claims = [claim for finding in study.findings for claim in finding.claims]
    kept, open_ = sum(claim.came_out for claim in claims), len(unexplained(study))
    told = f"{kept} of {len(claims)} statements came out"
    if kept == len(claims):
        return f"{told}."
    return f"{told}, {len(claims) - kept - open_} did not for the reason given" + (f", {open_} did not and nothing says why." if open_ else ".")


def render(study: Study, command: str) -> str:
    """The page as text. command: what to type to get it again."""
    template = Template(files("demverify.report").joinpath("template.html").read_text(encoding="utf-8"))
    sound = not unexplained(study)
    about, stated, read = _WORDS[study.states]
    return template.substitute(
        eyebrow=escape(command.partition(" --")[0]),
        title=escape(study.title),
        verdict="pass" if sound else "fail",
        sign="✓" if sound else "!",
        word="Every statement came out, or it is known why not" if sound else "Something did not come out, and nothing says why",
        summary=escape(summary(study)),
        body="\n".join([
            _section(about, f'<p class="lead">{escape(study.source)}</p>{_contents(study)}'),
            *(_finding(k, finding, stated) for k, finding in enumerate(study.findings)),
            _section(read, _readings(study)) if study.readings else "",
            _section("Do it again", f"<pre class=command>{escape(command)}</pre>"),
        ]),
    )  # fmt: skip


def _section(title: str, content: str, mark: str = "") -> str:
    return f"<section{mark}><h2>{escape(title)}</h2>{content}</section>"


def _contents(study: Study) -> str:
    """The findings, each with how many of its statements came out."""
    items = "".join(
        f'<li><a href="#finding-{k}">{escape(one.title)}</a><span class="soft">{sum(c.came_out for c in one.claims)} of {len(one.claims)}</span></li>'
        for k, one in enumerate(study.findings)
    )
    return f'<ul class="contents">{items}</ul>'


def _readings(study: Study) -> str:
    return f'<ul class="readings">{"".join(f"<li>{escape(one)}</li>" for one in study.readings)}</ul>'


def _finding(number: int, finding: Finding, stated: str) -> str:
    lead = f'<p class="lead">{escape(finding.set_up)}</p>' if finding.set_up else ""
    rows = "".join(_claim(claim, stated) for claim in finding.claims)
    head = f'<thead><tr><th scope="col">Outcome</th><th scope="col">{stated}</th><th scope="col">What came out</th></tr></thead>'
    claims = f'<div class="table" role="region" aria-label="Statements" tabindex="0"><table class="claims">{head}<tbody>{rows}</tbody></table></div>'
    figures = "".join(map(_figure, finding.figures))
    plots = f'<div class="plots">{figures}</div>' if figures else ""
    return _section(finding.title, lead + claims + plots + "".join(map(_table, finding.tables)), f' id="finding-{number}"')


def _claim(claim: Claim, stated: str) -> str:
    kind, sign = _BADGES[outcome(claim)]
    badge = f'<span class="badge {kind}"><span aria-hidden="true">{sign}</span> {outcome(claim)}</span>'
    ours = '<div class="ours">added here</div>' if claim.whose == "ours" else ""
    why = f'<p class="reason">{escape(claim.why)}</p>' if claim.why and not claim.came_out else ""
    states = f'<td data-label="{"Stated here" if ours else stated}">{escape(claim.states)}{ours}</td>'
    return f'<tr><td>{badge}</td>{states}<td data-label="What came out">{escape(claim.found)}{why}</td></tr>'


def _figure(figure: Figure) -> str:
    return f"<figure>{figure.svg}<figcaption>{escape(figure.caption)}</figcaption></figure>"


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(one)}</th>' for one in table.head)
    rows = "".join(_row(table.head, row) for row in table.rows)
    inner = f"<caption>{escape(table.title)}</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody>"
    return f'<div class="table data" role="region" aria-label="{escape(table.title)}" tabindex="0"><table>{inner}</table></div>'


def _row(head: Sequence[str], row: Sequence[str | float]) -> str:
    named = zip(head[1:], row[1:], strict=True)
    cells = "".join(f'<td class="number" data-label="{escape(name)}">{escape(cell(one))}</td>' for name, one in named)
    return f'<tr><th scope="row">{escape(cell(row[0]))}</th>{cells}</tr>'


def cell(value: str | float) -> str:
    """A cell of a table as text."""
    return value if isinstance(value, str) else scientific(float(value), 3)
