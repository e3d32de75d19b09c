"""The command line: thin. Data on stdout, progress on stderr; exit status 0 agree, 1 disagree, 2 wrong input, 3 an engine crashed."""

from __future__ import annotations

import re
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from demverify.cli_bench import bench
from demverify.cli_erotate import erotate
from demverify.cli_library import cases, new_case, verify
from demverify.cli_reproduce import reproduce
from demverify.cli_stability import stability
from demverify.cli_timestep import timestep
from demverify.cli_view import view
from demverify.errors import InputError, Place
from demverify.formats.atomic import check_writable

if TYPE_CHECKING:
    from demsolver.guard import OnInstability as GuardMode
    from demverify.engines.base import Progress

INTERRUPTED = "interrupted; what was written is readable"
PRECISIONS = ("double", "mixed")

app = typer.Typer(
    add_completion=False, pretty_exceptions_enable=False, help="One deck, three engines, one verdict.",
    context_settings={"help_option_names": ["-h", "--help"]},
)  # fmt: skip

app.command()(erotate)
app.command()(reproduce)
app.command()(stability)
app.command()(timestep)
app.command()(view)
app.add_typer(bench, name="bench")
app.command("cases")(cases)
app.command("verify")(verify)
app.command("new-case")(new_case)

Json = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the result as JSON.")]
Var = Annotated[
    list[str] | None,
    typer.Option("--var", metavar="NAME VALUE", help="Set a variable of the deck, as -var of LAMMPS; may be repeated. NAME=VALUE works too."),
]
Threads = Annotated[int, typer.Option(min=1, max=256, help="Threads of the native engine.")]
Ranks = Annotated[int, typer.Option(min=1, help="MPI ranks of LAMMPS and LIGGGHTS.")]
Strict = Annotated[bool, typer.Option("--strict", help="Native engine: refuse a step above its stability limit, instead of warning.")]
OnInstability = Annotated[
    str, typer.Option("--on-instability", metavar="stop|warn|off", help="Native engine: what the guard does that finds a run going wrong.")
]
Precision = Annotated[str, typer.Option(help="Native engine: double, or mixed (a contact's geometry and force as float32).")]
Sleep = Annotated[
    float | None,
    typer.Option("--sleep", metavar="SPEED", help="Native engine: leave islands at rest, slower than SPEED, out of the steps until something comes."),
]
Timeout = Annotated[float, typer.Option(min=1.0, help="Time limit of one engine, in seconds.")]


@app.command()
def compare(
    target: Annotated[Path, typer.Argument(help="A case folder (in.lammps, in.liggghts, case.toml), FOLDER:VARIANT of it, or one deck.")],
    out: Annotated[Path, typer.Option(help="Folder for runs and report.")] = Path("demverify-report"),
    engine: Annotated[list[str] | None, typer.Option(help="Compare only these engines; may be repeated.")] = None,
    accept: Annotated[list[str] | None, typer.Option(help="A known difference (id in the register) to live with; may be repeated.")] = None,
    var: Var = None,
    threads: Threads = 1,
    ranks: Ranks = 1,
    timeout: Timeout = 3600.0,
    on_instability: OnInstability = "warn",
    json: Json = None,
) -> None:
    """Run a deck or a case in every engine there is, and say where they agree."""
    from demverify.cases import split_variant
    from demverify.compare import exit_status
    from demverify.report.html import write_report
    from demverify.report.json import write_json
    from demverify.report.text import print_comparison
    from demverify.verify import Settings, compare_case, find_case, known_engines

    variables = variables_of(var)
    check_writable(json)
    settings = Settings(
        known_engines(engine), threads, ranks, timeout, tuple(accept or ()), on_instability=guard_of(on_instability), warn=_warner(target)
    )
    if not target.exists() and not split_variant(target):
        message = f"there is no deck or case folder {target}"
        raise InputError(message)
    folder = out / target.resolve().name.replace(":", "-")
    case, rows = find_case(target, folder, variables)
    with _bars() as watch:
        found = compare_case(case, folder, settings, watch, rows)
    page = folder / "report.html"
    write_report(page, found.report)
    if json:
        write_json(json, found.checks, found.report.engines)
    print_comparison(found.report, page)
    raise typer.Exit(exit_status(found.checks))


