"""Blocks in parallel: in order, few at a time, stopped when nobody wants them; threads and a real Dask cluster give the same."""

from __future__ import annotations

import gzip
import itertools
import logging
import os
import pickle
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import demverify
from demverify import cli
from demverify.analysis import erotate, workers
from demverify.analysis.erotate import Part, Request
from demverify.analysis.quantities import MissingColumnError
from demverify.analysis.workers import cluster, parts_in_parallel, threads
from demverify.errors import InputError, Place
from demverify.formats.dump import split
from demverify.formats.reading import Block, HalfWrittenError
from tests.support.cli import Called, end_started, program

HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\nITEM: ATOMS id {columns}\n"
COLUMNS = "radius mass omegax omegay omegaz"


def frame(step: int, n: int = 2, columns: str = COLUMNS) -> str:
    """A frame of a text dump; the rotational energy is 0.1 n (step + 1)^2."""
    return HEAD.format(step=step, n=n, columns=columns) + "".join(f"{i} 0.5 2 0 {step + 1} 0\n" for i in range(1, n + 1))


def written(path: Path, *frames: str) -> Path:
    """A file of these frames."""
    path.write_text("".join(frames))
    return path


def blocks(n: int) -> list[Block]:
    """Blocks that are told apart by their names."""
    return [Block(Path(str(i))) for i in range(n)]


class Fake:
    """Workers that compute nothing. told: what happened, in order."""

    def __init__(self, count: int, failing: dict[str, BaseException] | None = None) -> None:
        self.count = count
        self.told: list[tuple[str, str]] = []
        self._failing = failing or {}

    def submit(self, block: Block, request: Request) -> Fake._Pending:
        self.told.append(("submit", str(block.path)))
        return Fake._Pending(str(block.path), self.told, self._failing)

    def those(self, what: str) -> list[str]:
        """The blocks that this happened to."""
        return [name for done, name in self.told if done == what]

    class _Pending:
        def __init__(self, name: str, told: list[tuple[str, str]], failing: dict[str, BaseException]) -> None:
            self._name, self._told, self._failing = name, told, failing

        def parts(self) -> Iterator[Part]:
            if self._name in self._failing:
                raise self._failing[self._name]
            self._told.append(("parts", self._name))
            yield Part(self._name, [], [])

        def cancel(self) -> None:
            self._told.append(("cancel", self._name))


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a second is enough here for whoever is going to answer."""
    monkeypatch.setattr(workers, "_PATIENCE", 0.5)


def test_parts_come_in_order_whatever_finishes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: of blocks that end in reverse order the parts come in the order of the blocks, and each is told as done in that order."""
    finished: list[str] = []

    def slow_first(block: Block, *_: object) -> Iterator[Part]:
        time.sleep(0.03 * (3 - int(block.path.name) % 4))
        finished.append(block.path.name)
        yield Part(block.path.name, [], [])

    monkeypatch.setattr(workers, "parts_of_block", slow_first)
    told: list[Block] = []
    with threads(4) as four:
        sources = [part.source for part in parts_in_parallel(blocks(8), Request(), four, told.append)]
    assert sources == [str(i) for i in range(8)]
    assert told == blocks(8)
    assert finished != sources  # the sleeps did put them out of order


@pytest.mark.parametrize("count", [1, 3])
def test_few_blocks_are_under_way(count: int) -> None:
    """Law: two blocks a worker are under way or wait to be given out: never more (memory), and no fewer while there are some (nobody idles)."""
    fake = Fake(count)
    parts = parts_in_parallel(iter(blocks(20)), Request(), fake)
    for given, part in enumerate(parts, 1):
        assert part.source == str(given - 1)
        assert len(fake.those("submit")) == min(given - 1 + 2 * count, 20)
    assert given == 20
    assert fake.those("cancel") == []


@pytest.mark.parametrize("error", [InputError("no", Place(Path("3"), 7)), KeyboardInterrupt()])
def test_an_error_comes_out_as_it_is_and_cancels_what_waits(error: BaseException) -> None:
    """Law: what a block raises is raised in its turn, and whatever else is under way is cancelled; so it is on Ctrl-C."""
    fake = Fake(2, {"3": error})
    found: list[str] = []
    with pytest.raises(type(error)) as caught:
        found.extend(part.source for part in parts_in_parallel(blocks(20), Request(), fake))
    assert caught.value is error
    assert found == fake.those("parts") == ["0", "1", "2"]
    assert fake.those("cancel") == ["3", "4", "5", "6"]


