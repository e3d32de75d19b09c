"""What came of the library for continuous integration: JUnit XML, and a summary in markdown for a GitHub step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from demverify.compare import nearest
from demverify.report.axes import scientific

if TYPE_CHECKING:
    from demverify.library import Verified

SIGNS = {"pass": "✅", "deviation": "🟨", "skipped": "➖", "fail": "❌"}
MOST_TOLD = 40  # failures: a step's summary has a megabyte


def junit(found: Sequence[Verified], columns: Sequence[str]) -> str:
    """One test case for each case and engine, in a suite for each scenario; a deviation is a pass with its evidence in system-out."""
    root = ET.Element("testsuites", name="demverify")
    for scenario in dict.fromkeys(one.case.scenario for one in found):
        own = [one for one in found if one.case.scenario == scenario]
        cells = [(one, engine, one.cell(engine)) for one in own for engine in columns]
        counts = {status: sum(cell.status == status for _, _, cell in cells) for status in SIGNS}
        seconds = sum(one.seconds for one in own)
        suite = ET.SubElement(
            root, "testsuite", name=scenario or "cases", tests=f"{len(cells)}", failures=f"{counts['fail']}", errors="0",
            skipped=f"{counts['skipped']}", time=f"{seconds:.3f}",
        )  # fmt: skip
        for one, engine, cell in cells:
            name = f"{one.case.name}[{engine}]"
            case = ET.SubElement(suite, "testcase", classname=scenario or "cases", name=name, time=f"{one.seconds / len(columns):.3f}")
            if cell.status == "fail":
                ET.SubElement(case, "failure", message=_plain(cell.reason.splitlines()[0])).text = _plain(cell.reason)
            elif cell.status == "skipped":
                ET.SubElement(case, "skipped", message=_plain(cell.reason))
            elif cell.reason:
                ET.SubElement(case, "system-out").text = _plain(cell.reason)
    ET.indent(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _plain(text: str) -> str:
    """Without the characters that XML cannot hold: an engine's log may have any."""
    return "".join(c for c in text if c in "\t\n" or " " <= c <= "\ud7ff" or "\ue000" <= c <= "\ufffd" or c >= "\U00010000")


def markdown(found: Sequence[Verified], columns: Sequence[str]) -> str:
    """Counts, failures, and the matrix by scenario, folded."""
    cells = [(one, engine, one.cell(engine)) for one in found for engine in columns]
    counts = [f"{sum(cell.status == status for _, _, cell in cells)} {sign} {status}" for status, sign in SIGNS.items()]
    lines = [f"### demverify: {len(found)} cases in {len(columns)} engines", "", ", ".join(counts), ""]
    failed = [(one, engine, cell) for one, engine, cell in cells if cell.status == "fail"]
    lines += [f"- ❌ `{one.case.name}` {engine}: {_one_line(cell.reason)}" for one, engine, cell in failed[:MOST_TOLD]]
    lines += [f"- and {len(failed) - MOST_TOLD} more"] if len(failed) > MOST_TOLD else []
    head = f"| case | {' | '.join(columns)} | nearest to its limit |"
    lines += ["", "<details><summary>all cases</summary>", "", head, "|---|" + "---|" * (len(columns) + 1)]
    for one in found:
        own = [one.cell(engine) for engine in columns]
        close = nearest(cell.nearest for cell in own if cell.nearest)
        told = f"{close.quantity} {scientific(close.max_rel)} of {scientific(close.tolerance)}" if close else ""
        lines.append(f"| {one.case.name} | {' | '.join(SIGNS[cell.status] for cell in own)} | {told} |")
    return "\n".join([*lines, "", "</details>", ""])


def _one_line(text: str) -> str:
    return " ".join(text.split())[:300].replace("|", "\\|")