@app.command()
def run(
    deck: Annotated[Path, typer.Argument(help="A deck of LAMMPS or LIGGGHTS.")],
    engine: Annotated[str, typer.Option(help="native, lammps or liggghts.")] = "native",
    out: Annotated[Path, typer.Option(help="Folder for everything the run writes.")] = Path("demverify-run"),
    var: Var = None,
    threads: Threads = 1,
    ranks: Ranks = 1,
    timeout: Timeout = 3600.0,
    strict: Strict = False,
    precision: Precision = "double",
    sleep: Sleep = None,
    on_instability: OnInstability = "stop",
    json: Json = None,
) -> None:
    """Run a deck in one engine; leaves its dumps, thermo.csv and trajectory.h5 in a folder."""
    from demverify.engines.base import Job
    from demverify.report.json import write_json
    from demverify.report.text import print_run
    from demverify.runs import execute, output_interval
    from demverify.verify import engine_info, known_engines

    (name,) = known_engines([engine]) or ("native",)
    variables = variables_of(var)
    check_writable(json)
    if strict and name != "native":
        message = f"--strict looks at runs of the native engine, not of {name}; demverify timestep --strict looks at the deck"
        raise InputError(message)
    if strict:
        from demverify.runs import plan
        from demverify.timestep import check_limits

        check_limits(plan(deck, variables).runs[0].scene, deck)
    if precision not in PRECISIONS:
        message = f"--precision {precision} is not one of {', '.join(PRECISIONS)}"
        raise InputError(message)
    modes, guard = {"precision": precision, "sleep": sleep}, guard_of(on_instability)
    if name != "native" and (guard != "stop" or modes != {"precision": "double", "sleep": None}):
        message = f"--precision, --sleep and --on-instability are of the native engine; {name} has no such modes"
        raise InputError(message)
    job = Job(deck, out, variables, output_interval(deck, variables, name), timeout, ranks, threads)
    with _bars() as watch:
        unstable = _refuser(deck) if strict else _warner(deck)
        found = execute(name, name, job, watch(name), modes=modes, unstable=unstable, on_instability=guard, warn=_warner(deck))
    if json:
        write_json(json, None, {name: engine_info(found)})
    if found.outcome.status != "ok":
        _complain(3 if found.outcome.status == "crashed" else 2, f"{name} {found.outcome.status}: {found.outcome.reason}")
    print_run(found)


@app.command()
def convert(
    deck: Annotated[Path, typer.Argument(help="The deck to convert.")],
    to: Annotated[str, typer.Option(help="lammps or liggghts.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The deck to write; a data file goes beside it where one is needed.")],
    var: Var = None,
    json: Json = None,
) -> None:
    """Write a deck in the other engine's words."""
    from demverify.deck.convert import convert as convert_deck
    from demverify.report.json import write_data
    from demverify.runs import plan

    check_writable(json)
    if to not in ("lammps", "liggghts"):
        message = f"--to {to} is not one of lammps, liggghts"
        raise InputError(message)
    found = convert_deck(plan(deck, variables_of(var)), to, output)  # type: ignore[arg-type]
    if json:
        write_data(json, {"to": to, "deck": str(output), "mapped": [{"from": theirs, "to": ours} for theirs, ours, _ in found.rows]})
    for theirs, ours, _ in found.rows:
        print(f"{theirs}  ->  {ours}")


@app.command()
def doctor(json: Json = None) -> None:
    """Say which engines are here, which versions, what is missing and how to get it."""
    from demverify.doctor import diagnose
    from demverify.report.json import write_data
    from demverify.report.text import print_doctor

    check_writable(json)
    rows = diagnose()
    if json:
        write_data(json, rows)
    print_doctor(rows)


def _warner(deck: Path) -> Callable[[str], None]:
    return lambda message: print(f"demverify: warning: {deck}: {message}", file=sys.stderr)


