"""What a worker does: a chunk of records into tables, whatever is wrong with some of them."""

from __future__ import annotations

import ctypes
import importlib
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from suspid.errors import InputError
from suspid.fleet.manifest import environment
from suspid.fleet.parts import Part, Rows, as_part, joined
from suspid.fleet.records import Entry
from suspid.fleet.rows import Job, failure, record_rows
from suspid.units import Second

# How far native code, which does not hear, may outlast the time limit before its process is ended.
GRACE = 1.25
TIME_UP = 86
# Warnings, threads of BLAS and caches belong to the process: one record at a time.
_ONE_AT_A_TIME = threading.Lock()


class TimeUp(BaseException):
    """A record took longer than it may; not an `Exception`, so that nothing on the way takes it for its own."""


def work(job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the tables of a chunk of records.

    Raises
    ------
    InputError
        If this worker has other versions than the client.
    """
    check_versions(job)
    return tables_of(job, chunk, {}, done=lambda: None)


def tables_of(job: Job, chunk: Sequence[Entry], known: Mapping[int, Rows], *, done: Callable[[], None]) -> Part:
    """Return the tables of a chunk of records, some of which may be known; call ``done`` after each record."""
    rows = []
    with one_thread(job):
        for k, entry in enumerate(chunk):
            rows.append(known[k] if k in known else rows_of(job, entry))
            done()
        return as_part(joined(rows))


def lost(job: Job, chunk: Sequence[Entry], reason: str) -> Part:
    """Return the tables of a chunk that no worker brings home."""
    return as_part(joined([failure(entry, None, job, "worker", "WorkerLost", reason) for entry in chunk]))


def rows_of(job: Job, entry: Entry) -> Rows:
    """Return the rows of one record; whatever goes wrong becomes a row among the failures."""
    with _ONE_AT_A_TIME:
        seen: dict[str, str] = {}
        try:
            with limited(job.time_limit):
                return record_rows(job, entry, seen)
        except TimeUp:
            reason = f"took longer than {job.time_limit:g} s"
            return failure(entry, seen.get("sha256"), job, "time", "TimeUp", reason)


def check_versions(job: Job) -> None:
    """Refuse to work for a client of another version: its results could not be told apart from ours."""
    here = environment()
    for name, version in job.environment.items():
        if here.get(name) != version:
            raise InputError(f"a worker has {name} {here.get(name)}, the client {version}: install the same on both")


@contextmanager
def one_thread(job: Job) -> Iterator[None]:
    """Hold the threads of BLAS: workers must not fight, and sums must come in one order."""
    # Those of a library that is loaded later would run free.
    for name in ("scipy.linalg", "control", *(["cvxpy"] if job.car else [])):
        importlib.import_module(name)
    try:
        threads = importlib.import_module("threadpoolctl")
    except ImportError:
        # Then the environment of the workers alone holds them.
        yield
        return
    with threads.threadpool_limits(limits=1):
        yield


@contextmanager
def limited(seconds: Second | None) -> Iterator[None]:
    """Raise `TimeUp` in this thread when time is up; end the process if native code does not hear."""
    if seconds is None:
        yield
        return
    thread = threading.get_ident()
    interrupt = ctypes.pythonapi.PyThreadState_SetAsyncExc
    stop = threading.Timer(seconds, lambda: interrupt(ctypes.c_ulong(thread), ctypes.py_object(TimeUp)) and None)
    end = threading.Timer(GRACE * seconds, lambda: os._exit(TIME_UP))
    stop.daemon = end.daemon = True
    try:
        stop.start()
        end.start()
        yield
    finally:
        stop.cancel()
        end.cancel()