def test_a_caller_that_stops_early_cancels_what_waits() -> None:
    """Law: a generator that is closed leaves nothing under way."""
    fake = Fake(2)
    parts = parts_in_parallel(blocks(20), Request(), fake)
    next(parts)
    parts.close()
    assert fake.those("cancel") == ["0", "1", "2", "3"]


def test_a_thread_stays_a_few_parts_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: of a block of any length no more than a few parts are held; and whoever leaves waits for no more than the part in work."""
    made: list[int] = []

    def endless(block: Block, *_: object) -> Iterator[Part]:
        for i in itertools.count():
            made.append(i)
            yield Part(f"{block.path} {i}", [], [])

    monkeypatch.setattr(workers, "parts_of_block", endless)
    with threads(1) as one:
        parts = parts_in_parallel(blocks(3), Request(), one)
        sources = [part.source for part in itertools.islice(parts, 10)]
        time.sleep(0.1)
        assert len(made) <= 10 + 2 + 1  # taken, waiting, and the one that finds no room
    assert sources == [f"0 {i}" for i in range(10)]


def test_a_long_file_comes_in_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: a packed file, which is one block, comes in parts; together they are the file, with its notes, through threads and without."""
    monkeypatch.setattr(erotate, "_ROWS", 7)
    path = tmp_path / "d.gz"
    path.write_bytes(gzip.compress("".join(frame(step) for step in range(10)).encode()[:-3]))
    with threads(2) as two:
        parts = list(parts_in_parallel([Block(path)], Request(), two))
    assert [[found.row.step for found in part.frames] for part in parts] == [[0, 1, 2], [3, 4, 5], [6, 7, 8], []]
    assert [len(part.notes) for part in parts] == [0, 0, 0, 1]
    assert demverify.erotate(path)["step"].tolist() == list(range(9))


def test_an_error_of_a_block_keeps_file_and_line(tmp_path: Path) -> None:
    """Law: of a file in blocks that are read at once, the error in the middle tells the line of the whole file; the parts before it are given."""
    path = written(tmp_path / "d.dump", *(frame(step) for step in range(9)), frame(9).replace("0.5", "half", 1), frame(10))
    found: list[Part] = []
    with threads(3) as three, pytest.raises(InputError) as caught:
        found.extend(parts_in_parallel(split(path, 1), Request(), three))
    assert [row.row.step for part in found for row in part.frames] == list(range(9))
    assert caught.value.place == Place(path, 9 * 11 + 10)
    assert "column radius expects a number, got 'half'" in caught.value.message


@pytest.mark.parametrize("kind", [InputError, HalfWrittenError, MissingColumnError])
@pytest.mark.parametrize("place", [None, Place(Path("a b.dump"), 3), Place(Path("x"))])
def test_an_input_error_survives_the_way_between_processes(kind: type[InputError], place: Place | None) -> None:
    """Law: pickled and unpickled, an error is of the same class, with its message, place and text."""
    error = kind("what: is wrong", place)
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), back.message, back.place, str(back)) == (kind, error.message, place, str(error))


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: where Dask is not installed the message says what to install."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'demverify\[dask\]'"), cluster("tcp://127.0.0.1:1"):
        pass


