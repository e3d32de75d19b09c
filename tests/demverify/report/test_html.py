"""The html report: one file, nothing fetched, every check on it, nothing told by colour alone."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from demverify.compare import Check, Tolerances
from demverify.report import tables
from demverify.report.html import EnergySeries, difference_curves, render, write_report

VOID = {"meta", "br", "hr", "img", "input", "link"}
SHAPES = {"path", "line", "circle"}


class Page(HTMLParser):
    """Collects tags and text, and insists that what opens closes."""

    def __init__(self, text):
        """Read a page."""
        super().__init__()
        self.open, self.tags, self.ids = [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        """Note a tag."""
        self.tags.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Note a tag that closes itself."""
        assert tag in SHAPES
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """What closes is what opened last."""
        assert self.open.pop() == tag

    def all(self, name):
        """The attributes of every tag of this name."""
        return [attrs for tag, attrs in self.tags if tag == name]


def text_of(page):
    """What is read: no tags, no style."""
    return unescape(re.sub(r"<[^>]+>", " ", re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)))


def test_the_page_is_well_formed_and_its_links_lead_somewhere(any_report):
    """Every tag closes in order, no id occurs twice, and every link inside the page has its target."""
    page = Page(render(any_report))
    assert len(page.ids) == len(set(page.ids))
    inside = {a["href"] for a in page.all("a") if a["href"].startswith("#")}
    assert inside <= {f"#{name}" for name in page.ids}


def test_the_page_fetches_nothing(any_report):
    """No script, style sheet, font, image or frame from anywhere: an address is only where a reader may click."""
    page = render(replace(any_report, command="demverify compare inputs/bed"))
    assert not re.search(
        r"<(script|link|img|iframe|object|embed|image|use|base|form)\b|@import|@font-face|url\(|\bsrc=|srcset=", page
    )
    assert not [value for tag, attrs in Page(page).tags if tag != "a" for value in attrs.values() if value and "://" in value]
    assert not re.search(r"https?://", re.sub(r"<a href=.*?</a>", "", page))


def test_the_page_is_light(any_report):
    """Under half a megabyte for a thousand checks and more."""
    assert len(render(any_report).encode()) < 500_000


def test_every_check_is_on_the_page(any_report):
    """One line a check, with its pair, quantity, step, numbers, outcome and reason."""
    text = unescape(render(any_report))
    for c in any_report.checks:
        numbers = f"{c.max_abs:.4g}\t{c.max_rel:.4g}\t{c.tolerance:.4g}"
        reason = " ".join(c.reason.split())
        assert (
            f"{c.outcome}\t{c.kind}\t{c.tier}\t{c.engines[0]} / {c.engines[1]}\t{c.quantity}\t{c.step}\t{numbers}\t{reason}"
            in text
        )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("passing", "The engines agree"),
        ("chaos", "The engines agree"),
        ("failing", "The engines differ"),
        ("skipped", "The engines agree"),
        ("crashed", "An engine crashed"),
        ("nothing", "Nothing was judged"),
    ],
)
def test_the_banner_says_the_verdict_in_words(reports, name, words):
    """The verdict is a heading in words, and a class that agrees with it."""
    page = render(reports[name])
    assert f'<div class="verdict {reports[name].verdict}" role="status">' in page
    assert f"<strong>{words}</strong>" in page


def test_what_a_user_wrote_is_escaped(reports):
    """Markup in a title, a reason, a setting or a log is shown, not obeyed."""
    evil = "<b onclick=x>&\"'"
    check = replace(reports["failing"].checks[-1], reason=evil, quantity=evil)
    page = render(
        replace(
            reports["failing"],
            title=evil,
            command=evil,
            checks=[check],
            settings=[(evil,) * 4],
            series={},
            differences=(),
            envelope=(),
        )
    )
    assert "<b " not in page
    assert text_of(page).count(evil) >= 6
    Page(page)


def test_dark_light_print_and_phones_are_provided_for(reports):
    """Both colour schemes define the same colours; there are rules for print and for narrow screens."""
    page = render(reports["chaos"])
    light, dark = (
        set(re.findall(r"(--[a-z0-9-]+):", part)) for part in re.findall(r":root \{(.*?)\n\s*\}", page, flags=re.DOTALL)[:2]
    )
    assert light == dark
    assert set(re.findall(r"var\((--[a-z0-9-]+)\)", page)) <= light
    assert "@media print" in page
    assert re.search(r"@media \(max-width", page)
    assert '<meta name="viewport" content="width=device-width' in page


def test_tables_have_headers_and_pictures_have_words(any_report):
    """Each table has column and row headers with a scope; each picture a text in its stead or is hidden from readers."""
    page = Page(render(any_report))
    assert all(attrs.get("scope") in {"col", "row", "rowgroup"} for attrs in page.all("th"))
    for attrs in page.all("svg"):
        assert attrs.get("aria-hidden") == "true" or (attrs["role"] == "img" and len(attrs["aria-label"]) > 20)


