"""What users say of their dumps, in options or in a deck, as one `Meanings`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from demverify.analysis.meanings import Meanings
from demverify.analysis.quantities import ANY_TYPE
from demverify.errors import InputError


def meanings_from(
    deck: Path | None = None,
    variables: Mapping[str, Sequence[str]] | None = None,
    templates: Sequence[Path] = (),
    density: float | None = None,
    timestep: float | None = None,
) -> tuple[Meanings, list[str]]:
    """The meanings, and what of the deck was not understood. density (of all particles), timestep and templates win over the deck.

    Raises InputError for a deck or template that cannot be read, and for numbers that are none.
    """
    found, notes = Meanings(), list[str]()
    if deck:
        from demverify.deck.dictionary import read_dictionary

        dictionary = read_dictionary(deck, variables)
        found = dictionary.meanings
        notes = [note for note in dictionary.passed_over if not note.endswith(found.unknown_density)]  # told where one is needed
    if density is not None:
        found = replace(found, density={ANY_TYPE: _positive("density", density)})
    if timestep is not None:
        found = replace(found, timestep=_positive("timestep", timestep))
    if templates:
        from demverify.formats.template import read_template

        found = replace(found, templates=tuple(read_template(path, kind=i + 1) for i, path in enumerate(templates)))
        found = replace(found, rigid=found.rigid if found.rigid in ("molecule", "multisphere") else "multisphere")
    return found, notes


def _positive(name: str, value: float) -> float:
    if not 0.0 < value < math.inf:
        message = f"{name} {value}: expected a number above 0"
        raise InputError(message)
    return value
