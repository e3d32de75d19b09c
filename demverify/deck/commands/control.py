"""Commands that steer the deck: variables, loops, conditions, files, messages."""

from __future__ import annotations

from demverify.deck.command import Command, command
from demverify.deck.interpreter import Interpreter, Quit
from demverify.deck.lexer import Line


@command("variable")
def variable(deck: Interpreter, cmd: Command) -> None:
    """variable NAME style args...: LAMMPS replaces variables in a quoted string too, LIGGGHTS does not (both measured)."""
    name, style = cmd.take("a name"), cmd.take("a style")
    args = cmd.rest()
    if style == "string" and deck.setup.dialect == "lammps":
        args = tuple(deck.variables.substitute(arg, cmd.place) for arg in args)
    deck.variables.define(name, style, args, cmd.place)


@command("next")
def next_(deck: Interpreter, cmd: Command) -> None:
    """next NAME...: when a variable runs out, the next jump is skipped."""
    deck.skip_jump = deck.variables.next(cmd.rest(), cmd.place) or deck.skip_jump


@command("label")
def label(deck: Interpreter, cmd: Command) -> None:
    """label ID: a place to jump to."""
    cmd.take("an ID")


@command("jump")
def jump(deck: Interpreter, cmd: Command) -> None:
    """jump FILE|SELF [LABEL]"""
    file = cmd.take("a file or SELF")
    target = cmd.take("a label") if cmd else None
    cmd.end()
    if deck.skip_jump:
        deck.skip_jump = False
    else:
        deck.jump(file, target, cmd.place)


@command("include")
def include(deck: Interpreter, cmd: Command) -> None:
    """include FILE"""
    file = cmd.take("a file")
    cmd.end()
    deck.include(file, cmd.place)


@command("quit")
def quit_(deck: Interpreter, cmd: Command) -> None:
    """quit: the rest of the deck is not read."""
    raise Quit


@command("if")
def if_(deck: Interpreter, cmd: Command) -> None:
    """if "test" then "command"... [elif "test" "command"...] [else "command"...]; strings are compared by LAMMPS alone."""
    test = cmd.take("a test")
    cmd.choice("the word after the test", ("then",))
    while True:
        commands = _branch(cmd)
        if not commands:
            raise cmd.error("expects at least one command in each branch")
        text = deck.variables.substitute(test, cmd.place)
        if deck.variables.condition(text, cmd.place, of_numbers=deck.setup.dialect == "liggghts"):
            return _execute(deck, commands, cmd)
        if not cmd:
            return None
        test = cmd.take("a test") if cmd.take("elif or else") == "elif" else "1"


def _branch(cmd: Command) -> list[str]:
    commands = []
    while cmd and cmd.peek() not in ("elif", "else"):
        commands.append(cmd.take("a command"))
    return commands


def _execute(deck: Interpreter, commands: list[str], cmd: Command) -> None:
    for text in commands:
        deck.one(Line(text, cmd.place))
        if text.split()[:1] == ["jump"]:
            return


@command("print")
def print_(deck: Interpreter, cmd: Command) -> None:
    """print "text" [file|append NAME] [screen yes|no]: variables inside the quotes are replaced too. Files are not written."""
    text = deck.variables.substitute(cmd.take("a text"), cmd.place)
    shown = True
    while cmd:
        keyword = cmd.choice("keyword", ("file", "append", "screen", "newline", "universe"))
        if keyword == "screen":
            shown = cmd.yes("screen")
        else:
            cmd.take(f"a value for {keyword}")
    if shown:
        deck.printed.append(text)


@command("shell")
def refused(deck: Interpreter, cmd: Command) -> None:
    """shell reaches outside of what one deck describes."""
    raise cmd.error("is not supported: a deck may not run programs")


@command(
    "echo", "log", "processors", "comm_modify", "comm_style", "communicate", "atom_modify", "timer", "timers", "modify_timing",
    "balance", "restart", "write_data", "write_dump", "info", "suffix", "package", "thermo_log",
)  # fmt: skip
def ignored(deck: Interpreter, cmd: Command) -> None:
    """Commands that cannot change the physics: read, noted, without effect."""
    deck.ignore(cmd)
