"""Who does the work of a fleet: the cores of this machine, or a Dask cluster; and what is done when a worker dies."""

from __future__ import annotations

import importlib
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from suspid.errors import InputError, SuspidError
from suspid.files import printable
from suspid.fleet.manifest import INSTALL
from suspid.fleet.parts import Part
from suspid.fleet.records import Entry
from suspid.fleet.rows import Job
from suspid.fleet.work import ONE_THREAD, leave_with, lost, work, work_apart
from suspid.units import Second

if TYPE_CHECKING:
    from distributed import Client

# Chunks under way per worker: one at work and one in wait, so that nobody idles and nothing piles up.
AHEAD = 2
# So often a chunk is given away: once as it is, then with every record in a process of its own.
TRIES = 4
# How long to wait for the first worker of a cluster, and how often to ask how many there are.
FIRST_WORKER: Second = 60.0
ASK: Second = 5.0
LOST = "the cluster was lost; what is written is complete, and the same command goes on from there"


@dataclass(frozen=True, kw_only=True, slots=True)
class Engine:
    """A way to have work done elsewhere.

    Parameters
    ----------
    start : callable
        Return a new executor, the first or one that takes the place of a broken one.
    stop : callable
        End an executor; the second argument says whether work still under way is to be given up.
    workers : callable
        How many chunks can be worked on at once now.
    alive : callable
        Whether there is still anybody to ask.
    note : str
        What the user should know; perhaps empty.
    """

    start: Callable[[], Executor]
    stop: Callable[[Any, bool], None]
    workers: Callable[[], int]
    alive: Callable[[], bool]
    note: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Task:
    """A chunk on its way: its number, its records, and how often it was given away in vain."""

    number: int
    chunk: tuple[Entry, ...]
    vain: int = 0


def finished(engine: Engine, job: Job, chunks: Iterable[tuple[int, tuple[Entry, ...]]]) -> Iterator[tuple[int, Part]]:
    """Yield the number and the tables of each chunk as they come; every chunk comes once.

    A chunk whose worker died is given away again with every record in a process of its own: the one that
    kills its process twice is a failure, the others are not.

    Raises
    ------
    SuspidError
        If the cluster is lost, or a worker has other versions than the client.
    """
    source, again = iter(chunks), deque[Task]()
    under_way: dict[Future[Part], Task] = {}
    pool, complete = engine.start(), False
    try:
        while True:
            broken = False
            while len(under_way) < AHEAD * engine.workers():
                task = again.popleft() if again else _next(source)
                if task is None:
                    break
                try:
                    under_way[pool.submit(work_apart if task.vain else work, job, task.chunk)] = task
                except BrokenExecutor:
                    again.appendleft(task)
                    broken = True
                    break
            if not under_way and not broken:
                complete = True
                return
            done = wait(under_way, timeout=ASK, return_when=FIRST_COMPLETED).done if under_way else set()
            if not done and not engine.alive():
                raise SuspidError(LOST)
            for future in done:
                task = under_way.pop(future)
                part, error = _outcome(engine, future)
                broken = broken or isinstance(error, BrokenExecutor)
                if part is not None:
                    yield task.number, part
                elif task.vain + 1 < TRIES:
                    again.append(replace(task, vain=task.vain + 1))
                else:
                    reason = f"{TRIES} workers were lost over its chunk: {printable(str(error))}"
                    yield task.number, lost(job, task.chunk, reason)
            if broken:
                # Whoever died took the pool along; what was under way there is suspected, not lost.
                again.extend(replace(task, vain=task.vain + 1) for task in under_way.values())
                under_way.clear()
                engine.stop(pool, True)
                pool = engine.start()
    finally:
        engine.stop(pool, not complete)


@contextmanager
def local_engine(workers: int | None) -> Iterator[Engine]:
    """Give the cores of this machine, by joblib's pool of processes.

    Raises
    ------
    InputError
        If the number of workers is none.
    """
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"{workers=} must be a number of processes, 1 or more")
    import joblib

    loky = importlib.import_module("joblib.externals.loky")
    count = workers or joblib.cpu_count()

    def stop(pool: Any, give_up: bool) -> None:
        pool.shutdown(wait=True, kill_workers=give_up)

    yield Engine(
        start=lambda: loky.ProcessPoolExecutor(
            max_workers=count, env=ONE_THREAD, initializer=leave_with, initargs=(os.getpid(),)
        ),
        stop=stop,
        workers=lambda: count,
        alive=lambda: True,
    )


@contextmanager
def dask_engine(scheduler: str | Client) -> Iterator[Engine]:
    """Give the workers of a Dask cluster, by the address of its scheduler or a client that is connected.

    Raises
    ------
    InputError
        If Dask is not installed, the scheduler does not answer, or no worker comes.
    """
    try:
        connect: Any = importlib.import_module("distributed").Client
    except ImportError:
        raise InputError(f"a cluster needs dask.distributed: {INSTALL}") from None
    client: Any = scheduler
    if not isinstance(scheduler, (str, connect)):
        raise InputError(f"{scheduler=!r:.80} must be the address of a Dask scheduler or a dask.distributed.Client")
    if isinstance(scheduler, str):
        try:
            client = connect(scheduler, set_as_default=False, timeout=FIRST_WORKER)
        except (OSError, ValueError, TimeoutError) as refusal:
            raise InputError(f"{printable(scheduler)}: no Dask scheduler answers: {printable(str(refusal))}") from None
    try:
        try:
            client.wait_for_workers(1, timeout=FIRST_WORKER)
        except TimeoutError:
            raise InputError(f"the cluster has no worker, and none came within {FIRST_WORKER:g} s") from None
        threads = client.nthreads()
        asked = [time.monotonic(), float(sum(threads.values()))]

        def workers() -> int:
            if time.monotonic() - asked[0] > ASK:
                asked[:] = time.monotonic(), float(sum(client.nthreads().values()))
            return max(1, int(asked[1]))

        note = ""
        if max(threads.values()) > 1:
            note = (
                f"workers have up to {max(threads.values())} threads, but a process takes one record at a time: start "
                f"them with --nthreads 1 and one process per core"
            )
        yield Engine(
            start=lambda: client.get_executor(pure=False),
            stop=lambda pool, give_up: pool.shutdown(wait=not give_up),
            workers=workers,
            alive=lambda: client.status == "running",
            note=note,
        )
    finally:
        if client is not scheduler:
            client.close()


def _outcome(engine: Engine, future: Future[Part]) -> tuple[Part | None, BaseException | None]:
    """Return the tables, or the error that says why there are none."""
    try:
        return future.result(), None
    except SuspidError:
        # A record's errors are rows; this one is about the worker.
        raise
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:
        if isinstance(error, CancelledError) or not engine.alive():
            raise SuspidError(LOST) from error
        return None, error


def _next(source: Iterator[tuple[int, tuple[Entry, ...]]]) -> Task | None:
    found = next(source, None)
    return None if found is None else Task(number=found[0], chunk=found[1])