@pytest.mark.parametrize("address", ["", "nonsense", "foo://x:1", "tls://127.0.0.1:1", "free", "silent", "web"])
@pytest.mark.usefixtures("impatient")
def test_nobody_of_dask_at_an_address(address: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Law: where no scheduler answers, or something else does, that is one InputError in a bounded time, and Dask logs nothing."""
    pytest.importorskip("distributed")
    capfd.readouterr()
    with socket.create_server(("127.0.0.1", 0)) as server:
        real = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        if address == "free":
            server.close()
        if address == "web":
            _answer_once(server)
        wrong = real if address in ("free", "silent", "web") else address
        start = time.monotonic()
        with pytest.raises(InputError, match="no Dask scheduler at ") as caught, cluster(wrong):
            pass
    assert time.monotonic() - start < 4.0  # the first import of distributed too
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")
    assert logging.root.manager.disable == 0


def _answer_once(server: socket.socket) -> None:
    from threading import Thread

    def answer() -> None:
        stream, _ = server.accept()
        with stream:
            stream.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" + b"x" * 64)

    Thread(target=answer, daemon=True).start()


@pytest.fixture(scope="module")
def dask_cluster() -> Iterator[Any]:
    """Two workers, processes of one thread each."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=logging.CRITICAL) as two:
        yield two


@pytest.fixture(autouse=True)
def _none_left_running() -> Iterator[None]:
    yield
    end_started()


def _called(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], *words: object) -> Called:
    """The command line in this process."""
    monkeypatch.setattr("sys.argv", ["demverify", *map(str, words)])
    capfd.readouterr()
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert isinstance(ended.value.code, int)
    return Called(ended.value.code, *capfd.readouterr())


def test_a_cluster_gives_the_same(
    dask_cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Law: with --scheduler the table is that of threads, byte by byte, also of files named from here; nothing but our notes is on stderr."""
    written(tmp_path / "d0.dump", *(frame(step) for step in range(0, 50, 10)))
    written(tmp_path / "d50.dump", *(frame(step) for step in range(50, 90, 10)), frame(90)[:-5])
    monkeypatch.chdir(tmp_path)
    here = _called(monkeypatch, capfd, "erotate", "d*.dump")
    there = _called(monkeypatch, capfd, "erotate", "d*.dump", "--scheduler", dask_cluster.scheduler_address)
    assert (there.status, there.out) == (0, here.out)
    assert len(here.out.splitlines()) == 10
    assert there.err == here.err.replace("d50.dump", str(tmp_path / "d50.dump"))
    assert there.err.count("\n") == 1


def test_an_error_on_a_worker(dask_cluster: Any, tmp_path: Path) -> None:
    """Law: what is wrong with a file is one line also from a worker, and Dask adds none of its own, also not when the program ends."""
    path = written(tmp_path / "bad.dump", frame(0, columns="radius mass omegax omegay betaz"))
    process = program("erotate", path, "--scheduler", dask_cluster.scheduler_address)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"demverify: {path}: step 0: erotate/sphere needs the columns omegax omegay omegaz; the dump has id radius mass")


def test_what_workers_cannot_see(dask_cluster: Any, tmp_path: Path) -> None:
    """Law: a file that is here and not on the worker's machine is an InputError that says so."""
    with cluster(dask_cluster.scheduler_address) as two:
        assert two.count == 2
        with pytest.raises(InputError, match=r"the Dask worker on .* has no such file") as caught:
            list(two.submit(Block(tmp_path / "d.dump"), Request()).parts())
    assert caught.value.place == Place(tmp_path / "d.dump")


@pytest.mark.usefixtures("impatient")
def test_a_worker_is_no_scheduler(dask_cluster: Any) -> None:
    """Law: the address of a worker is told apart."""
    with pytest.raises(InputError, match="it is a Worker"), cluster(dask_cluster.workers[0].worker_address):
        pass


def test_workers_that_die(dask_cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: a block that kills its worker is one line, not another worker's death after the other, nor a wait without end."""
    monkeypatch.setattr(workers, "_on_worker", lambda block, request: os._exit(1))
    monkeypatch.setattr(dask_cluster.scheduler, "allowed_failures", 0)
    with cluster(dask_cluster.scheduler_address) as two, pytest.raises(InputError, match=r"the Dask cluster at .* failed: KilledWorker") as caught:
        list(two.submit(blocks(1)[0], Request()).parts())
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("impatient")
def test_no_workers() -> None:
    """Law: a cluster that has no workers, or loses the last one while a block is under way, is told of after some time."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0", silence_logs=logging.CRITICAL) as none:
        with pytest.raises(InputError, match=r"has no workers$"), cluster(none.scheduler_address):
            pass
        with distributed.Client(none) as client, pytest.raises(InputError, match="lost all its workers"):
            list(workers._Cluster(client, "here").submit(blocks(1)[0], Request()).parts())
