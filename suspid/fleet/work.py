"""What a worker does: a chunk of records into tables, whatever is wrong with some of them."""

from __future__ import annotations

import ctypes
import importlib
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from suspid.errors import InputError
from suspid.fleet.manifest import environment
from suspid.fleet.parts import Part, Rows, as_part, joined
from suspid.fleet.records import Entry
from suspid.fleet.rows import Job, failure, record_rows
from suspid.units import Second

# A record that kills its process is given a second chance: the process may have died of something else.
TRIES = 2
# How far native code, which does not hear, may outlast the time limit before its process is ended.
GRACE = 1.25
TIME_UP = 86
# How often a worker looks whether its client is still there.
WATCH: Second = 1.0
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")
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
    with one_thread(job):
        return as_part(joined([rows_of(job, entry) for entry in chunk]))


def work_apart(job: Job, chunk: Sequence[Entry]) -> Part:
    """Return the same as `work`, record by record in a process of its own, whose death is a record's failure."""
    check_versions(job)
    done: list[Rows] = []
    deaths = 0
    while len(done) < len(chunk):
        before, code = len(done), 0
        for answer in _from_child(job, chunk[len(done) :]):
            if isinstance(answer, int):
                code = answer
            else:
                done.append(answer)
        deaths = deaths + 1 if len(done) == before else 1
        if len(done) < len(chunk) and (deaths == TRIES or code == TIME_UP):
            deaths = 0
            done.append(_death(job, chunk[len(done)], code))
    return as_part(joined(done))


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


def leave_with(parent: int) -> None:
    """End this process soon after its parent, which may be killed before it can say so; Ctrl-C is the parent's."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        threading.Thread(target=watch, daemon=True).start()


def child() -> None:
    """Be the process of its own of `work_apart`: read a job and records from stdin, write each record's rows."""
    answers = os.fdopen(os.dup(1), "wb")
    # Whatever else is printed must not stand between the answers.
    os.dup2(2, 1)
    job, chunk, parent = pickle.load(sys.stdin.buffer)
    leave_with(parent)
    with one_thread(job):
        for entry in chunk:
            pickle.dump(rows_of(job, entry), answers)
            answers.flush()


def _from_child(job: Job, chunk: Sequence[Entry]) -> Iterator[Rows | int]:
    """Yield the rows of each record that a process of its own lives to answer, then how it ended if it did not."""
    paths = os.pathsep.join(path for path in (os.environ.get("PYTHONPATH"), *sys.path) if path)
    process = subprocess.Popen(
        [sys.executable, "-c", "from suspid.fleet.work import child; child()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **ONE_THREAD, "PYTHONPATH": paths},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    with process:
        try:
            pickle.dump((job, list(chunk), os.getpid()), process.stdin)
            process.stdin.close()
            for _ in chunk:
                yield pickle.load(process.stdout)
            return
        except (EOFError, OSError, pickle.UnpicklingError):
            code = process.wait()
        finally:
            process.kill()
    yield code


def _death(job: Job, entry: Entry, code: int) -> Rows:
    if code == TIME_UP:
        reason = f"took longer than {job.time_limit:g} s, in native code that could not be interrupted"
        return failure(entry, None, job, "time", "TimeUp", reason)
    how = f"signal {-code}" if code < 0 else f"exit code {code}"
    reason = f"its process died {TRIES} times ({how}): out of memory, or a crash in native code"
    return failure(entry, None, job, "worker", "WorkerDied", reason)
