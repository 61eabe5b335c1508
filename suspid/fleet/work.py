"""Work of one process: a chunk of records into tables; failures become rows."""

from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from suspid.errors import InputError
from suspid.fleet.failures import failure
from suspid.fleet.job import Job
from suspid.fleet.manifest import environment
from suspid.fleet.parts import Part, as_part
from suspid.fleet.records import Entry, Seen
from suspid.fleet.rows import record_rows
from suspid.fleet.tables import Rows, joined
from suspid.threads import one_thread
from suspid.units import Second
from suspid.wording import called
from suspid.words import Failure, Remark

# Exit code of a process that ends itself because time is up; any value that nothing else uses.
TIME_UP = 86
# Warnings, threads of BLAS and caches belong to the process: one record at a time.
_RUNNING = threading.Lock()


class TimeUp(BaseException):
    """A record took longer than it may; not an `Exception`, so that no handler on the way catches it."""


def work(job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the tables of a chunk of records."""
    check_versions(job)
    return tables_of(job, chunk, {}, done=lambda: None)


def tables_of(job: Job, chunk: Sequence[Entry], known: Mapping[int, Rows], *, done: Callable[[], None]) -> Part:
    """Return the tables of a chunk, some records of which may be known; call ``done`` first and after each record."""
    rows = []
    # Workers must not fight for cores, and sums must come in one order.
    with one_thread(*(["cvxpy"] if job.car and job.drive is None else [])):
        done()
        for k, entry in enumerate(chunk):
            rows.append(known[k] if k in known else rows_of(job, entry))
            done()
        return as_part(joined(rows), job.layout)


def rows_of(job: Job, entry: Entry) -> Rows:
    """Return the rows of one record; whatever goes wrong becomes a row among the failures."""
    with _RUNNING:
        seen = [Seen()]
        try:
            with limited(job.time_limit), called(job.options):
                return record_rows(job, entry, seen.append)
        except TimeUp:
            return failure(job, entry, seen[-1], Remark(Failure.TIME, {"limit": job.time_limit}))


def check_versions(job: Job) -> None:
    """Refuse to work for a client of another version: its results could not be distinguished from ours."""
    here = environment()
    for name, version in job.environment.items():
        if here.get(name) != version:
            raise InputError(f"a worker has {name} {here.get(name)}, the client {version}: install the same on both")


@contextmanager
def limited(seconds: Second | None) -> Iterator[None]:
    """Raise `TimeUp` in this thread when time is up; end the process if native code does not hear."""
    if seconds is None:
        yield
        return
    thread = threading.get_ident()
    interrupt = ctypes.pythonapi.PyThreadState_SetAsyncExc
    stop = threading.Timer(seconds, lambda: interrupt(ctypes.c_ulong(thread), ctypes.py_object(TimeUp)) and None)
    # Native code cannot be interrupted: its process is ended a quarter after the time limit. Less would end processes
    # that are about to answer.
    end = threading.Timer(1.25 * seconds, lambda: os._exit(TIME_UP))
    stop.daemon = end.daemon = True
    try:
        stop.start()
        end.start()
        yield
    finally:
        stop.cancel()
        end.cancel()
