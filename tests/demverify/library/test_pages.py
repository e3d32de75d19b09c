"""The page of the library in a real browser, and what continuous integration reads."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from demverify import register
from demverify.cases import Case, Law
from demverify.compare import KNOWN, Check
from demverify.library import COLUMNS, Verified
from demverify.report.content import EngineInfo
from demverify.report.junit import junit, markdown
from demverify.report.matrix import render

ENTRY = "lammps-tsuji-restitution"


def check(quantity: str, engines: tuple[str, str], outcome: str, rel: float, reason: str = "", kind: str = "engine") -> Check:
    return Check(quantity, engines, 100, rel, rel, 1e-3, outcome, reason, 1, kind)  # type: ignore[arg-type]


def some() -> list[Verified]:
    """One case of each kind of cell."""
    decks = {dialect: Path("inputs/c") / f"in.{dialect}" for dialect in ("lammps", "liggghts")}
    law = Law("collision_restitution", 1e-3, "order dt <&>", {"restitution": 0.5})
    both = Case("A pair & more <b>", decks, "What it is.", laws=(law,), name="pair:e0.5", scenario="head on", source="doi:10/x")  # type: ignore[arg-type]
    alone = Case("Sticky", {"lammps": decks["lammps"]}, name="sticky", scenario="adhesion", without={"liggghts": "LIGGGHTS has no JKR"})  # type: ignore[dict-item]
    checks = (
        check("restitution", ("native", "closed form"), "pass", 2e-4, kind="law"),
        check("force", ("native", "lammps"), "pass", 1e-12),
        check("restitution", ("lammps", "closed form"), "skipped", 0.2, f"{KNOWN}{ENTRY}: as coded", "law"),
        check("velocity", ("native-liggghts", "liggghts"), "pass", 1e-12),
        check("restitution", ("liggghts", "closed form"), "fail", 0.3, "off \x1b by much", "law"),
    )
    infos = {"native": EngineInfo("0.1", 1.0, 1e5), "lammps": EngineInfo("22 Jul", 1.0, 1e5), "liggghts": EngineInfo("3.8", 1.0, 1e5)}
    picture = '<svg class="plot" viewBox="0 0 420 250" role="img" aria-label="ke"><path d="M0 0L9 9"/></svg>'
    first = Verified(both, checks, {"pass": 3}, infos, {"native": [picture, picture]}, 1.5, "cases/pair/report.html")
    return [first, Verified(alone, checks[1:2], {"pass": 1}, infos)]


def browser() -> str:
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not found:
        if os.environ.get("CI") == "true":
            pytest.fail("no browser on the machine of CI")
        pytest.skip("no Chromium here; install it with: apt-get install chromium")
    return found


PROBE = """<script>
const cell = document.querySelector('button.cell.pass');
const page = [document.documentElement.scrollWidth, innerWidth];
cell.click();
const open = document.querySelectorAll(':popover-open');
const box = open.length ? open[0].getBoundingClientRect() : {left: -1, right: 1e9};
const found = {
  cells: document.querySelectorAll('.matrix button.cell').length, opened: open.length, id: open.length ? open[0].id : '',
  numbers: open.length ? open[0].querySelectorAll('.numbers tbody tr').length : 0,
  pictures: open.length ? [...open[0].querySelectorAll('svg.plot')].filter(p => p.getBoundingClientRect().height > 50).length : 0,
  fits: page[0] <= page[1] && box.left >= 0 && box.right <= innerWidth, dark: getComputedStyle(document.body).backgroundColor,
  fetched: performance.getEntriesByType('resource').length,
};
if (open.length) { open[0].querySelector('.close').click(); found.closed = document.querySelectorAll(':popover-open').length === 0; }
document.title = 'FOUND ' + JSON.stringify(found);
</script></main>"""


def looked_at(page: Path, width: int, *options: str) -> str:
    """The page's title after the probe has clicked a cell."""
    silent = ["--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
    window = [f"--user-data-dir={page.parent / f'browser-{width}'}", f"--window-size={width},800", *options]
    command = [browser(), "--headless", "--no-sandbox", "--disable-gpu", *silent, *window, "--dump-dom", f"file://{page}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    found = re.search(r"<title>FOUND (.*?)</title>", done.stdout)
    assert found, done.stdout[:500]
    return found[1].replace("&quot;", '"')


@pytest.mark.parametrize(("width", "options"), [(1200, ()), (500, ()), (500, ("--force-dark-mode",))])
def test_the_page_in_a_browser(width: int, options: tuple[str, ...], tmp_path: Path) -> None:
    """Law: every case and engine has a cell; a click opens its numbers and pictures, which fit the window, a phone's too; nothing is fetched."""
    page = tmp_path / "index.html"
    page.write_text(render(some(), COLUMNS, register.load()).replace("</main>", PROBE), encoding="utf-8")
    found = json.loads(looked_at(page, width, *options))
    assert found["cells"] == 6
    assert (found["opened"], found["id"], found["closed"]) == (1, "c0-native", True)
    assert (found["numbers"], found["pictures"]) == (3, 2)
    assert found["fits"]
    assert found["fetched"] == 0
    lightness = sum(int(part) for part in re.findall(r"\d+", found["dark"])[:3])
    assert (lightness < 200) == ("--force-dark-mode" in options)


def test_the_page_says_what_is_off() -> None:
    """Law: failures stand on top with their reason, deviations with the entry of the register, skipped cells with why; names are escaped."""
    text = render(some(), COLUMNS, register.load())
    assert "What failed" in text
    assert "off \x1b by much" in text
    assert f"<dt>{ENTRY}" in text
    assert "LIGGGHTS has no JKR" in text
    assert "A pair &amp; more &lt;b&gt;" in text
    assert "Something is off" in text
    assert "Every engine does what it should" in render(some()[1:], COLUMNS, register.load())


def test_junit() -> None:
    """Law: a test case for each cell: failures fail, skipped are skipped with the reason, a deviation passes with its evidence; it is XML."""
    root = ET.fromstring(junit(some(), COLUMNS))
    cases = {case.get("name"): case for case in root.iter("testcase")}
    assert len(cases) == 6
    assert cases["pair:e0.5[liggghts]"].find("failure") is not None
    assert ENTRY in cases["pair:e0.5[lammps]"].findtext("system-out", "")
    assert cases["sticky[liggghts]"].find("skipped").get("message") == "LIGGGHTS has no JKR"  # type: ignore[union-attr]
    assert [(suite.get("tests"), suite.get("failures"), suite.get("skipped")) for suite in root] == [("3", "1", "0"), ("3", "0", "1")]


def test_the_summary_of_a_step() -> None:
    """Law: counts, each failure, and a row for every case."""
    text = markdown(some(), COLUMNS)
    assert "3 ✅ pass, 1 🟨 deviation, 1 ➖ skipped, 1 ❌ fail" in text
    assert "- ❌ `pair:e0.5` liggghts:" in text
    assert "| sticky | ✅ | ✅ | ➖ | force 10⁻¹² of 10⁻³ |" in text
