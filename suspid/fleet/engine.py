"""Distribute chunks of records to workers and collect tables; the chunk of a worker that dies is distributed again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, replace

from suspid.errors import SuspidError
from suspid.files import printable
from suspid.fleet.failures import failure
from suspid.fleet.job import Job
from suspid.fleet.parts import Part, as_part
from suspid.fleet.records import Entry, Seen
from suspid.fleet.tables import joined
from suspid.units import Second
from suspid.words import Failure, Remark, Step

# How often a chunk is given away before its records are failures: once as it is, then with a process for it alone.
CHUNK_TRIES = 4
# How long to wait for a result before asking whether the cluster still lives.
ASK: Second = 5.0
CLUSTER_LOST = "the cluster was lost; what is written is complete, and the same command continues from there"


@dataclass(frozen=True, kw_only=True, slots=True)
class Engine:
    """A way to have chunks worked on."""

    # Give away a chunk; the last argument says that its worker has died before.
    submit: Callable[[Job, tuple[Entry, ...], bool], Future[Part]]
    # End the workers; the argument says whether chunks under way are given up.
    stop: Callable[[bool], None]
    # How many chunks can be worked on at once now.
    workers: Callable[[], int]
    # Whether results can still come.
    alive: Callable[[], bool]
    note: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Task:
    """A chunk that is given away: its number, its records, and how often its worker has died."""

    number: int
    chunk: tuple[Entry, ...]
    deaths: int = 0


def finished(engine: Engine, job: Job, chunks: Iterable[tuple[int, tuple[Entry, ...]]]) -> Iterator[tuple[int, Part]]:
    """Yield the number and the tables of each chunk as they come; every chunk comes once.

    Raises
    ------
    SuspidError
        If the cluster is lost, or a worker has other versions than the client.
    """
    source, again = (Task(number=number, chunk=chunk) for number, chunk in chunks), deque[Task]()
    under_way: dict[Future[Part], Task] = {}
    complete = False
    try:
        while True:
            # Two chunks under way per worker: one at work and one waiting. With one alone workers idle while results
            # are written; more only cost memory.
            while len(under_way) < 2 * engine.workers():
                task = again.popleft() if again else next(source, None)
                if task is None:
                    break
                under_way[engine.submit(job, task.chunk, task.deaths > 0)] = task
            if not under_way:
                complete = True
                return
            done = wait(under_way, timeout=ASK, return_when=FIRST_COMPLETED).done
            if not done and not engine.alive():
                raise SuspidError(CLUSTER_LOST)
            for future in done:
                task = under_way.pop(future)
                part, error = _outcome(engine, future)
                if part is None and task.deaths + 1 < CHUNK_TRIES:
                    again.append(replace(task, deaths=task.deaths + 1))
                    continue
                yield task.number, part or _lost(job, task, error)
    finally:
        engine.stop(not complete)


def _outcome(engine: Engine, future: Future[Part]) -> tuple[Part | None, BaseException | None]:
    """Return the tables, or the error that says why there are none."""
    try:
        return future.result(), None
    except (SuspidError, KeyboardInterrupt, SystemExit):
        # A record's errors are rows; this one is about the worker or the user.
        raise
    except BaseException as error:
        if isinstance(error, CancelledError) or not engine.alive():
            raise SuspidError(CLUSTER_LOST) from error
        return None, error


def _lost(job: Job, task: Task, error: BaseException | None) -> Part:
    why = Remark(Failure.WORKER_LOST, {"times": CHUNK_TRIES, "why": printable(str(error))})
    return as_part(joined([failure(job, entry, Seen(step=Step.WORK), why) for entry in task.chunk]), job.layout)