def test_pictures_show_every_engine_and_pair(reports):
    """Energies of three engines: three lines in each shared picture; differences: three pairs, the envelope, and the limit."""
    page = render(reports["chaos"])
    assert [page.count(f'class="e{k}"') for k in range(3)] == [3, 3, 3]  # ke, erotate and the legend
    assert [page.count(f'class="p{k}"') for k in range(3)] == [6, 6, 6]  # five quantities and the legend
    assert page.count('class="envelope"') == 5
    assert "Energy budget of native" in page
    assert "gravitational" in page


def test_a_single_state_needs_no_picture_over_time(reports):
    """One step is told by the table of verdicts alone."""
    assert "Differences over time" not in render(reports["skipped"])


def test_known_deviations_are_named_and_linked(reports):
    """The reason names the entry, the link leads to what it says, and what it says stands on the page once in words."""
    page, [entry] = render(reports["failing"]), reports["failing"].entries
    assert f'<a href="#known-{entry.id}">explained by {entry.id}</a>' in page
    assert page.split("<h2>Every check</h2>")[0].count(entry.what) == 1


def test_missing_and_dead_engines_are_told_with_their_reasons(reports):
    """How to install what is missing; the last lines of the log of what died."""
    assert "not installed: apt-get install liggghts" in text_of(render(reports["skipped"]))
    assert "Last input line: run 10000" in text_of(render(reports["crashed"]))


def test_energies_that_are_not_finite_break_the_line_only(reports):
    """NaN in a series of energies leaves a gap, and no nan in the picture."""
    bad = EnergySeries(np.arange(4.0), np.arange(4.0), {"ke": np.array([1.0, np.nan, 2.0, 3.0])})
    page = render(replace(reports["passing"], series={"native": bad, "lammps": bad}))
    assert not re.search(r'd="[^"]*nan', page)
    Page(page)


@pytest.mark.parametrize("values", [[0.0, 0.0], [np.nan, np.nan], [1e-300, 2e-300], [1e300, 2e300], [5.0, 5.0], [-1.0, 1.0]])
def test_energies_of_any_size_are_drawn(reports, values):
    """Zero, constant, negative, tiny, huge and undefined energies make a picture without nan or infinity."""
    series = EnergySeries(np.array([0.0, 1.0]), np.array([0.0, 1e-5]), {"ke": np.array(values)})
    page = render(replace(reports["passing"], series={"native": series, "lammps": series}))
    assert not re.search(
        r"\b(nan|inf)\b", "".join(re.findall(r'<svg class="plot".*?</svg>', page, flags=re.DOTALL)).partition("aria-label")[0]
    )
    assert not re.search(r'd="[^"]*(nan|inf)', page)


def test_the_file_is_written_whole_and_alone(reports, tmp_path):
    """One file, no leftovers; over an older one too; the folder must exist."""
    target = tmp_path / "report.html"
    target.write_text("old")
    write_report(target, reports["passing"])
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
    assert target.read_text(encoding="utf-8") == render(reports["passing"])
    with pytest.raises(FileNotFoundError):
        write_report(Path(tmp_path / "absent" / "report.html"), reports["passing"])


def made(**changes):
    """A check."""
    return replace(Check("force", ("a", "b"), 0, 1.0, 0.5, 1.0, "pass"), **changes)


def test_rows_put_failures_first_and_gather_steps():
    """Pairs with a failure first; in a tier failures first; steps of one kind in one row, the worst shown."""
    good, other = made(), made(engines=("a", "c"))
    bad = [made(engines=("a", "c"), step=s, max_rel=r, outcome="fail", quantity="torque") for s, r in ((20, 7.0), (10, 3.0))]
    law = made(kind="law", engines=("a", "closed form"))
    found = tables.rows([good, law, other, *bad])
    assert [(row.head.engines, row.head.quantity, row.head.kind) for row in found] == [
        (("a", "c"), "torque", "engine"),
        (("a", "c"), "force", "engine"),
        (("a", "b"), "force", "engine"),
        (("a", "closed form"), "force", "law"),
    ]
    assert (found[0].head.step, found[0].worst.step, len(found[0].checks)) == (10, 20, 2)


def test_laws_and_engines_are_never_in_one_row():
    """The same names, but one is engine against engine and one a law: two rows, two groups."""
    assert len(tables.rows([made(), made(kind="law")])) == 2


def test_curves_are_made_of_measured_checks():
    """Steps ascend; what was not measured, and counts of ids, draw no curve."""
    checks = [
        made(step=10, max_rel=2.0),
        made(step=0, max_rel=1.0),
        made(step=5, max_rel=np.nan),
        made(quantity="ids"),
        made(kind="law"),
    ]
    [curve] = difference_curves(checks)
    assert (curve.engines, curve.quantity) == (("a", "b"), "force")
    assert curve.step.tolist() == [0.0, 10.0]
    assert curve.value.tolist() == [1.0, 2.0]


def test_limits_in_the_pictures_are_those_that_judged(reports):
    """Other tolerances draw another limit."""
    page = render(reports["chaos"], Tolerances(tier2=1e-6))
    assert "limit 10⁻⁶" in page
    assert "limit 10⁻⁹" not in page
