"""Blocks of dumps in parallel: threads of this process, or a Dask cluster that the user runs. Results come in order, a few at a time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Protocol

from demverify.analysis.erotate import Part, Request, energies_of_block
from demverify.errors import InputError
from demverify.formats.reading import Block

_AHEAD = 2  # blocks a worker has waiting: enough to keep it busy, few enough to keep memory small


class Workers(Protocol):
    """Something that computes blocks."""

    count: int

    def submit(self, block: Block, request: Request) -> Any:
        """Starts on a block; gives a future with a `result()`."""


class _Threads:
    def __init__(self, pool: ThreadPoolExecutor, count: int) -> None:
        self.count = count
        self._pool = pool

    def submit(self, block: Block, request: Request) -> Any:
        return self._pool.submit(energies_of_block, block, request)


class _Cluster:
    def __init__(self, client: Any) -> None:
        self.count = max(1, sum(client.nthreads().values()))
        self._client = client

    def submit(self, block: Block, request: Request) -> Any:
        return self._client.submit(energies_of_block, block, request, pure=False)


@contextmanager
def threads(count: int) -> Iterator[Workers]:
    """`count` threads of this process; the parser runs outside of Python's lock."""
    pool = ThreadPoolExecutor(count)
    try:
        yield _Threads(pool, count)
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def cluster(address: str) -> Iterator[Workers]:
    """The workers of the Dask scheduler at `address`; they must see the files under the same names.

    Raises InputError when dask is not installed or nobody answers.
    """
    try:
        from distributed import Client
    except ImportError:
        message = "--scheduler needs Dask: pip install 'demverify[dask]'"
        raise InputError(message) from None
    try:
        client: Any = Client(address, timeout=5)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        message = f"no Dask scheduler at {address}: {error}"
        raise InputError(message) from None
    with client:
        yield _Cluster(client)


def parts_in_parallel(
    blocks: Iterable[Block], request: Request, workers: Workers, done: Callable[[Block], object] = lambda block: None
) -> Iterator[Part]:
    """The parts of the blocks, in order. done: told of each block that is finished."""
    waiting: deque[tuple[Block, Any]] = deque()
    for block in blocks:
        waiting.append((block, workers.submit(block, request)))
        if len(waiting) >= _AHEAD * workers.count:
            yield _next(waiting, done)
    while waiting:
        yield _next(waiting, done)


def _next(waiting: deque[tuple[Block, Any]], done: Callable[[Block], object]) -> Part:
    block, future = waiting.popleft()
    part: Part = future.result()
    done(block)
    return part
