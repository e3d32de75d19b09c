"""Blocks of dumps in parallel: threads of this process, or a Dask cluster that the user runs. Results come in order, a few at a time."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from queue import Full, Queue
from threading import Event
from typing import Any, Protocol

from demverify.analysis.erotate import Part, Request, parts_of_block
from demverify.errors import InputError, Place
from demverify.formats.reading import Block

_AHEAD = 2  # blocks a worker has waiting, and parts of them: enough to keep it busy, few enough to keep memory small
_PATIENCE = 5.0  # seconds for a scheduler to answer, and for a cluster without workers to get some


class Pending(Protocol):
    """A block somebody works on."""

    def parts(self) -> Iterator[Part]:
        """Waits for them, one after the other. Raises InputError."""

    def cancel(self) -> object:
        """It is no longer wanted."""


class Workers(Protocol):
    """Something that computes blocks, `count` at a time."""

    count: int

    def submit(self, block: Block, request: Request) -> Pending:
        """Starts on a block."""


class _Threads:
    def __init__(self, pool: ThreadPoolExecutor, count: int) -> None:
        self.count = count
        self.stopped = Event()
        self._pool = pool

    def submit(self, block: Block, request: Request) -> Pending:
        pending = _Local(self.stopped)
        self._pool.submit(pending.work, block, request)
        return pending


class _Local:
    """A block in the hands of a thread, which stays a few parts ahead of whoever takes them."""

    def __init__(self, stopped: Event) -> None:
        self._stopped, self._cancelled = stopped, Event()
        self._ahead: Queue[Part | Exception | None] = Queue(_AHEAD)

    def work(self, block: Block, request: Request) -> None:
        try:
            for part in parts_of_block(block, request):
                if not self._put(part):
                    return
            self._put(None)
        except Exception as error:  # noqa: BLE001  (is raised by whoever takes the parts)
            self._put(error)

    def _put(self, item: Part | Exception | None) -> bool:
        """False when nobody wants any more."""
        while not (self._stopped.is_set() or self._cancelled.is_set()):
            with suppress(Full):
                self._ahead.put(item, timeout=0.1)
                return True
        return False

    def parts(self) -> Iterator[Part]:
        while (item := self._ahead.get()) is not None:
            if isinstance(item, Exception):
                raise item
            yield item

    def cancel(self) -> None:
        self._cancelled.set()


class _Cluster:
    def __init__(self, client: Any, address: str) -> None:
        self.count = max(1, sum(client.nthreads().values()))
        self._client, self._address = client, address

    def submit(self, block: Block, request: Request) -> Pending:
        there = replace(block, path=block.path.absolute())
        return _Remote(self._client, self._address, self._client.submit(_on_worker, there, request, pure=False))


class _Remote:
    """A block in the hands of a cluster."""

    def __init__(self, client: Any, address: str, future: Any) -> None:
        self._client, self._address, self._future = client, address, future

    def parts(self) -> Iterator[Part]:
        while True:
            try:
                parts: list[Part] = self._future.result(timeout=_PATIENCE)
            except InputError:
                raise
            except Exception as error:  # noqa: BLE001  (whatever went wrong on another machine)
                if not isinstance(error, TimeoutError) or self._future.done():
                    message = f"the Dask cluster at {self._address} failed: {_one_line(error)}"
                    raise InputError(message) from None
                _check_workers(self._client, f"the Dask scheduler at {self._address} lost all its workers, whose logs may say why")
            else:
                yield from parts
                return

    def cancel(self) -> None:
        self._future.release()


def _on_worker(block: Block, request: Request) -> list[Part]:
    if not block.path.exists():
        message = f"the Dask worker on {socket.gethostname()} has no such file: workers must see files under the same names"
        raise InputError(message, Place(block.path))
    return list(parts_of_block(block, request))


@contextmanager
def threads(count: int) -> Iterator[Workers]:
    """`count` threads of this process; the parser runs outside of Python's lock. At the end those that still work are stopped."""
    pool = ThreadPoolExecutor(count)
    workers = _Threads(pool, count)
    try:
        yield workers
    finally:
        workers.stopped.set()
        pool.shutdown(cancel_futures=True)


@contextmanager
def cluster(address: str) -> Iterator[Workers]:
    """The workers of the Dask scheduler at `address`; they must see the files under the same names, and have demverify, as must the scheduler.

    Raises InputError when Dask is not installed, nobody answers, or there are no workers; also later, when these are lost.
    """
    with _silent():
        client = _connected(address)
        try:
            _check_workers(client, f"the Dask scheduler at {address} has no workers")
            yield _Cluster(client, address)
        finally:
            with suppress(OSError):  # it has gone
                client.close(timeout=_PATIENCE)


@contextmanager
def _silent() -> Iterator[None]:
    """Dask logs every lost connection; what matters of it is told as an InputError."""
    before = logging.root.manager.disable
    logging.disable()
    try:
        yield
    finally:
        logging.disable(before)


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        message = "--scheduler needs Dask: pip install 'demverify[dask]'"
        raise InputError(message) from None
    try:
        kind = asyncio.run(_kind_of_server(address))
        if kind == "Scheduler":
            return Client(address, timeout=_PATIENCE, set_as_default=False)  # type: ignore[no-untyped-call]
        why = f"it is a {kind}"
    except TimeoutError:
        why = f"no answer in {_PATIENCE:g} s"
    except Exception as error:  # noqa: BLE001  (whatever another kind of server makes of it)
        why = _one_line(error)
    message = f"no Dask scheduler at {address or repr(address)}: {why}"
    raise InputError(message)


async def _kind_of_server(address: str) -> str:
    """Scheduler or Worker. What does not speak Dask's language would have a client wait without end, or leave one that cannot be closed."""
    from distributed import Security, rpc

    security: Any = Security()  # type: ignore[no-untyped-call]
    keys = security.get_connection_args("client")  # for tls://, from Dask's configuration
    async with asyncio.timeout(_PATIENCE), rpc(address, timeout=_PATIENCE, connection_args=keys) as server:  # type: ignore[no-untyped-call]
        return str((await server.identity())["type"])


def _check_workers(client: Any, message: str) -> None:
    """Raises InputError with the message when the cluster has no workers for some time."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except OSError:  # a TimeoutError, or the scheduler has gone
        raise InputError(message) from None


def _one_line(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def parts_in_parallel(
    blocks: Iterable[Block], request: Request, workers: Workers, done: Callable[[Block], object] = lambda block: None
) -> Iterator[Part]:
    """The parts of the blocks, in order. done: told of each block that is finished.

    At most two blocks a worker are under way or wait to be taken; when the caller stops early, they are cancelled.
    """
    waiting: deque[tuple[Block, Pending]] = deque()
    try:
        for block in blocks:
            waiting.append((block, workers.submit(block, request)))
            if len(waiting) >= _AHEAD * workers.count:
                yield from _next(waiting, done)
        while waiting:
            yield from _next(waiting, done)
    finally:
        for _, pending in waiting:
            pending.cancel()


def _next(waiting: deque[tuple[Block, Pending]], done: Callable[[Block], object]) -> Iterator[Part]:
    block, pending = waiting[0]
    yield from pending.parts()
    waiting.popleft()
    done(block)
