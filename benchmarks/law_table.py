"""Prints the README's table of contact laws: `python benchmarks/law_table.py [--quick] [--each]`.

Every law of tests/cases/law_matrix.py on 1,000 spheres, native against the engine; about 15 minutes the first time. --quick: the
few that CI runs. --each: one row a law, else one row a style with the worst of its laws.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable
from dataclasses import astuple
from pathlib import Path

from rich.console import Console
from rich.progress import track

from demverify.engines import ENGINES
from demverify.engines.base import Missing
from tests.cases.law_matrix import LAWS, State, full_jobs, quick_jobs
from tests.cases.law_measure import Difference, measured

PLACE = {"bed": "periodic, floor", "silo": "cylinder, floor"}
ENGINE = {"lammps": "LAMMPS", "liggghts": "LIGGGHTS"}
HEAD = """\
| engine | contact law | state | laws | set-up: force | torque | 200 steps: force | torque |
|---|---|---|---:|---:|---:|---:|---:|"""


def rows(found: dict[tuple[str, State], Difference], *, each: bool) -> Iterable[str]:
    """Markdown rows: the worst of every style, or every law."""
    groups: dict[tuple[str, str, State], list[Difference]] = {}
    for (name, state), difference in found.items():
        law = LAWS[name]
        words = " ".join((law.style, *law.options)) if each else law.style
        groups.setdefault((law.dialect, words, state), []).append(difference)
    for (dialect, words, state), differences in groups.items():
        yield f"| {ENGINE[dialect]} | {words} | {PLACE[state]} | {len(differences)} | {' | '.join(_worst(differences))} |"


def _worst(differences: list[Difference]) -> Iterable[str]:
    """Set-up and end, force and torque; behind the end what one unit in the last place grows to, where that was measured."""
    found = [max(column) for column in zip(*map(astuple, differences), strict=True)]
    for value, chaos in zip(found[:4], (0.0, 0.0, *found[4:]), strict=True):
        yield f"{value:.0e}" + (f" (one ulp: {chaos:.0e})" if chaos else "")


def main(words: list[str]) -> int:
    """Measures and prints; 1 when a law could not be measured."""
    jobs = [job for job in (quick_jobs() if "--quick" in words else full_jobs()) if _here(LAWS[job[0]].dialect)]
    found, failed = {}, 0
    with tempfile.TemporaryDirectory() as folder, measured(jobs, Path(folder)) as futures:
        for job, future in track(futures.items(), "laws", console=Console(stderr=True)):
            try:
                found[job] = future.result()
            except Exception as error:  # noqa: BLE001  (one law must not take the table with it)
                failed = 1
                print(f"{job[0]} ({job[1]}): {error}", file=sys.stderr)
    print(HEAD, *rows(found, each="--each" in words), sep="\n")
    return failed


def _here(engine: str) -> bool:
    return not isinstance(ENGINES[engine].find(), Missing)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
