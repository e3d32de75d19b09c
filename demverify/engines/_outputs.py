"""What a run of the native engine would write, looked at before it runs: a dump or a thermo column that cannot be is told at once."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath

from demverify.deck.dry import NeedsRun
from demverify.deck.setup import DumpSpec, Setup, Spec
from demverify.deck.state_values import of_particles
from demverify.engines._checks import FIX, check_fixes, check_reference, check_rhythm
from demverify.engines._thermo import INDEXED, KEYWORDS, REDUCE
from demverify.errors import InputError, Place
from demverify.formats.columns import COLUMNS
from demverify.formats.dump import DumpWriter
from demverify.formats.thermo import ThermoTable, thermo_formats, thermo_keywords

OWN_FILES = ("trajectory.h5", "thermo.csv", "log.native")


def check_outputs(setup: Setup) -> None:
    """Raises InputError, with the place of the command, for a thermo column that does not exist, a format that does not fit its
    column, and a dump's file that is taken already."""
    place, keywords = setup.thermo.place, keywords_of(setup)
    ThermoTable(keywords, setup.dialect, thermo_formats(setup.thermo), place)
    check_fixes(setup)
    for keyword in keywords:
        check_keyword(setup, keyword, place)
        if found := FIX.match(keyword):
            check_rhythm(setup, found[1], place)
    for compute in setup.computes.values():
        if compute.style == "reduce":
            _check_reduce(compute)
            _check_density(setup, compute.args, f"compute {compute.id}", compute.place)
    taken = dict.fromkeys(OWN_FILES, "the run itself")
    for dump in setup.dumps.values():
        _check_dump(dump, setup, taken)


def check_own_file(command: str, name: str) -> None:
    """Raises InputError for a file that leads out of the folder of the run, or that the run itself writes."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts:
        message = f"{command} writes to {name!r}, outside the run folder; expected a relative path inside it"
        raise InputError(message)
    if str(path) in OWN_FILES:
        message = f"{command} writes to {name!r}, as does the run itself"
        raise InputError(message)


def keywords_of(setup: Setup) -> tuple[str, ...]:
    """The thermo keywords of a setup; where faces move, style one shows the volume too."""
    changes = any(face in "sm" for faces in setup.boundary for face in faces)
    return thermo_keywords(setup.thermo, setup.dialect, box_changes=changes)


def check_keyword(setup: Setup, keyword: str, place: Place | None = None) -> None:
    """Raises InputError for a name that no run gives a value, in a thermo table or a formula."""
    if keyword.startswith("v_"):
        with suppress(NeedsRun):  # what only the run knows it will tell
            setup.variables.exact(keyword[2:], place)
    elif found := INDEXED.match(keyword):
        _check_compute(setup, found[1], int(found[2] or 0), place)
    elif found := FIX.match(keyword):
        check_reference(setup, found[1], int(found[2] or 0), place)
    elif keyword not in KEYWORDS and not (place is None and of_particles(keyword)):  # a formula may ask for these, a thermo table may not
        message = f"thermo keyword {keyword!r} is not one of {', '.join(KEYWORDS)}, c_ID, f_ID[i], v_NAME"
        raise InputError(message, place)


def _check_compute(setup: Setup, name: str, index: int, place: Place | None) -> None:
    if name not in setup.computes:
        message = f"c_{name}: compute {name!r} is not one of {', '.join(setup.computes) or 'none'}"
        raise InputError(message, place)
    compute = setup.computes[name]
    values = len(compute.args) - 1 if compute.style == "reduce" else 1
    if values > 0 and ((values == 1) != (index == 0) or index > values):
        expected = f"c_{name}" if values == 1 else f"c_{name}[1] to c_{name}[{values}]"
        message = f"c_{name}{f'[{index}]' * bool(index)}: this compute has {expected}"
        raise InputError(message, place)


def _check_reduce(compute: Spec) -> None:
    mode, inputs = (compute.args or ("",))[0], compute.args[1:]
    wrong = [name for name in inputs if name not in COLUMNS]
    if mode not in REDUCE or wrong or not inputs:
        got = " ".join((mode, *(wrong[:1] or inputs[:1])))
        message = f"compute {compute.id} reduce {got}: expected a mode of {', '.join(REDUCE)} and columns of {', '.join(COLUMNS)}"
        raise InputError(message, compute.place)


def _check_density(setup: Setup, columns: Sequence[str], what: str, place: Place) -> None:
    clumps = setup.atoms.clumps if setup.atoms else None
    if "density" in columns and clumps is not None and not clumps.members_weigh:
        message = f"{what}: density of members of clumps: LIGGGHTS has that of the template, which is not kept here; mass is that of the whole"
        raise InputError(message, place)


def _check_dump(dump: DumpSpec, setup: Setup, taken: dict[str, str]) -> None:
    if dump.group not in setup.groups:
        message = f"dump {dump.id}: group {dump.group!r} was deleted; defined: {', '.join(setup.groups)}"
        raise InputError(message, dump.place)
    _check_density(setup, dump.columns, f"dump {dump.id}", dump.place)
    path = str(PurePosixPath(dump.file))
    if path in taken:
        message = f"dump {dump.id} writes to {dump.file!r}, as does {taken[path]}"
        raise InputError(message, dump.place)
    taken[path] = f"dump {dump.id}"
    DumpWriter(dump, setup.dialect, Path())  # looks at sort and formats
