"""run, and what governs it: time step and neighbour lists."""

from __future__ import annotations

from demverify.deck.command import Command, command
from demverify.deck.commands.group import known_group
from demverify.deck.commands.space import need_box
from demverify.deck.insertion import due, insert
from demverify.deck.interpreter import Interpreter
from demverify.deck.rotating import turns_of
from demverify.deck.scene_builder import check_particles

_LAST_STEP = 2**63 - 1  # as in the engines
_LARGEST_SKIN = 1e100  # its square is still a number
_SPEED = ("page", "one", "binsize", "cluster")


@command("timestep")
def timestep(deck: Interpreter, cmd: Command) -> None:
    """timestep DT"""
    deck.setup.timestep = cmd.positive("the time step")
    cmd.end()


@command("reset_timestep")
def reset_timestep(deck: Interpreter, cmd: Command) -> None:
    """reset_timestep N: the time goes with it."""
    deck.setup.step = int(cmd.within("step", cmd.integer("step", 0), 0, _LAST_STEP))
    deck.setup.time = deck.setup.step * deck.setup.dt
    cmd.end()


@command("run_style")
def run_style(deck: Interpreter, cmd: Command) -> None:
    """run_style verlet: the only one here."""
    cmd.choice("style", ("verlet",))
    cmd.end()


@command("run")
def run(deck: Interpreter, cmd: Command) -> None:
    """run N [upto] [pre yes] [post yes|no] [start N] [stop N]"""
    need_box(deck, cmd)
    steps = cmd.integer("number of steps", 0)
    if deck.setup.step + steps > _LAST_STEP:
        raise cmd.error(f"number of steps: the engines count to {_LAST_STEP}, got {steps}")
    while cmd:
        keyword = cmd.choice("keyword", ("upto", "pre", "post", "start", "stop"))
        if keyword == "upto":
            if steps < deck.setup.step:
                raise cmd.error(f"upto {steps}: the run is at step {deck.setup.step} already")
            steps -= deck.setup.step
        elif keyword == "pre" and not cmd.yes("pre"):
            raise cmd.error("pre no is not supported: every run recomputes the forces")
        elif keyword == "post":
            cmd.yes("post")
        elif keyword in ("start", "stop"):
            cmd.integer(keyword, 0)  # for ramped fixes, of which there are none here
    if steps > 0 and due(deck.setup):
        steps -= _insert(deck)
    if deck.setup.atoms:
        check_particles(deck.setup.atoms, cmd.place)
    deck.setup.turns = turns_of(deck.setup, steps)
    deck.backend.run(deck.setup, steps)


def _insert(deck: Interpreter) -> int:
    """The step in which clumps are inserted: those that are there move, without them. Returns the steps done."""
    if deck.setup.atoms and deck.setup.atoms.n:
        deck.backend.run(deck.setup, 1)
    else:
        deck.setup.step += 1
        deck.setup.time += deck.setup.dt
    insert(deck.setup)
    return 1


@command("neighbor")
def neighbor(deck: Interpreter, cmd: Command) -> None:
    """neighbor SKIN bin|nsq|multi"""
    deck.setup.neighbor.skin = cmd.number("skin", 0.0)
    if deck.setup.neighbor.skin > _LARGEST_SKIN:
        raise cmd.error(f"skin must be at most {_LARGEST_SKIN:g}, got {deck.setup.neighbor.skin:g}")
    if cmd:
        cmd.choice("style", ("bin", "nsq", "multi"))
    cmd.end()


@command("neigh_modify")
def neigh_modify(deck: Interpreter, cmd: Command) -> None:
    """neigh_modify keyword value ...: every delay check exclude contact_distance_factor; others only cost or save time."""
    settings = deck.setup.neighbor
    while cmd:
        keyword = cmd.choice("keyword", (*_SPEED, "every", "delay", "check", "exclude", "contact_distance_factor"))
        if keyword == "every":
            settings.every = cmd.integer("every", 1)
        elif keyword == "delay":
            settings.delay = cmd.integer("delay", 0)
        elif keyword == "check":
            settings.check = cmd.yes("check")
        elif keyword == "contact_distance_factor":
            settings.contact_distance_factor = cmd.number(keyword, 1.0)
        elif keyword == "exclude":
            _exclude(deck, cmd)
        else:
            cmd.take(f"a value for {keyword}")
            deck.ignore(cmd)


def _exclude(deck: Interpreter, cmd: Command) -> None:
    what = cmd.choice("exclude", ("group", "type", "molecule/intra", "none"))
    pairs = deck.setup.neighbor.exclude
    if what == "none":
        pairs.clear()
        deck.setup.neighbor.exclude_intra.clear()
    elif what == "molecule/intra":
        deck.setup.neighbor.exclude_intra.append((known_group(deck.setup, cmd), cmd.place))
    elif what == "group":
        pairs.append((what, known_group(deck.setup, cmd), known_group(deck.setup, cmd)))
    else:
        need_box(deck, cmd)
        types = [str(cmd.integer("type", 1, deck.setup.ntypes)) for _ in range(2)]
        pairs.append((what, types[0], types[1]))
