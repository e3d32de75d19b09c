"""Work-precision diagrams: scenes whose solution is known, at many steps, by every contender. One scene a file, read off the folder.

A scene module has

    TITLE        what moves, as on the page
    MEASURES     what the errors are of, in words
    problems(quick) -> tuple[Problem, ...]: see `_contenders`. A problem is one contact law, so one solution; its contenders are judged against it.
                 quick: few steps and, where every further law is a loop to compile, few contenders
    findings(quick, progress) -> tuple[Finding, ...]   (optional) what the scene shows besides

Decks are inputs/bench/<scene, with hyphens>/in.lammps and in.liggghts, with variables for the step, `dt`, and the number of `steps`: they are what
all contenders run (a scene has those of the engines that contend), the native solver under other laws and integrators too. A module whose name
starts with an underscore is no scene.

`demverify bench accuracy` writes a page for each: DIR/<scene>/report.html with its pictures, numbers.json and numbers.h5.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules

from demverify.errors import InputError
from demverify.studies import Progress, Study


def listing() -> tuple[str, ...]:
    """Names of the scenes, read off the folder."""
    return tuple(sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_")))


def check(names: Sequence[str]) -> None:
    """Raises InputError for a name that is no scene."""
    for name in names:
        if name not in listing():
            message = f"scene {name!r} is not one of {', '.join(listing())}"
            raise InputError(message)


def run(name: str, quick: bool, progress: Progress) -> Study:
    """Runs one scene with all its contenders. quick: fewer and longer steps. Raises InputError for an unknown name."""
    from demverify.bench._page import study_of

    check((name,))
    return study_of(name, import_module(f"{__name__}.{name}"), quick, progress)