def _refuser(deck: Path) -> Callable[[str], NoReturn]:
    def refuse(message: str) -> NoReturn:
        raise InputError(message, Place(deck))

    return refuse


def guard_of(word: str) -> GuardMode:
    """--on-instability as Simulation has it. Raises InputError."""
    if word not in ("stop", "warn", "off"):
        message = f"--on-instability {word} is not one of stop, warn, off"
        raise InputError(message)
    return word  # type: ignore[return-value]


def variables_of(given: Sequence[str] | None) -> dict[str, list[str]]:
    """--var NAME=VALUE as the variables of a deck. Raises InputError."""
    pairs = {}
    for text in given or ():
        name, equals, value = text.partition("=")
        if not equals or not re.fullmatch(r"\w+", name):
            message = f"--var {text}: expected NAME VALUE, a name of letters, digits and underscores"
            raise InputError(message)
        pairs[name] = [value]
    return pairs


def _one_word_each(arguments: list[str]) -> list[str]:
    """`--var NAME VALUE` as `--var NAME=VALUE`, `--bodies A B` as `--bodies A --bodies B`: click's options take one word each."""
    joined, rest = [], list(arguments)
    while rest:
        word = rest.pop(0)
        joined.append(word)
        if word == "--bodies" and rest:
            joined.append(rest.pop(0))
            while rest and not rest[0].startswith("-"):
                joined += ["--bodies", rest.pop(0)]
        elif word in ("--var", "-var") and rest:
            joined[-1] = "--var"
            name = rest.pop(0)
            joined.append(name if "=" in name or not rest else f"{name}={rest.pop(0)}")
    return joined


@contextmanager
def _bars() -> Iterator[Any]:
    """A progress bar on stderr for each engine, where there is somebody to see it."""
    if not sys.stderr.isatty():
        yield lambda label: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    steps = TextColumn("{task.completed:>9.0f} of {task.total:.0f} steps")
    columns = (TextColumn("{task.description:>18}"), BarColumn(), steps, TimeRemainingColumn())
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:

        def watch(label: str) -> Progress:
            task = bars.add_task(label, total=1)
            return lambda done, total: bars.update(task, completed=done, total=max(1, total))

        yield watch


def main() -> None:
    """Entry point. Whatever goes wrong is one line on stderr: bad input and wrong words status 2, an interruption 130 (SIGINT) or 143."""
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # numpy's about overflows: what came of them is told in our own words
    try:
        with _ended_by_sigterm():
            sys.exit(_status())
    except InputError as error:
        _complain(2, str(error))
    except OSError as error:
        _complain(2, f"{error.filename or 'a file'}: {error.strerror or error}")
    except MemoryError:
        _complain(3, "not enough memory")
    except (KeyboardInterrupt, typer.Abort):
        _complain(130, INTERRUPTED)


@contextmanager
def _ended_by_sigterm() -> Iterator[None]:
    """As by Ctrl-C: engines are ended, files closed. Afterwards SIGTERM is the caller's again: a fork with this handler would outlive its pool."""
    before = None
    with suppress(ValueError):  # only the main thread may
        before = signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)


def _status() -> int:
    """Runs the command. Typer's own complaints are shortened to one line; an interruption comes back from it as 130."""
    usage: type[Exception] = typer.BadParameter.__bases__[0]  # UsageError: of click, or of typer where it has a copy of its own
    try:
        status = app(args=_one_word_each(sys.argv[1:]), prog_name="demverify", standalone_mode=False) or 0
    except usage as error:
        _complain(2, _usage(error))
    if status == 130:
        raise KeyboardInterrupt
    return int(status)


def _usage(error: Any) -> str:
    """`Missing argument 'deck' (demverify run --help)`."""
    context = error.ctx
    message = " ".join(error.format_message().split()).rstrip(".")
    return f"{message} ({context.command_path if context else 'demverify'} --help)"


def _complain(status: int, message: str) -> NoReturn:
    print(f"demverify: {message}", file=sys.stderr)
    sys.exit(status)


def _terminate(*_: object) -> NoReturn:
    _complain(143, INTERRUPTED)


if __name__ == "__main__":
    main()
