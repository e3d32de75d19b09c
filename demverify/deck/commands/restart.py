"""write_restart, clear, read_restart: a run that is interrupted and goes on from a file."""

from __future__ import annotations

from demverify.deck.command import Command, command
from demverify.deck.commands.space import before_box, need_box
from demverify.deck.interpreter import Interpreter
from demverify.deck.restart import restart_of, restore
from demverify.deck.setup import Setup


@command("write_restart")
def write_restart(deck: Interpreter, cmd: Command) -> None:
    """write_restart FILE: a `*` in the name becomes the step."""
    need_box(deck, cmd)
    name = _file(cmd)
    cmd.end()
    deck.backend.keep(restart_of(deck.setup, deck.backend.memories(deck.setup)), name.replace("*", str(deck.setup.step)))


@command("read_restart")
def read_restart(deck: Interpreter, cmd: Command) -> None:
    """read_restart FILE: of names with a `*` that of the largest step."""
    before_box(deck, cmd)
    name = _file(cmd)
    cmd.end()
    restore(deck.setup, deck.backend.kept(name, deck.folder), cmd.place)


def _file(cmd: Command) -> str:
    name = cmd.take("a file")
    if "%" in name:
        raise cmd.error(f"a '%' in the file name {name!r} (one file a processor) is not supported")
    return name


@command("clear")
def clear(deck: Interpreter, cmd: Command) -> None:
    """clear: forgets everything but the variables; a deck describes one system, so only read_restart brings a box back."""
    cmd.end()
    deck.setup = Setup(dialect=deck.setup.dialect, variables=deck.variables, cleared=True)
    deck.backend.cleared()
